"""Every derivative is the derivative of what it claims: what a first-order step leaves shrinks with its square."""

from collections.abc import Callable
from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

from cases.schema import load_case
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.machines.rotations import rotation
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.motion.motion import Joined, Motion, TimedPoints
from tests.helpers import Harmonic, taylor_slope
from tests.simulated_machine import kinematics_of_coordinates

Array = np.ndarray
CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)
MOTION = Harmonic(seed=7)
POINTS = TimedPoints.through([0.0, 0.5, 0.8, 1.4, 2.0], Harmonic(seed=8).at([0.0, 0.4, 0.9, 1.5, 2.3]).coordinates)
JOINED = Joined((POINTS, TimedPoints.through([0.0, 1.0], POINTS.poses[[-1, 0]])))
T = 1.1  # [s] an instant without any symmetry

Case = tuple[Callable[[float], Array], Array]


def moment(t: float, trajectory=MOTION) -> Motion:
    return trajectory.at(np.array([t]))


def twist(t: float, of: str = "twist") -> Array:
    now = moment(t)
    return getattr(kinematics_of_coordinates(now.coordinates, now.rates, now.accelerations), of)[0]


def turn(t: float) -> Array:
    rpy = ca.SX.sym("rpy", 3)
    return over_samples(ca.Function("turn", [rpy], [rotation(rpy)]), moment(t).coordinates[:, 3:])[0][0]


def struts(t: float, order: int) -> Array:
    now = moment(t)
    return over_samples(HEXAPOD.strut_motion, now.coordinates, now.rates, now.accelerations)[order][0]


def jacobian(t: float) -> Array:
    return over_samples(HEXAPOD.inverse_jacobian, moment(t).coordinates)[1][0]


def turning() -> Case:
    return turn, np.cross(twist(T)[3:], turn(T).T).T


def drift() -> Case:
    now = twist(T)
    return lambda t: jacobian(t) @ now, over_samples(HEXAPOD.jacobian_drift, moment(T).coordinates, now[None])[0][0]


def physical() -> Case:
    form, draw = physical_form(identification_model(CASE, 9)), np.random.default_rng(0)
    u, direction = draw.uniform(1.0, 2.0, 20), draw.normal(size=20)
    outer = form.of(u, np.outer(direction, direction))[1]  # (J d) (J d)^T, whose first component is the mass's own d
    return lambda h: form.of(u + h * direction, np.eye(20))[0], outer[0] / direction[0]


def regressor() -> Case:
    function = identification_model(CASE, 8).coordinate_regressor
    now, later = [moment(T).coordinates, moment(T).rates, moment(T).accelerations], moment(T).jerks
    symbols = [ca.SX.sym(n, 6) for n in "prat"]
    value = ca.vec(function(*symbols[:3]))
    slope = sum(ca.jtimes(value, s, ds) for s, ds in pairwise(symbols))
    derivative = over_samples(ca.Function("slope", symbols, [slope]), *now, later)[0][0]

    def along(t: float) -> Array:
        then = moment(t)
        return over_samples(function, then.coordinates, then.rates, then.accelerations)[0][0].T

    return along, derivative


def of_motion(trajectory: object, order: str, derivative: str) -> Case:
    return lambda t: getattr(moment(t, trajectory), order)[0], getattr(moment(T, trajectory), derivative)[0]


DERIVATIVES: dict[str, Callable[[], Case]] = {
    "R' = S(omega) R": turning,
    "(38) is the rate of (37)": lambda: (twist, twist(T, "twist_rate")),
    "J_Hex^-1 twist is the rate of strut lengths": lambda: (lambda t: struts(t, 0), jacobian(T) @ twist(T)),
    "strut velocities": lambda: (lambda t: struts(t, 0), struts(T, 1)),
    "strut accelerations": lambda: (lambda t: struts(t, 1), struts(T, 2)),
    "drift of J_Hex^-1": drift,
    "Jacobian of the physical parameters": physical,
    "regressor along a motion": regressor,
    "rates of timed points": lambda: of_motion(POINTS, "coordinates", "rates"),
    "accelerations of timed points": lambda: of_motion(POINTS, "rates", "accelerations"),
    "jerks of timed points": lambda: of_motion(POINTS, "accelerations", "jerks"),
    "rates of joined motions": lambda: of_motion(JOINED, "coordinates", "rates"),
}


@pytest.mark.parametrize("name", DERIVATIVES)
def test_a_first_order_step_leaves_the_square_of_the_step(name: str) -> None:
    function, derivative = DERIVATIVES[name]()
    at = 0.0 if name.startswith("Jacobian") else T
    assert taylor_slope(function, at, derivative, largest_step=0.01) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("name", DERIVATIVES)
def test_the_check_itself_sees_a_derivative_that_is_wrong_by_a_thousandth(name: str) -> None:
    function, derivative = DERIVATIVES[name]()
    at = 0.0 if name.startswith("Jacobian") else T
    assert taylor_slope(function, at, 1.001 * derivative, largest_step=1e-4) < 1.5
