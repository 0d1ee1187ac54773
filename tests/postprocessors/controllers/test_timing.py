"""Dwells, switches and short blocks of programs that run faster than the clock."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import HexciteError
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.controllers.linuxcnc import timing
from postprocessors.reading import Reading, Still, Untimed
from tests.helpers import tells
from tests.postprocessors.controllers.runs import PROGRAM, log_of
from tests.postprocessors.programs import read_linuxcnc, typed

FILE = Path("a.ngc")


def read(text: str) -> Reading:
    return read_linuxcnc(text, "a.ngc")


@pytest.mark.parametrize(
    ("line", "seconds"),
    [
        ("G04 P1", 1.0),
        ("G4 P.5", 0.5),
        ("G4P1", 1.0),
        ("g4 P1", 1.0),
        (" N7 G4 P1", 1.0),
        ("G 4 P1 (c) ;d", 1.0),
        ("M0", 0.0),
    ],
)
def test_a_dwell_or_a_stop_alone_in_its_line_is_timed_in_cycles(line: str, seconds: float) -> None:
    text = typed(line)
    assert timing.with_dwells(FILE, text.split("\n"), read(text))[3] == f"o<dwell> call [{seconds:.6f}]"


def test_a_dwell_beside_other_words_is_refused() -> None:
    text = typed("G4 P1 G0 X1")
    with pytest.raises(HexciteError, match=r"a\.ngc, line 4: dwell .*; .*G4 P<seconds>"):
        timing.with_dwells(FILE, text.split("\n"), read(text))


def test_only_dwells_change_in_the_copy_that_is_run() -> None:
    lines, dwells = PROGRAM.split("\n"), {5: 0.25, 11: 0.1, 12: 0.1, 14: 0.05}
    copy = timing.with_dwells(FILE, lines, read(PROGRAM))
    assert {k: copy[k - 1] for k in dwells} == {k: f"o<dwell> call [{s:.6f}]" for k, s in dwells.items()}
    assert [line for k, line in enumerate(copy, 1) if k not in dwells] == [
        line for k, line in enumerate(lines, 1) if k not in dwells
    ]


def test_short_blocks_are_run_slower() -> None:
    blocks = ["G1 X1 F60000", "G64 P1 Q0", "G93", "G1 X2 F6000 (F60000)", "G1 X3 F3000", "G94 F90000"]
    assert timing.fastest(read(typed("\n".join(blocks)))) == pytest.approx(0.010 / timing.BLOCK)
    assert timing.fastest(read(typed("G1 X1 F60000"))) == np.inf


def moves_and_dwells(*stretches: tuple[int, float | None, bool], left_on: int = 0) -> Reading:
    """A move in each line without seconds, else a dwell; with the state of the trigger."""
    pose = np.zeros(6)
    return Reading(
        "p",
        tuple(
            Untimed(line, None, pose, None, True, None, on) if seconds is None else Still(line, seconds, on)
            for line, seconds, on in stretches
        ),
        len(stretches),
        left_on=left_on,
    )


@pytest.mark.parametrize(("cycles", "ok"), [(100, False), (101, True), (130, True), (20142, True)])
def test_a_dwell_is_proven_by_the_cycles_without_motion(cycles: int, ok: bool) -> None:
    log = log_of([1] * 5 + [0] * cycles + [3] * 5)
    reading = moves_and_dwells((1, None, False), (2, 0.1, False), (3, None, False))
    problem = timing.dwell_problem(log, reading, (0, len(log.lines)))
    if ok:
        assert problem is None
    else:
        assert problem is not None
        assert tells(problem, "line 2: ", f"{(cycles - 1) / 1000:.3f} s", "0.100 s")


def test_dwells_next_to_no_motion_are_proven_within_the_run() -> None:
    log = log_of([0] * 150 + [2] * 5 + [0] * 150)
    reading = moves_and_dwells((1, 0.1, False), (2, None, False), (3, 0.1, False))
    assert timing.dwell_problem(log, reading, (40, 265)) is None
    assert "line 1: " in str(timing.dwell_problem(log, reading, (60, 265)))
    assert "line 3: " in str(timing.dwell_problem(log, reading, (40, 245)))


@pytest.mark.parametrize("late", [0, 1, 107])
def test_a_motion_that_waits_for_its_next_block_is_found(late: int) -> None:
    """A block that comes too late is told from a dwell, which has a line of its own between two of motion."""
    lines = np.repeat([7, 0, 8, 0, 10], [50, late, 50, 300, 50])
    log = ControllerLog("none", 1e-3, np.zeros((len(lines), 6)), np.zeros((len(lines), 6)), lines > 0, lines)
    problem = timing.supply_problem(log)
    assert (problem is None) == (late == 0)
    if problem is not None:
        assert tells(problem, "line 8: ", f"{1e-3 * late:.3f} s")


def standing(phases: list[tuple[int, bool]]) -> ControllerLog:
    """Motion in line 1, phases of standstill with the trigger as stated, motion in line 9."""
    count = sum(n for n, _ in phases)
    lines = np.array([1] * 5 + [0] * (count + 1) + [9] * 5)
    trigger = np.array([False] * 5 + [on for n, on in phases for _ in range(n)] + [False] * 6)
    struts = np.ones((len(lines), 6))
    struts[:5] += 0.01 * np.arange(5)[:, None]
    return ControllerLog("none", 1e-3, struts, np.zeros((len(lines), 6)), trigger, lines)


FEW = timing.FEWEST_CYCLES
POSE = moves_and_dwells((1, None, False), (2, 0.1, False), (4, 0.2, True), (7, 0.05, False), (9, None, False))


def test_dwells_are_as_long_in_the_log_as_programmed_each_with_its_trigger() -> None:
    log = standing([(130, False), (204, True), (90, False)])
    found = timing.without_surplus(log, POSE, (0, len(log.lines)))
    np.testing.assert_array_equal(np.flatnonzero(found.trigger), 5 + 100 + np.arange(200))
    assert np.count_nonzero(found.lines == 0) == 350 + 1
    assert found.left_out == 30 + 4 + 40 == len(log.lines) - len(found.lines)
    np.testing.assert_array_equal(found.drives[:6], log.drives[:6])


@pytest.mark.parametrize(
    ("phases", "ok"),
    [
        ([(100, False), (200, True), (50, False)], True),
        ([(2, False), (298, True), (50, False)], False),  # the trigger comes on before the machine has settled
        ([(150, False), (150, True), (50, False)], False),
        ([(100, False), (250, True)], False),  # the sum is right, and the last dwell was skipped
    ],
)
def test_each_dwell_is_proven_with_its_own_trigger(phases: list[tuple[int, bool]], ok: bool) -> None:
    log = standing(phases)
    problem = timing.dwell_problem(log, POSE, (0, len(log.lines)))
    assert (problem is None) == ok, problem


def test_what_the_log_does_not_show_as_programmed_stays() -> None:
    for phases in ([(130, False)], [(130, False), (204, True), (90, False), (10, True)]):
        log = standing(phases)
        assert timing.without_surplus(log, POSE, (0, len(log.lines))).left_out == 0
    moved = standing([(130, False), (204, True), (90, False)])
    struts = moved.drives.copy()
    struts[5 + 60] += 1e-6
    creeping = ControllerLog("none", 1e-3, struts, moved.poses, moved.trigger, moved.lines)
    assert timing.without_surplus(creeping, POSE, (0, len(moved.lines))).left_out == 4 + 40


def test_a_switch_between_motions_takes_few_cycles_however_late_it_came() -> None:
    between = moves_and_dwells((1, None, False), (3, 0.0, True), (9, None, False))
    for late in (FEW, 60, 700):
        log = standing([(late, True), (FEW, False)])
        found = timing.without_surplus(log, between, (0, len(log.lines)))
        assert (found.trigger.sum(), np.count_nonzero(found.lines == 0)) == (FEW, 2 * FEW + 1)
