"""Moves that a controller times by its own law: no program of a plan is predicted to exceed a limit of the case."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import InfeasiblePlan
from cases.schema import Case, load_case
from identification.limits.limit import TOLERANCE, LimitCheck, LimitKind, Status
from identification.limits.proof import prove
from identification.motion.moves import StraightMove, fastest_profile, limits_along
from planner import plan
from planner.controller_limits import controlled, times_itself
from planner.families.ptp import LAW, PointToPointFamily, _law
from planner.families.settings import PointToPoint
from planner.plans.making import _proven
from planner.search.record import SolverStatus, StartRecord
from planner.search.solving import Start
from postprocessors.program import dialect, leaving_out
from postprocessors.reading import Reading
from postprocessors.writing import proven_program
from tests.bench.machines.description import write_machine
from tests.bench.portfolio import machine
from tests.helpers import tells
from tests.random_start import random_start

SECONDS, MOVES = 3.0, 8
CONTROLLERS = Path(__file__).parents[3] / "cases" / "hexapod" / "case.toml"
NOBODY = ("acceleration", "strut-acceleration", "sensor-force")  # of LinuxCNC nobody limits struts


def with_controllers(seed: int, folder: Path) -> Case:
    """A drawn hexapod with the controllers of the built-in one."""
    place = write_machine(folder, f"drawn_{seed}", machine(f"drawn_{seed}"))
    file = place / "case.toml" if place.is_dir() else place
    text = CONTROLLERS.read_text(encoding="utf-8")
    tables = text[text.index("[controller.sinumerik]") : text.index("# External setpoint")]
    file.write_text(f"{file.read_text(encoding='utf-8')}\n{tables}", encoding="utf-8")
    return load_case(file)


def counted(case: Case, controller: str, settings: PointToPoint) -> Iterator[LimitCheck]:
    """Limits of the program of a plan, but for what it leaves out."""
    made = plan(case, settings, SECONDS, starts=1, workers=1)
    language = dialect(controller)
    header = leaving_out([settings.without] if settings.without else [])
    name = f"moves{language.suffix}"
    program = proven_program(made.motion, case, language, name, header, accepted=NOBODY)
    return (check for check in program.proof.limits.checks if check.status is not Status.LEFT_OUT)


@pytest.mark.repeats
@pytest.mark.parametrize(
    ("seed", "controller", "without"),
    [
        (3, "sinumerik", None),
        (90201, "twincat", None),
        (90201, "linuxcnc", LimitKind.JERK),
        (2611282, "linuxcnc", LimitKind.JERK),  # of which no motion is inside by being shrunk
    ],
)
def test_no_peak_is_predicted_beyond_its_limit(seed: int, controller: str, without: str | None, tmp_path: Path):
    """Struts of these machines are slower than their poses: a controller that accelerates harder than planned shows."""
    case = with_controllers(seed, tmp_path)
    checks = [*counted(case, controller, PointToPoint(moves=MOVES, controller=controller, without=without))]
    assert any(check.kind is LimitKind.STRUT_ACCELERATION and check.ratio > 0.7 for check in checks)
    for check in checks:
        assert check.ratio <= 1.0 + TOLERANCE, check.sentence()


def test_an_exploration_that_only_slower_accelerations_keep_inside_is_no_plan(hexapod_case: Case):
    """As it stands it is well inside; the controller would make it with accelerations that struts do not bear."""
    box = hexapod_case.limits.motion
    weak = hexapod_case.with_reserve(1.0 - 0.6 * box.acceleration[2] / box.strut_acceleration_m_s2)
    case, step_time = controlled(weak, "linuxcnc")
    free = PointToPointFamily.of(case, MOVES, SECONDS, own_law=True)
    start = free.shrunk(random_start(free, np.random.default_rng(2), lambda _: 0.0), 0.3)
    assert prove(free.motion(start), case).kept
    record = StartRecord(
        seed=5, refined=False, logdet=0.0, criterion_value=0.0, solver=SolverStatus.NOT_RUN, converged=False,
        iterations=0, seconds=0.0,
    )  # fmt: skip
    with pytest.raises(InfeasiblePlan) as caught:
        _proven(Start(record, start, free, 1.0, start, 0.0), case, weak, step_time)
    assert tells(str(caught.value), "strut acceleration", "controller", "limits.motion")


def test_only_a_controller_that_accelerates_by_its_set_up_times_moves_itself(hexapod_case: Case, tmp_path: Path):
    assert times_itself(hexapod_case, "sinumerik")
    assert times_itself(hexapod_case, None)  # a SINUMERIK or TwinCAT may execute them
    assert not times_itself(hexapod_case, "setpoints")
    assert not times_itself(load_case("ur10_wrist"), "urscript")  # whose programs state accelerations
    drawn = load_case(write_machine(tmp_path, "drawn_3", machine("drawn_3")))
    assert not times_itself(drawn, None)  # for LinuxCNC, which would not limit the jerk, such moves are timed paths


@pytest.mark.parametrize("controller", ["sinumerik", "linuxcnc"])
def test_moves_of_such_a_controller_are_planned_as_it_makes_them(controller: str, hexapod_case: Case):
    """In the same times, with accelerations and jerks less by what a plan leaves of each limit."""
    case = controlled(hexapod_case, controller)[0]
    by = dialect(controller).guarantees(Reading("moves", (), 0), case)
    family = PointToPointFamily.of(case, MOVES, SECONDS, times_itself(hexapod_case, controller))
    start = random_start(family, np.random.default_rng(2), lambda _: 0.0)
    slow = family.shrunk(start, 0.7)
    for move in family.refined(slow).motion(slow).parts:
        assert isinstance(move, StraightMove)
        executed = by.lasting(move)
        assert executed.duration == pytest.approx(move.duration, rel=1e-7)
        assert executed.profile.acceleration >= move.profile.acceleration
        assert executed.profile.acceleration == pytest.approx(move.profile.acceleration / LAW, rel=2e-3)
        assert executed.profile.peak_velocity == pytest.approx(move.profile.peak_velocity, rel=2e-3)
    at = np.linspace(0.0, SECONDS, 500)
    free, lawful = (each.motion(slow).at(at).accelerations for each in (family, family.refined(slow)))
    assert np.abs(lawful).max() > 1.2 * np.abs(free).max()


def test_where_leading_coordinates_are_chosen_they_reach_their_limits(hexapod_case: Case):
    family = PointToPointFamily.of(hexapod_case, MOVES, SECONDS, own_law=True)
    start = family.shrunk(random_start(family, np.random.default_rng(2), lambda _: 0.0), 0.7)
    led = family.led_by(family.lawful(start))
    assert len(family.layout(hexapod_case, 1.0 - LAW).rows) == 2
    *_, reached = led.layout(hexapod_case, 1.0 - LAW).rows
    assert reached.equal == pytest.approx(LAW)
    assert len(reached.upper) >= MOVES  # jerks of all, accelerations of those that hold them
    assert reached.values(family.lawful(start)) == pytest.approx(LAW, abs=1e-8)
    assert reached.values(start).max() < 0.9  # slower than the law


@pytest.mark.parametrize("jerk_limited", [True, False])
def test_the_law_is_the_fastest_within_the_limits_but_for_its_speed(jerk_limited: bool):
    draw = np.random.default_rng(4)
    limits = np.array([[0.5, 0.5, 1.0], [6.0, 6.0, 20.0], [100.0, 120.0, 500.0]])[: 3 if jerk_limited else 2]
    law = _law(tuple(map(tuple, limits)))
    holding = set()
    for _ in range(50):
        way = draw.uniform(-1.0, 1.0, 3) * draw.choice([1e-3, 0.02, 0.2])
        velocity, acceleration, *jerk = limits_along(np.abs(way), *limits)
        slower = fastest_profile(1.0, velocity * draw.uniform(0.1, 1.0), acceleration, *jerk)
        times = law(np.append(way, slower.duration)).full()[:, 0]
        assert times == pytest.approx([slower.jerk_time, slower.hold_time, slower.cruise_time], abs=1e-8)
        holding.add(slower.hold_time > 0.0)
    assert len(holding) == (2 if jerk_limited else 1)
