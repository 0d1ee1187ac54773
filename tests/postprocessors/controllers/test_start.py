"""A program starts from home alone: what the real LinuxCNC does with the check, from home, beside it and elsewhere."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.controllers.linuxcnc import session
from postprocessors.program import Program, dialect
from postprocessors.writing import proven_program
from tests.postprocessors.changed_case import changed

pytestmark = pytest.mark.linuxcnc
ACCEPTED = ("jerk", "strut velocity", "strut acceleration")


def there_and_back(case: Case) -> Program:
    """A small move and back, as LinuxCNC gets it."""
    home, limits = case.need_motion("a test")
    far = home + 0.1 * limits.coordinates[1]
    share = [0.2 * limit for limit in (limits.rate, limits.acceleration, limits.jerk)]
    moves = StraightMove.fastest(home, far, *share), StraightMove.fastest(far, home, *share)
    return proven_program(Joined(moves), case, dialect("linuxcnc"), "p.ngc", (), accepted=ACCEPTED)


@pytest.fixture
def executed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[ControllerLog, dict[str, Any]]]:
    """Runs lines on a LinuxCNC whose machine stands at the home of a case: the log also where it stopped."""
    monkeypatch.setattr(session, "read_report", lambda _, folder: json.loads((folder / "status.json").read_text()))

    def run(lines: list[str], case: Case) -> tuple[ControllerLog, dict[str, Any]]:
        return session.one_session(session.Job(Path("p.ngc"), tuple(lines), case, 1.0, False), 10.0, 60.0)

    return run


def test_from_home_it_runs_and_takes_no_time_for_the_way_there(hexapod_case: Case, executed: Callable):
    program = there_and_back(hexapod_case)
    log, report = executed(program.text.split("\n"), hexapod_case)
    assert report["outcome"] == "done"
    assert np.ptp(log.poses, axis=0).max() > 1e-3
    crawls = [part.line for part in program.reading.stretches if getattr(part, "within", None) is not None]
    assert len(crawls) == 2
    assert not set(crawls) & set(log.lines.tolist())


def test_from_beside_home_it_gets_there_within_the_limits_of_acceleration_and_jerk(
    hexapod_case: Case, executed: Callable
):
    """What was proven of the crawl: second and third differences of the set points, cycle by cycle."""
    program = there_and_back(hexapod_case)
    beside = changed(
        hexapod_case,
        machine__home={"x_mm": 0.009, "y_mm": -0.004, "z_mm": 900.009, "a_deg": 0.009, "b_deg": 0.0, "c_deg": -0.009},
    )
    log, report = executed(program.text.split("\n"), beside)
    assert report["outcome"] == "done"
    home, limits = hexapod_case.need_motion("a test")
    arrived = int(np.argmax(np.all(np.abs(log.poses - home) < 1e-12, axis=1)))
    assert arrived > 100
    way = log.poses[: arrived + 1]
    for order, limit in ((2, limits.acceleration), (3, limits.jerk)):
        reached = np.abs(np.diff(way, order, axis=0)).max(axis=0) / log.period**order
        assert np.all(reached <= limit * 1.01), (order, reached / limit)


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("place", "said"), [("x_mm", "X is at 0.011"), ("z_mm", "Z is at 910"), ("c_deg", "C is at 0.011")]
)
def test_from_elsewhere_it_stops_with_a_message_and_nothing_moved(
    place: str, said: str, hexapod_case: Case, executed: Callable
):
    home = {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 900.0, "a_deg": 0.0, "b_deg": 0.0, "c_deg": 0.0}
    elsewhere = changed(hexapod_case, machine__home=home | {place: 910.0 if place == "z_mm" else 0.011})
    log, report = executed(there_and_back(hexapod_case).text.split("\n"), elsewhere)
    assert report["outcome"] == "error"
    assert "Not at home" in report["errors"][0]
    assert said in report["errors"][0]
    assert np.ptp(log.poses, axis=0).max() == 0.0


def test_a_coordinate_system_that_is_not_the_machines_own_stops_it(hexapod_case: Case, executed: Callable):
    log, report = executed(["G10 L2 P1 X0.5", *there_and_back(hexapod_case).text.split("\n")], hexapod_case)
    assert report["outcome"] == "error"
    assert "G54 is not zero" in report["errors"][0]
    assert np.ptp(log.poses, axis=0).max() == 0.0


def test_axes_of_the_machines_own_are_checked_too(executed: Callable):
    case = load_case("five_axis_table")
    text = there_and_back(case).text.split("\n")
    assert executed(text, case)[1]["outcome"] == "done"
    joints = [joint.model_dump(exclude_none=True) for joint in case.machine.chain.joints]
    joints[4]["home_deg"] = 5.0
    log, report = executed(text, changed(case, machine__chain__joints=joints))
    assert report["outcome"] == "error"
    assert "C is at 5" in report["errors"][0]
    assert np.ptp(log.poses, axis=0).max() == 0.0
