"""Plans of motions and poses, what they promise, bounds of what any motion could, and the same path at another pace."""

from typing import TYPE_CHECKING

from cases.base.doors import door

if TYPE_CHECKING:
    from planner._plan import plan as plan
    from planner._plan import plan_poses as plan_poses
    from planner.bounds.bound import bound as bound
    from planner.families.settings import Fourier as Fourier
    from planner.families.settings import Manual as Manual
    from planner.families.settings import PointToPoint as PointToPoint
    from planner.families.settings import Spline as Spline
    from planner.plans.plan import Plan as Plan
    from planner.retiming import retime as retime

PUBLIC = {
    "plan": "planner._plan",
    "plan_poses": "planner._plan",
    "bound": "planner.bounds.bound",
    "Fourier": "planner.families.settings",
    "Manual": "planner.families.settings",
    "PointToPoint": "planner.families.settings",
    "Spline": "planner.families.settings",
    "Plan": "planner.plans.plan",
    "retime": "planner.retiming",
}
"""Public names, and the modules that they are imported from when they are first used."""
__getattr__, __dir__ = door(__name__, PUBLIC)
