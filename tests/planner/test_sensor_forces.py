"""Where heavy payloads bring the sensors close to their range, the motion is shaped by that and not merely shrunk."""

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

import planner.search.solving as solving
from cases.schema import Case
from identification.limited import rotation_motion
from identification.limits import LimitCheck, LimitReport, Status, prove
from identification.model import identification_model
from identification.motion import Motion
from identification.overload import SHARE, load_shares, sensor_forces
from identification.reference import reference_scaling
from planner.families.family import Family, box_middle
from planner.families.fourier import COARSE, FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.plan import Plan
from planner.planning import STAGES
from planner.request import Request
from planner.search.problem import build_problem
from planner.search.solving import Start, Task, closest_load, run_start
from tests.postprocessors.changed_case import changed


@pytest.fixture
def weak(hexapod_case: Case) -> Case:
    """Standing still with five payloads uses a third of what its sensors may carry, a fast motion all of it."""
    return changed(hexapod_case, sensors__range_N=1000.0)


def family_of(case: Case, name: str) -> Family:
    if name == "fourier":
        return FourierFamily(2, 1.5, 1, *box_middle(case), COARSE)
    if name == "ptp":
        return PointToPointFamily.of(case, 8, 3.0)
    return SplineFamily.of(case, 20, 2.0)


@pytest.mark.parametrize("name", ["fourier", "ptp", "spline"])
def test_rows_of_sensor_forces_are_newtons_and_eulers(name: str, weak: Case):
    """At the states at which limits are held, with each load: what the optimiser limits is what the proof proves."""
    some = family_of(weak, name)
    model = identification_model(weak, 0)
    problem = build_problem(weak, model, some, reference_scaling(weak, model))
    start = solving.random_start(7, some, problem)
    before = problem.limit_shares(start)
    loaded = problem.with_loads(weak, (5,)).with_loads(weak, (0, 5))
    assert loaded.loads == (5, 0)
    shares = loaded.limit_shares(start)
    assert np.allclose(shares[: len(before)], before)
    critical = loaded.sampling.critical
    states = [m.T for m in ca.Function("s", [loaded.unknowns], critical.each)(start)]
    pose, rates, accelerations = (np.array(s.full()) for s in states)
    motion = Motion(np.arange(float(len(pose))), pose, rates, accelerations, np.zeros_like(pose))
    for k, count in enumerate((5, 0)):
        forces = sensor_forces(*rotation_motion(motion), accelerations[:, :3], weak.body(count), weak)
        rows = shares[len(before) + 6 * k : len(before) + 6 * (k + 1)]
        assert np.allclose(rows, np.abs(forces.T) / (SHARE * 1000.0), rtol=1e-9, atol=1e-9)


def explored_and_refined(case: Case, name: str) -> tuple[Start, Start]:
    stages = STAGES[name]
    first = run_start(Task(case, 0, family_of(case, name), "D", "ipopt", stages[0], seed=1))
    return first, run_start(Task(case, 0, first.family, "D", "ipopt", stages[1], 1, first.begin))


@pytest.mark.parametrize(
    "name", ["fourier", pytest.param("ptp", marks=pytest.mark.slow), pytest.param("spline", marks=pytest.mark.slow)]
)
def test_a_load_that_binds_shapes_the_motion(name: str, weak: Case, monkeypatch: pytest.MonkeyPatch):
    explored, shaped = explored_and_refined(weak, name)
    assert closest_load(weak, explored.family.motion(explored.begin)) == (5,)
    motion = shaped.family.motion(shaped.unknowns)
    report = prove(motion, weak, 1000.0)
    assert report.kept
    (force,) = (c for c in report.checks if c.name.startswith("sensor force"))
    assert force.ratio > 0.9
    assert "5 payloads" in force.name
    monkeypatch.setattr(solving, "closest_load", lambda case, motion: ())
    shrunk = explored_and_refined(weak, name)[1]
    assert shaped.logdet > shrunk.logdet + 1.0  # of ten parameters: each is known at least 5 % better


def test_sensors_with_range_enough_add_no_rows(hexapod_case: Case):
    some = family_of(hexapod_case, "fourier")
    model = identification_model(hexapod_case, 0)
    problem = build_problem(hexapod_case, model, some, reference_scaling(hexapod_case, model))
    motion = some.motion(solving.random_start(1, some, problem))
    assert closest_load(hexapod_case, motion) == ()
    assert problem.with_loads(hexapod_case, ()) is problem
    boundless = hexapod_case.model_copy(update={"sensors": hexapod_case.sensors.model_copy(update={"range_N": None})})
    assert closest_load(boundless, motion) == ()


def test_shares_grow_with_what_is_mounted(weak: Case):
    some = family_of(weak, "fourier")
    motion = some.motion(np.zeros(some.unknowns * 6)).at(np.zeros(1))
    shares = load_shares(motion, weak)
    assert len(shares) == 6
    assert np.all(np.diff(shares) > 0.0)


def test_the_plan_says_which_load_bound_it():
    check = LimitCheck("sensor force (sensor 3, 5 payloads)", 800.0, 800.0, "N", 0.999, 1.0, Status.PROVEN)
    found = SimpleNamespace(
        motion=None, starts=(), family="ptp", settings={}, request=Request("hexapod", family="ptp"), noise_note=(),
        limits=LimitReport((check,)),
    )  # fmt: skip
    (note,) = vars(Plan)["notes"].fget(found)
    assert note.startswith("sensor force (sensor 3, 5 payloads) shapes the motion")
