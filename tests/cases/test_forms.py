"""The same machine in the forms in which drawings and data sheets state it."""

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from cases.machine import Ring, Workspace
from cases.schema import Case, load_case
from cases.sensors import Bars
from identification.limits.limit import LimitKind
from identification.limits.proof import prove
from identification.motion.motion import StandingPoses
from postprocessors.controllers.linuxcnc.configuration import pose_range

PAIRS = {"radius_mm": 520.0, "pair_centres_deg": (30.0, 150.0, 270.0), "z_mm": -45.0}


def with_table(*keys: str, **values: Any) -> Case:
    """The hexapod with other values in a table."""
    data = deepcopy(load_case("hexapod").model_dump())
    table = data
    for key in keys:
        table = table[key]
    table.update(values)
    return Case.model_validate(data)


def test_a_ring_is_the_same_by_half_angle_included_angle_and_six_angles() -> None:
    rings = [
        Ring(half_angle_deg=11.0, **PAIRS),
        Ring(included_angle_deg=22.0, **PAIRS),
        Ring(radius_mm=520.0, z_mm=-45.0, angles_deg=(19.0, 41.0, 139.0, 161.0, 259.0, 281.0)),
    ]
    for ring in rings[1:]:
        np.testing.assert_allclose(ring.points, rings[0].points, atol=1e-12)
    (x, y, z), *_ = rings[0].points
    assert np.degrees(np.arctan2(y, x)) == pytest.approx(19.0)
    assert (np.hypot(x, y), z) == (pytest.approx(0.52), pytest.approx(-0.045))


@pytest.mark.parametrize(
    "keys",
    [
        PAIRS,
        PAIRS | {"half_angle_deg": 11.0, "included_angle_deg": 22.0},
        {"radius_mm": 1.0, "z_mm": 0.0, "half_angle_deg": 11.0},
        PAIRS | {"angles_deg": (0.0,) * 6},
        {"radius_mm": 1.0, "z_mm": 0.0},
    ],
)
def test_a_ring_has_one_form(keys: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=r"half_angle_deg or included_angle_deg, .* or angles_deg alone"):
        Ring.model_validate(keys)


def test_bars_that_carry_a_weight_read_their_compression_or_their_tension() -> None:
    """The frame stands on its bars: the support pushes a body up through them."""
    bars = load_case("hexapod").sensor_frame.bars
    assert bars is not None
    weight = np.array([0.0, 0.0, -100.0, 0.0, 0.0, 0.0])

    def readings(**sense: object) -> np.ndarray:
        frame = with_table("sensor_frame", "bars", **sense).sensor_frame
        return np.linalg.solve(frame.structure, -weight)

    upwards = np.sign(bars.upper.points[:, 2] - bars.lower.points[:, 2])
    pushes = readings() * upwards
    assert pushes.sum() > 0.0
    np.testing.assert_allclose(readings(sense="compression"), readings())
    np.testing.assert_allclose(readings(sense="tension"), -readings())
    mixed = readings(sense=("tension", "compression", *("tension",) * 4))
    np.testing.assert_allclose(mixed, readings() * [-1, 1, -1, -1, -1, -1])


def test_six_senses_or_one() -> None:
    data = load_case("hexapod").sensor_frame.bars.model_dump()
    for wrong in ("push", ["tension"] * 5, ["tension"] * 7):
        with pytest.raises(ValidationError):
            Bars.model_validate(data | {"sense": wrong})


def test_angles_of_accelerations_and_jerks_may_be_in_degrees() -> None:
    before = load_case("hexapod").limits.motion
    acceleration, jerk = (tuple(np.degrees(getattr(before, k))) for k in ("acceleration", "jerk"))
    after = with_table(
        "limits",
        "motion",
        angular_acceleration_rad_s2=None,
        angular_acceleration_deg_s2=acceleration[3:],
        angular_jerk_rad_s3=None,
        angular_jerk_deg_s3=jerk[3:],
    ).limits.motion
    np.testing.assert_allclose(after.acceleration, before.acceleration, rtol=1e-14)
    np.testing.assert_allclose(after.jerk, before.jerk, rtol=1e-14)
    assert not after.with_jerk(np.full(6, np.inf)).limits_jerk


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"angular_jerk_rad_s3": None}, "angular_jerk_rad_s3 is missing; add it, or angular_jerk_deg_s3"),
        ({"angular_acceleration_deg_s2": (1.0,) * 3}, "state the same; remove one"),
    ],
)
def test_one_unit_of_an_acceleration_is_needed(values: dict[str, Any], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        with_table("limits", "motion", **values)


def test_home_may_lie_on_a_limit_but_not_outside() -> None:
    case = with_table("limits", "motion", x_mm=(0.0, 100.0), z_mm=(-50.0, 0.0))
    home, limits = case.need_motion("a test")
    assert limits.coordinates[:, 0].tolist() == [0.0, 0.1]
    assert not prove(StandingPoses(np.array([home, home])), case, 1.0).violations
    with pytest.raises(ValidationError, match=r"x_mm = \[1, 100\] does not contain 0"):
        with_table("limits", "motion", x_mm=(1.0, 100.0))


def test_the_workspace_limits_the_height_where_it_states_it() -> None:
    """The motion box stays within; positioning, which may leave that box, is proven against it; LinuxCNC gets it."""
    case = with_table("workspace", z_mm=(-120.0, 100.0))
    home, _ = case.need_motion("a test")
    below = home - [0.0, 0.0, 0.125, 0.0, 0.0, 0.0]
    for machine, violated in ((case, True), (load_case("hexapod"), False)):
        report = prove(StandingPoses(np.array([below, below])), machine, 1.0, in_box=False)
        assert (LimitKind.WORKSPACE_POSITION in {check.kind for check in report.violations}) == violated
    np.testing.assert_allclose(pose_range(case, box=False)[:, 2], [-0.12, 0.1])
    assert pose_range(load_case("hexapod"), box=False)[1, 2] == pytest.approx(1.55)
    with pytest.raises(ValidationError, match=r"limits.motion.z_mm = .* beyond workspace.z_mm"):
        with_table("workspace", z_mm=(-50.0, 100.0))
    assert Workspace.model_validate(load_case("hexapod").workspace.model_dump()).room.shape == (2, 2)
