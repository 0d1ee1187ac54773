"""Forces of sensors in struts in the proof: the regressor's, bounds that no motion passes, limits that bind."""

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.limits.limit import LimitKind
from identification.limits.proof import of_mechanics, prove, prove_at
from identification.limits.sensor_loads import SHARE, Loads
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from identification.model.parameters import nominal_parameters
from identification.motion.motion import Motion, Standstill
from planner.families.ptp import PointToPointFamily
from planner.families.states import state_size
from planner.search.problem import near_limits, state_limits
from planner.search.solving import Task, run_start
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.reading import Reading
from tests.helpers import HOME, Harmonic

CASE = load_case("strut_sensors")
LIMITS = CASE.limits.motion
KINDS = {
    "drive": {},
    "platform": {"at": "platform"},
    "viscous": {"viscous_friction_Nms": (8.0, 5.0)},
    "friction": {"at": "platform", "viscous_friction_Nms": (8.0, 5.0), "coulomb_friction_Nm": (9.0, 4.0)},
}


def of(kind: str, newtons: float = 5000.0) -> Case:
    """The case with sensors of some range, as such a kind of sensors in struts."""
    assert CASE.sensor_frame.struts is not None
    struts = CASE.sensor_frame.struts.model_copy(update=KINDS[kind])
    frame = CASE.sensor_frame.model_copy(update={"struts": struts})
    sensors = CASE.sensors.model_copy(update={"range_N": newtons})
    return CASE.model_copy(update={"sensor_frame": frame, "sensors": sensors})


def forces(case: Case, pose: np.ndarray, rates: np.ndarray, accelerations: np.ndarray) -> np.ndarray:
    """By the regressor that the planner differentiates, shape (n, channels)."""
    model = identification_model(case, 6)
    matrices = over_samples(model.coordinate_regressor, pose, rates, accelerations)[0]
    return np.hstack([matrices @ nominal_parameters(model, body) for body in case.bodies])


def load_shares(motion: Motion, case: Case) -> np.ndarray:
    """By the proof: largest share of 80 % of the sensors' range with each number of payloads."""
    (forces,) = (q for q in of_mechanics(motion, case, False) if q.of.kind is LimitKind.SENSOR_FORCE)
    return forces.ratio.max(axis=0).reshape(-1, 6).max(axis=1)


@pytest.mark.parametrize("kind", KINDS)
def test_proof_and_regressor_know_the_same_forces(kind: str) -> None:
    """Balances of moments in NumPy, and columns of Lagrange's equations in CasADi, share no line."""
    case = of(kind)
    motion = Harmonic(seed=4, size=0.8).at(np.linspace(0.1, 2.9, 40))
    loads = Loads.of(case)
    assert loads is not None
    expected = forces(case, motion.coordinates, motion.rates, motion.accelerations)
    report = prove_at(Harmonic(seed=4, size=0.8), case, np.linspace(0.1, 2.9, 40), in_box=False)
    (check,) = (c for c in report.checks if c.kind == "sensor force")
    row, channel = np.unravel_index(int(np.abs(expected).argmax()), expected.shape)
    exact = 1e-9 if kind != "friction" else 1e-2  # Coulomb friction of the regressor is smooth at rest
    assert check.worst == pytest.approx(expected[row, channel], rel=exact)
    assert loads.labels[channel] in check.name
    for count, share in enumerate(load_shares(motion, case)):
        most = np.abs(expected[:, 6 * count : 6 * count + 6]).max()
        assert share == pytest.approx(most / (SHARE * 5000.0), rel=exact)


def test_forces_of_struts_depend_on_the_pose_and_have_no_bound_from_anywhere() -> None:
    case = of("drive")
    assert linuxcnc_guarantees(Reading("", (), 0), case).force_bounds() == ()


def test_sensors_that_are_too_weak_are_named_and_the_search_knows_their_limit() -> None:
    """At states of a motion the shares that the optimiser limits are the forces that the proof finds."""
    weak = of("drive", 900.0)
    report = prove(Standstill(HOME, 0.01), of("drive", 100.0), 100.0)
    assert "5 payloads" in next(c.name for c in report.violations if c.kind == "sensor force")
    assert LimitKind.SENSOR_FORCE in [kind for kind, *_ in near_limits(weak)]
    assert LimitKind.SENSOR_FORCE not in [kind for kind, *_ in near_limits(of("drive", 100_000.0))]
    motion = Harmonic(seed=4, size=0.8).at(np.linspace(0.1, 2.9, 20))
    states = np.hstack([motion.coordinates, motion.rates, motion.accelerations])
    (force,) = (kernel for kind, _, kernel in state_limits(weak, (5,)) if kind is LimitKind.SENSOR_FORCE)
    shares = force.values(np.hstack([states, np.zeros((20, state_size(6) - 18))]))
    assert np.abs(shares).max() == pytest.approx(load_shares(motion, weak)[5], rel=1e-9)


@pytest.mark.slow
def test_a_search_holds_the_range_that_shapes_its_motion() -> None:
    weak = of("drive", 900.0)
    start = run_start(Task(weak, 6, PointToPointFamily.of(weak, 8, 3.0), "D", seed=1))
    motion = start.family.motion(start.unknowns)
    kept = prove(motion, weak, 1000.0)
    (force,) = (c for c in kept.checks if c.kind == "sensor force")
    assert force.ratio > 0.8
    assert force.kept


def test_shares_grow_with_what_is_mounted() -> None:
    still = Motion(np.zeros(1), HOME[None].copy(), *(np.zeros((1, 6)) for _ in range(3)))
    assert np.all(np.diff(load_shares(still, of("drive"))) > 0.0)  # with what is mounted
