"""M62 and M63 switch with the next motion, M64 and M65 at once; the trigger tells the excitation from all else."""

import pytest

from cases.base.errors import ProgramError
from cases.schema import Case
from postprocessors.reading import Still, Stretch, Timed, Untimed
from tests.helpers import one_line
from tests.postprocessors.programs import parts, proof, there_and_back, timed, typed

PATH = timed(there_and_back())


def on(stretches: tuple[Stretch, ...]) -> list[tuple[str, bool]]:
    """Kind and trigger of each stretch after the first move home."""
    return [(type(s).__name__, s.trigger) for s in stretches[1:]]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (f"M64 P0\nG4 P1\n{PATH}\nM65 P0\nG4 P1", [("Still", True), ("Timed", True), ("Still", False)]),
        (
            f"M62 P0\nG4 P1\n{PATH}\nM63 P0\nG4 P1\nG1 X5 F100",
            [("Still", False), ("Timed", True), ("Still", True), ("Untimed", False)],
        ),
        (f"M62 P0\n{PATH}\nM63 P0\nG1 X5 F100", [("Timed", True), ("Untimed", False)]),
        (f"M62 P0\n{PATH}\nM63 P0\nG4 P0\n{PATH}", [("Timed", True), ("Still", True), ("Timed", False)]),
        (f"M64 P0\nM65 P0\n{PATH}", [("Timed", False)]),
        (f"M62 P0\nM63 P0\n{PATH}", [("Timed", False)]),
        (f"M62 P0\nM65 P0\n{PATH}", [("Timed", True)]),
    ],
)
def test_queued_switches_wait_for_motion_and_the_others_do_not(body: str, expected: list, hexapod_case: Case):
    assert on(parts(typed(body), hexapod_case)) == expected


@pytest.mark.parametrize("line", ["M62 P0", "M63 P0"])
def test_a_queued_switch_needs_a_next_motion(line: str, hexapod_case: Case):
    with pytest.raises(ProgramError, match=r"line 4: .*waits.*never") as caught:
        parts(typed(f"{line}\nG4 P1"), hexapod_case)
    one_line(caught.value)


@pytest.mark.parametrize("size", [0.002, 2.0])
def test_a_queued_switch_inside_a_path_is_refused_since_the_path_does_not_stop_for_it(size: float, hexapod_case: Case):
    lines = there_and_back(40, size)
    with pytest.raises(ProgramError, match=r"line 26: .*middle of a path; .*at rest"):
        parts(typed(timed([*lines[:20], "M62 P0", *lines[20:]])), hexapod_case)


def test_a_switch_at_once_inside_a_path_makes_two_paths_each_at_rest_at_its_ends(hexapod_case: Case):
    lines = there_and_back(20)
    _, first, second = parts(typed(timed([*lines[:10], "M64 P0", *lines[10:]])), hexapod_case)
    assert isinstance(first, Timed)
    assert isinstance(second, Timed)
    assert [first.trigger, second.trigger] == [False, True]
    for path in (first, second):
        ends = path.points.at([0.0, path.points.duration])
        assert abs(ends.rates).max() < 1e-12
        assert abs(ends.accelerations).max() < 1e-9


def test_only_motion_with_the_trigger_on_counts_as_excitation(hexapod_case: Case):
    body = f"G4 P1\nM64 P0\nG4 P2\n{PATH}\nG4 P3\nM65 P0\n{PATH}"
    result = proof(typed(body), hexapod_case)
    assert result.excitation == pytest.approx(1.0)
    assert result.duration == pytest.approx(1.0 + 1 + 2 + 3 + 1.0)
    kinds = [type(s) for s in parts(typed(body), hexapod_case)]
    assert kinds == [Untimed, Still, Still, Timed, Still, Timed]
