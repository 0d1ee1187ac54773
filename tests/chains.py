"""Cases with chains of five, six and seven joints, made of the built-in robot."""

from cases.loading import load_case
from cases.schema import Case

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
