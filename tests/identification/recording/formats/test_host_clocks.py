"""Stamps of hosts: late, of few digits, repeated, as dates; the body comes out as with a perfect clock."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import Code, RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from identification.finding import Finding
from identification.identify import identify
from identification.recording.formats.clocks import Even, Unsteady, evened
from identification.recording.recording import Recording, read
from identification.samples.sample_checks import bridged
from tests.helpers import one_line, seeds, tells
from tests.identification.recording.formats.loaded_hexapod import CASE, CENTRE, MASS, Array, Run, run
from tests.identification.recording.formats.runs import case_with, written

STEP = 2e-3
T = STEP * np.arange(2000)
RUN = run(T)
NAMES = ["t_s", *STRUTS, *BAR_FORCES]


def table(stamps: list[str], of: Run = RUN) -> str:
    numbers = np.hstack([of.struts * 1e3, of.forces])
    rows = (",".join([stamp, *(f"{v:.6f}" for v in row)]) for stamp, row in zip(stamps, numbers, strict=True))
    return "\n".join([",".join(NAMES), *rows]) + "\n"


def seconds(stamps: Array, digits: int = 6) -> list[str]:
    return [f"{stamp:.{digits}f}" for stamp in stamps]


def part(rows: Array) -> Run:
    return replace(RUN, t=RUN.t[rows], struts=RUN.struts[rows], forces=RUN.forces[rows])


def of_clock(recording: Recording) -> list[Finding]:
    return [finding for finding in recording.findings if finding.kind == "clock"]


def late(share: float, seed: int) -> Array:
    """Stamps that a host gives when it has time: late, in the mean by a share of a step."""
    return T + share * STEP * np.random.default_rng(seed).exponential(size=len(T))


def busy(seed: int) -> Array:
    """Stamps of a host that now and then does something else for 20 samples, which it then stamps all at once."""
    stamps = T.copy()
    for first in np.random.default_rng(seed).choice(np.arange(100, 1900, 60), 6, replace=False):
        stamps[first : first + 20] = T[first + 20]
    return stamps + 1e-7 * np.random.default_rng(seed).random(len(T))


STAMPS: dict[str, Callable[[int], Array]] = {
    "late": lambda seed: late(0.3, seed),
    "late by more than a step, some backwards": lambda seed: late(1.0, seed),
    "either way": lambda seed: T + 0.25 * STEP * np.random.default_rng(seed).normal(size=len(T)),
    "of two digits": lambda seed: np.floor((T + 1e-3 * seed) * 100.0) / 100.0,
    "of a busy host": busy,
}


@pytest.mark.parametrize("how", STAMPS)
def test_samples_are_at_equal_steps_whatever_the_host_stamps(how: str) -> None:
    for seed in range(5):
        even = evened(STAMPS[how](seed))
        assert isinstance(even, Even)
        assert even.step == pytest.approx(STEP, rel=max(5.0 * even.deviation, 1e-6))
        np.testing.assert_array_equal(even.numbers, np.arange(len(T)))
        assert np.ptp(even.t - T) < 0.3 * STEP


@pytest.mark.parametrize("spread", [0.01, 0.1, 0.3])
def test_lost_samples_are_counted_behind_stamps_that_stray(spread: float) -> None:
    """One in a hundred is lost: the step stays that of the recorder, which the mean of the stamps is not."""
    for seed in range(5):
        draw = np.random.default_rng(seed)
        numbers = np.flatnonzero((draw.random(4000) > 0.01) | (np.arange(4000) == 0))
        even = evened(STEP * numbers + spread * STEP * draw.normal(size=len(numbers)))
        assert isinstance(even, Even)
        assert even.clear
        assert even.step == pytest.approx(STEP, rel=1e-4)
        assert even.numbers[-1] == numbers[-1]
        assert np.mean(even.numbers != numbers) < (0.0 if spread == 0.01 else 0.02) + 1e-9


@pytest.mark.parametrize("how", ["lost", "without a force"])
def test_what_is_put_in_place_of_missing_samples_moves_as_the_machine_does(how: str, tmp_path: Path) -> None:
    """A straight line between neighbours would be 20 um off; accelerations, and so the mass, would show that."""
    missing = np.arange(50, 1950, 60)
    if how == "lost":
        kept = np.setdiff1d(np.arange(len(T)), np.r_[missing, missing[::3] + 1])  # sometimes two in a row
        text = table(seconds(T[kept]), part(kept))
    else:
        lines = table(seconds(T)).splitlines()
        for row in missing:
            fields = lines[1 + row].split(",")
            lines[1 + row] = ",".join([*fields[:8], "", *fields[9:]])
        text = "\n".join(lines) + "\n"
    recording = read(written(tmp_path, text), CASE)
    bad = recording.bad
    assert recording.drives is not None
    assert np.flatnonzero(bad).size >= len(missing)
    off = np.abs(bridged(recording.drives, bad) - RUN.struts)
    assert off.max() < 2e-6  # written to 1 nm
    line = np.interp(T, T[~bad], RUN.struts[~bad, 0]) - RUN.struts[:, 0]
    assert np.abs(line).max() > 10 * off.max()
    result, whole = (identify(each, CASE) for each in (recording, read(written(tmp_path, table(seconds(T))), CASE)))
    assert abs(result["m"].value - whole["m"].value) < whole["m"].reported
    assert result["m"].reported < 1.3 * whole["m"].reported


def test_lost_samples_that_stamps_hide_make_the_step_uncertain_by_as_much_as_it_is_wrong() -> None:
    """Of stamps of two digits nobody can tell the loss of one of five samples."""
    errors = []
    for seed in range(20):
        draw = np.random.default_rng(seed)
        numbers = np.flatnonzero((draw.random(7000) > 0.004) | (np.arange(7000) == 0))
        even = evened(np.floor((STEP * numbers + 0.5 * STEP * draw.normal(size=len(numbers))) * 100.0) / 100.0)
        if isinstance(even, Unsteady):  # they are off a line by too much
            assert "period_ms" in even.remedy
            continue
        assert not even.clear
        errors.append((even.step / STEP - 1.0) / even.deviation)
    assert len(errors) > 10
    assert np.median(np.abs(errors)) < 2.0


def test_a_period_that_is_stated_counts_and_stamps_say_what_was_lost() -> None:
    numbers = np.delete(np.arange(2000), [300, 301, 900])
    even = evened(1.001 * STEP * numbers, period=STEP)
    assert isinstance(even, Even)
    assert even.step == STEP
    assert even.written == pytest.approx(1.001 * STEP)
    np.testing.assert_array_equal(even.numbers, numbers)
    np.testing.assert_allclose(np.diff(even.t), STEP * np.diff(numbers))


def test_where_two_rates_meet_is_named() -> None:
    for rate in (1.02, 1.5, 0.5):
        stamps = np.r_[T[:1200], T[1199] + rate * STEP * np.arange(1, 801)]
        found = evened(stamps + 1e-5 * np.random.default_rng(0).normal(size=len(stamps)))
        assert isinstance(found, Unsteady)
        assert abs(found.row - 1200) < 120, rate
        assert not found.backwards


def test_stamps_that_repeat_at_no_one_rate_are_no_clock(tmp_path: Path) -> None:
    """Half of the run at another rate, and digits that are too few to say when: rows would stand at one instant."""
    stamps = np.concatenate([T[:1000], T[999] + 20.0 * (T[1000:] - T[999])])
    file = written(tmp_path, table(seconds(stamps, 2)))
    with pytest.raises(RecordingError) as error:
        read(file, CASE)
    assert error.value.code is Code.CLOCK
    assert "line 3, t_s" in str(error.value)
    assert "40 ms" in str(error.value)


def test_two_runs_in_one_file_are_named_with_the_first_row_of_the_second() -> None:
    for jitter in (0.0, 0.2):
        stamps = np.r_[T, T] + jitter * STEP * np.random.default_rng(0).random(4000)
        found = evened(stamps)
        assert isinstance(found, Unsteady)
        assert found.backwards
        assert found.row == 2000


def identified(recording: Recording) -> None:
    result = identify(recording, recording.case)
    for name, truth in (("m", MASS), ("xC", CENTRE[0]), ("zC", CENTRE[2])):
        assert abs(result[name].value - truth) < 4.0 * result[name].reported, name
    assert result["m"].reported < 0.04


def test_a_body_is_found_behind_stamps_of_a_host_and_the_jitter_is_stated(tmp_path: Path) -> None:
    kept = np.delete(np.arange(2000), [500, 501, 1400])
    recording = read(written(tmp_path, table(seconds(late(0.3, 1)[kept]), part(kept))), CASE)
    (said,) = of_clock(recording)
    assert said.severity == "note"
    assert said.quantity["time_stamps"]["step_ms"] == pytest.approx(2.0, rel=1e-4)
    assert said.quantity["time_stamps"]["rms_ms"] == pytest.approx(0.6, rel=0.1)
    assert recording.bad.sum() == 3
    identified(recording)


def test_stamps_of_two_digits_are_read_and_said_to_be_coarse(tmp_path: Path) -> None:
    recording = read(written(tmp_path, table(seconds(np.floor(T * 100.0 + 1e-6) / 100.0, 2))), CASE)
    assert np.ptp(recording.t - T) < 1e-6
    assert not recording.bad.any()
    (said,) = of_clock(recording)
    assert said.quantity["time_stamps"]["most_ms"] == pytest.approx(4.0, rel=0.3)


def german(t: float) -> str:
    ms = round(1e3 * t) + 86_400_000 - 2_000
    day, ms = divmod(ms, 86_400_000)
    return (
        f'"{5 + day:02d}.03.2024 {ms // 3_600_000:02d}:{ms // 60_000 % 60:02d}:{ms // 1000 % 60:02d},{ms % 1000:03d}"'
    )


def of_day(t: float) -> str:
    return german(t).strip('"').split()[1].replace(",", ".")


def iso(t: float) -> str:
    day = german(t)[1:3]
    return f"2024-03-{day}T{of_day(t)}+01:00"


def american(t: float) -> str:
    hour, rest = of_day(t).split(":", 1)
    return f"03/{german(t)[1:3]}/2024 {(int(hour) - 1) % 12 + 1}:{rest} {'AM' if int(hour) < 12 else 'PM'}"


@pytest.mark.parametrize("form", [german, of_day, iso, american])
def test_dates_and_times_of_day_go_on_after_midnight(form: Callable[[float], str], tmp_path: Path) -> None:
    recording = read(written(tmp_path, table([form(t) for t in T])), CASE)
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.forces, RUN.forces, atol=1e-6)


def test_a_date_that_is_none_is_named_with_its_line(tmp_path: Path) -> None:
    stamps = [iso(t) for t in T]
    stamps[1200] = "2024-03-05"
    with pytest.raises(RecordingError, match=r"line 1202, t_s: '2024-03-05' is not a time stamp like") as caught:
        read(written(tmp_path, table(stamps)), CASE)
    one_line(caught.value)


def test_a_run_dated_to_the_second_is_found_where_its_period_is_stated(tmp_path: Path) -> None:
    file = written(tmp_path, table([of_day(t)[:8] for t in T]))
    with pytest.raises(RecordingError, match=r"4 different values in 2000 rows; state recording\.clock\.period_ms"):
        read(file, CASE)
    recording = read(file, case_with(CASE, clock={"period_ms": 2.0}))
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    assert tells(str(of_clock(recording)[0]), "recording.clock.period_ms = 2 counts")


def test_a_period_that_contradicts_the_stamps_is_a_warning(tmp_path: Path) -> None:
    file = written(tmp_path, table(seconds(T)))
    recording = read(file, case_with(CASE, clock={"period_ms": 2.02}))
    assert recording.step == pytest.approx(2.02e-3)
    (said,) = of_clock(recording)
    assert said.severity == "warning"
    assert tells(str(said), "2.02", "2 ms apart", "2 %")


def test_stamps_of_another_kind_are_left_out_with_a_note(tmp_path: Path) -> None:
    """Stamps in another unit, of a clock that stands, or of nothing: where the period is stated they do not matter."""
    for stamps in (1e3 * T, 0.0 * T, np.random.default_rng(0).random(len(T))):
        recording = read(written(tmp_path, table(seconds(stamps))), case_with(CASE, clock={"period_ms": 2.0}))
        np.testing.assert_allclose(recording.t, T, atol=1e-9)
        (said,) = of_clock(recording)
        assert said.severity == "note"


def test_rows_that_are_there_twice_count_once(tmp_path: Path) -> None:
    rows = np.sort(np.r_[np.arange(2000), [400, 400, 1100]])
    recording = read(written(tmp_path, table(seconds(T[rows]), part(rows))), CASE)
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    assert tells(str(of_clock(recording)[0]), "3 rows repeat")
    assert recording.lines.place(1500) == "line 1505"


@pytest.mark.repeats
def test_samples_that_were_taken_when_their_stamps_say_are_interpolated(tmp_path: Path) -> None:
    """A program that sleeps between two samples: steps of 2.1 ms, each longer or shorter by 0.2 ms at random."""
    draw = np.random.default_rng(4)
    t = np.cumsum(np.maximum(2.1e-3 + 2e-4 * draw.normal(size=1900), 1e-3))
    true = run(t[t < 3.99])
    recording = read(written(tmp_path, table(seconds(true.t), true)), CASE)
    assert "interpolated" in str(of_clock(recording)[0])
    struts = run(recording.t + true.t[0]).struts  # time begins with the first sample
    assert np.abs(recording.drives - struts)[5:-5].max() < 2e-6
    identified(recording)


@seeds(4)
def test_a_recorder_that_loses_many_samples_for_a_while_keeps_its_rate(seed: int) -> None:
    """As many as four of ten in each of several stretches; no two rates."""
    draw, numbers = np.random.default_rng(seed), np.arange(3000)
    kept = draw.random(len(numbers)) > 0.01
    for first in draw.integers(0, 2700, 3):
        kept[first : first + 300] &= draw.random(300) > draw.uniform(0.05, 0.4)
    kept[0] = True
    even = evened(STEP * numbers[kept])
    assert isinstance(even, Even), even
    np.testing.assert_array_equal(even.numbers, numbers[kept])
    np.testing.assert_allclose(even.t, STEP * numbers[kept], atol=1e-9)


@pytest.mark.parametrize("pause", [1e3, 1e6, 1e12])
def test_a_pause_of_any_length_among_late_stamps_is_a_pause_or_refused(pause: float) -> None:
    """It took as much memory as the pause has steps."""
    stamps = late(0.3, 1)
    stamps[200:] += pause
    found = evened(stamps)
    if isinstance(found, Even):
        assert found.t[200] - found.t[199] == pytest.approx(pause, rel=1e-2)
        before, behind = np.diff(found.t[:200]), np.diff(found.t[200:])
        assert max(before.max(), behind.max()) < 1.5 * STEP
