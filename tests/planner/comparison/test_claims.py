"""What a validation claims: which method is better, and what is off for which reason."""

from types import SimpleNamespace

from planner.comparison.claims import claims_of, off_rows
from planner.comparison.error_budget import MODE
from planner.comparison.trials import trials
from tests.planner.comparison.excitations import CASE, FOUND, NO_POSE_ERROR, brisk


def test_what_is_off_is_named_with_its_cause():
    """A soft structure makes forces too large: nothing else is to blame."""
    heavy = FOUND.model_copy(update={"mode_Hz": 30.0} | NO_POSE_ERROR)
    found = list(trials(brisk(CASE), (0,), heavy))
    rows = off_rows(found)
    assert rows
    assert {row[-1] for row in rows} == {MODE}
    (inside,) = [f for f in claims_of(found) if f.claim.startswith("mass, centre")]
    assert not inside.holds
    assert f"{MODE} ({len(rows)})" in inside.figures
    assert off_rows(list(trials(brisk(CASE), (0,), None))) == []


def claimed(
    ours: float,
    theirs: float,
    seconds: tuple[float, float],
    method: str,
    robust: tuple[float, float] = (0.0, 0.0),
    true: tuple[float, float] | None = None,
) -> list[bool]:
    """Whether ptp's standard deviations are found to be smaller: by (28), with noise that has memory, and in truth."""

    def told(plain: float, other: float) -> SimpleNamespace:
        return SimpleNamespace(std=plain, std_robust=other, reported=max(plain, other))

    def row(name: str, plain: float, other: float, t: float, k0: float, true: dict[str, float]) -> SimpleNamespace:
        estimate = SimpleNamespace(physical={"m": told(plain, other), "k0": told(k0, 0.0)})
        return SimpleNamespace(method=name, weights=0, estimate=estimate, duration=t, truth={}, scatter=true)

    rows = [
        row("ptp", ours, robust[0], seconds[0], 0.001, dict.fromkeys(("m", "k0"), true[0]) if true else {}),
        row(method, theirs, robust[1], seconds[1], 0.01, dict.fromkeys(("m", "k0"), true[1]) if true else {}),
    ]
    return [found.holds for found in claims_of(rows)]


def test_a_method_is_better_only_where_all_its_deviations_are_smaller_in_no_more_time():
    assert claimed(0.1, 0.2, (12.0, 12.0), "D9N") == [True, True]
    assert claimed(0.2, 0.1, (12.0, 12.0), "D9N") == [False, False]
    assert claimed(0.1, 0.2, (12.5, 12.0), "D9N") == [False, False]
    assert claimed(0.1, 0.2, (12.03, 12.0), "D9N") == [True, True]


def test_noise_with_memory_is_another_question():
    assert claimed(0.1, 0.2, (12.0, 12.0), "D9N", (0.5, 0.4)) == [True, False]
    assert claimed(0.2, 0.1, (12.0, 12.0), "D9N", (0.3, 0.4)) == [False, True]


def test_true_deviations_are_another_one():
    equal, times = (0.3, 0.3), (12.0, 12.0)
    assert claimed(0.1, 0.2, times, "D9N", equal, (0.4, 0.5)) == [True, False, True]
    assert claimed(0.1, 0.2, times, "D9N", equal, (0.5, 0.4)) == [True, False, False]


def test_against_standing_still_the_measuring_time_counts():
    assert claimed(0.2, 0.1, (12.0, 1000.0), "Q5M") == [True]
    assert claimed(0.2, 0.1, (12.0, 12.0), "Q5M") == [False]
