"""Cases with chains of five, six and seven joints, made of the built-in robot."""

import numpy as np

from cases.schema import Case, load_case
from identification.machines.of_case import machine_of
from identification.model.model import expected_forces, full_model, identification_model
from identification.model.parameters import linear_parameters

ROBOT = load_case("ur10_wrist")
RAIL = {
    "name": "rail", "kind": "prismatic", "axis": [0.0, 1.0, 0.0], "position_mm": [-1000.0, 1000.0], "home_mm": 0.0,
}  # fmt: skip
ON_RAIL = {
    "name": "rail", "position_mm": [-300.0, 300.0], "velocity_mm_s": 800.0, "acceleration_m_s2": 3.0,
    "jerk_m_s3": 60.0,
}  # fmt: skip


def chain_case(joints: int) -> Case:
    """The built-in robot (6), without its last joint (5), or on a rail (7)."""
    data = ROBOT.model_dump(mode="json", exclude_unset=True)
    chain, limits = data["machine"]["chain"]["joints"], data["limits"]["motion"]["joints"]
    if joints == 5:
        chain.pop(), limits.pop()
    elif joints == 7:
        chain.insert(0, RAIL), limits.insert(0, ON_RAIL)
    return Case.model_validate(data).found_at("ur10_wrist")


def swing(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joints of the robot that swing from rest to rest between 0.5 and 7.5 s, with their derivatives."""
    draw = np.random.default_rng(1)
    rates, size = draw.uniform(3.0, 7.0, 6), draw.uniform(0.15, 0.3, 6)
    inside = np.clip((t - 0.5) / 7.0, 0.0, 1.0)[:, None]
    step = 1e-4

    def at(s: np.ndarray) -> np.ndarray:
        return size * np.sin(rates * 7.0 * s) * (16.0 * (s * (1.0 - s)) ** 2) ** 2

    before, here, after = at(inside - step), at(inside), at(inside + step)
    still = (inside <= 0.0) | (inside >= 1.0)
    first, second = (after - before) / (2 * step) / 7.0, (after - 2 * here + before) / step**2 / 49.0
    return ROBOT.chain.home + here, np.where(still, 0.0, first), np.where(still, 0.0, second)


def swung_forces(t: np.ndarray, more_kg: float = 0.0) -> np.ndarray:
    """What the robot's sensor reads in that motion without noise, shape (n, 6) [N, N m].

    With a point mass more [kg] at the load's centre of gravity.
    """
    return _forces(*swing(t), more_kg)


def standing_forces(q: np.ndarray) -> np.ndarray:
    """The same where the robot stands, shape (n, 6) [N, N m]; q are positions of the joints, shape (n, 6) [rad]."""
    return _forces(q, np.zeros_like(q), np.zeros_like(q))


def _forces(q: np.ndarray, rates: np.ndarray, accelerations: np.ndarray, more_kg: float = 0.0) -> np.ndarray:
    model = identification_model(ROBOT, full_model(ROBOT))
    carried = ROBOT.need_simulation("a test").parameters
    body = carried.body.model_copy(update={"mass_kg": carried.body.mass_kg + more_kg})
    truth = linear_parameters(model, carried.model_copy(update={"body": body}))
    return expected_forces(model, machine_of(ROBOT).kinematics(q, rates, accelerations), truth)
