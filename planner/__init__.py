"""Plans of motions and poses, what they promise, and the way from a plan through program and run to parameters."""

from typing import TYPE_CHECKING

from cases import door

if TYPE_CHECKING:
    from planner.bounds.information_limit import bound as bound
    from planner.case_check import check_case as check_case
    from planner.comparison.comparison import compare as compare
    from planner.comparison.trials import ValidationSettings as ValidationSettings
    from planner.comparison.validation import validate as validate
    from planner.demonstration import demo as demo
    from planner.execution import run as run
    from planner.families.settings import Fourier as Fourier
    from planner.families.settings import Manual as Manual
    from planner.families.settings import PointToPoint as PointToPoint
    from planner.families.settings import Spline as Spline
    from planner.library import plan as plan
    from planner.library import plan_poses as plan_poses
    from planner.plan_program import check as check
    from planner.plan_program import write as write
    from planner.plans import Plan as Plan
    from planner.reports import report as report
    from planner.reports.plotting import plot as plot
    from planner.retiming import retime as retime
    from planner.told_apart import identifiability as identifiability

__getattr__, __dir__ = door(__name__)
