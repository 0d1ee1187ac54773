"""What a `joint_trajectory_controller` guarantees beyond its points."""

import math
from collections.abc import Iterator

from cases.base.errors import CaseError, Code
from cases.controller import Ros2
from cases.schema import Case
from identification.limits.limit import LimitKind
from postprocessors.dialects.joint_trajectory.forms import settings_of
from postprocessors.proof.guarantees import SEVEN_SEGMENTS, Guarantees, WayToFirst
from postprocessors.reading import Reading

SHORTEST_POINTS = 1e-3  # least distance of points of a joint trajectory [s]: rounding of closer ones would add jerks


def joint_trajectory_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees for quintic pieces through stated positions, rates and accelerations: all proven, nothing enforced
    unless the case says what is enforced behind the controller.

    Raises:
        CaseError: the controller steps from point to point.
    """
    settings = settings_of(case)
    if settings.interpolation == "none":
        raise CaseError(
            file=f"case {case.name}",
            key="controller.ros2.interpolation",
            problem='"none" steps from point to point: no limit holds',
            remedy='set interpolation_method of the controller, and this key, to "splines"',
            code=Code.NOT_SUPPORTED,
        )
    remedy = "leave out points that are closer to the one before"
    return Guarantees(
        case,
        settings.controller,
        SHORTEST_POINTS,
        math.inf,
        SEVEN_SEGMENTS,
        enforced=frozenset(map(LimitKind, settings.controller_keeps)),
        follows_paths=True,
        resolution=0.0,
        timing_remedy=remedy,
        to_first=_to_first(settings),
        own_rules=tuple(_own_rules(settings)),
    )


def _to_first(settings: Ros2) -> WayToFirst:
    """How the controller goes to the first point, by what the hardware states of the joints.

    It joins that state and the first point by a polynomial of degree five, three or one. Releases since 2026 take what
    the hardware does not state for 0, and are smoother than this says.
    """
    if "velocity" not in settings.state_interfaces:
        return WayToFirst.RATES_STEP
    return WayToFirst.SMOOTH if "acceleration" in settings.state_interfaces else WayToFirst.ACCELERATIONS_STEP


def _own_rules(settings: Ros2) -> Iterator[str]:
    """What the controller does by its own settings, one sentence each."""
    for words, of, end in (
        ("off its path", (settings.path_tolerance_deg, settings.path_tolerance_mm), "stops where a joint is"),
        (
            "off its goal",
            (settings.goal_tolerance_deg, settings.goal_tolerance_mm),
            "reports a failure where a joint ends",
        ),
    ):
        sizes = [f"{size:g} {unit}" for size, unit in zip(of, ("deg", "mm"), strict=True) if size is not None]
        if sizes:
            stops = "" if words == "off its goal" else f", {_stopping(settings)}"
            yield f"{settings.controller} {end} more than {' or '.join(sizes)} {words}{stops}"
    if settings.goal_time_s is not None:
        yield f"{settings.controller} reports a failure where the goal is reached {settings.goal_time_s:g} s late"
    if "position" not in settings.command_interfaces:
        yield (
            f"{settings.controller} commands {', '.join(settings.command_interfaces)}: a control loop follows the set "
            "points, which alone are proven"
        )
    if settings.interpolate_from_desired_state:
        yield f"{settings.controller} starts from its last command, not from where the joints are"
    if settings.speed_scaling:
        yield "a speed slider below 100 % makes the motion slower than planned"
    if settings.controller_keeps:
        limits = ", ".join(settings.controller_keeps)
        yield f"ros2_control enforces {limits} behind {settings.controller}: what it cuts off is not the planned motion"


def _stopping(settings: Ros2) -> str:
    slows_down = settings.decelerate_on_cancel and "velocity" in settings.state_interfaces  # it needs their speeds
    return "slowing down" if slows_down else "at once, whatever acceleration that takes"
