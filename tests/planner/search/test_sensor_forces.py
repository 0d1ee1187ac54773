"""Where heavy payloads bring the sensors close to their range, the motion is shaped by that and not merely shrunk."""

import numpy as np
import pytest

import planner.search.problem as problem_module
from cases.schema import Case, load_case
from identification.estimation.criteria import box_middle, reference_scaling
from identification.limits.limit import LimitKind
from identification.limits.proof import prove
from identification.limits.sensor_loads import SHARE, Loads
from identification.model.model import identification_model
from identification.motion.motion import Motion, rotation_motion
from planner.families.family import Family
from planner.families.fourier import FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.families.states import state_size
from planner.search.problem import build_program, near_limits, state_limits
from planner.search.solving import Start, Task, run_start
from tests.postprocessors.changed_case import changed
from tests.random_start import random_start

MODEL = identification_model(load_case("hexapod"), 0)
SCALING = reference_scaling(load_case("hexapod"), MODEL)


@pytest.fixture
def weak(hexapod_case: Case) -> Case:
    """Standing still with five payloads uses a third of what its sensors may carry, a fast motion all of it."""
    return changed(hexapod_case, sensors__range_N=1000.0)


def family_of(case: Case, name: str) -> Family:
    if name == "fourier":
        return FourierFamily(2, 1.5, 1, *box_middle(case))
    if name == "ptp":
        return PointToPointFamily.of(case, 8, 3.0)
    return SplineFamily.of(case, 20, 2.0)


@pytest.mark.parametrize("name", ["fourier", "ptp", "spline"])
def test_rows_of_sensor_forces_are_newtons_and_eulers(name: str, weak: Case):
    """At the states at which limits are constrained: what the optimiser limits is what the proof proves."""
    some = family_of(weak, name)
    problem = build_program(weak, MODEL, some, SCALING, 0.0)
    start = random_start(some, np.random.default_rng(7), problem.worst)
    states = problem.rows[-1].states.at(start).reshape(-1, state_size(6))
    pose, rates, accelerations = states[:, :6], states[:, 6:12], states[:, 12:18]
    motion = Motion(np.arange(float(len(pose))), pose, rates, accelerations, np.zeros_like(pose))
    kernels = [kernel for kind, _, kernel in state_limits(weak, (0, 5)) if kind is LimitKind.SENSOR_FORCE]
    forces = Loads.of(weak).forces(motion, rotation_motion(motion), accelerations[:, :3]).reshape(len(pose), -1, 6)
    for kernel, count in zip(kernels, (0, 5), strict=True):
        shares = kernel.values(states)
        assert np.allclose(shares, forces[:, count] / (SHARE * 1000.0), rtol=1e-9, atol=1e-9)


def test_the_heaviest_load_is_limited_where_it_comes_close_and_none_where_it_does_not(weak: Case, hexapod_case: Case):
    assert [kind for kind, *_ in near_limits(weak)].count(LimitKind.SENSOR_FORCE) >= 1
    strong = changed(hexapod_case, sensors__range_N=100_000.0)
    boundless = hexapod_case.model_copy(update={"sensors": hexapod_case.sensors.model_copy(update={"range_N": None})})
    for case in (strong, boundless):
        assert LimitKind.SENSOR_FORCE not in [kind for kind, *_ in near_limits(case)]


def explored_and_refined(case: Case, name: str) -> Start:
    first = run_start(Task(case, 0, family_of(case, name), "D", seed=1))
    return first if first.record.refined else run_start(Task(case, 0, first.family, "D", 1, begin=first.begin))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fourier", "ptp", "spline"])
def test_a_load_that_binds_shapes_the_motion(name: str, weak: Case, monkeypatch: pytest.MonkeyPatch):
    shaped = explored_and_refined(weak, name)
    motion = shaped.family.motion(shaped.unknowns)
    report = prove(motion, weak, 1000.0)
    assert report.kept
    (force,) = (c for c in report.checks if c.kind == "sensor force")
    assert force.ratio > 0.9
    assert "5 payloads" in force.name
    monkeypatch.setattr(
        problem_module,
        "near_limits",
        lambda case: tuple(g for g in near_limits(case) if g[0] is not LimitKind.SENSOR_FORCE),
    )
    shrunk = explored_and_refined(weak, name)
    assert shaped.record.logdet > shrunk.record.logdet + 0.5  # of ten parameters: each is known at least 2.5 % better
