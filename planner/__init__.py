"""Plans of motions and poses, what they promise, and the way from a plan through program and run to parameters."""

from typing import TYPE_CHECKING

from cases import door

if TYPE_CHECKING:
    from hexcite._check_case import check_case as check_case
    from hexcite._demo import demo as demo
    from hexcite._identifiability import identifiability as identifiability
    from hexcite._run import run as run
    from hexcite._write import check as check
    from hexcite._write import write as write
    from hexcite.comparison.comparison import compare as compare
    from hexcite.comparison.trials import ValidationSettings as ValidationSettings
    from hexcite.comparison.validation import validate as validate
    from hexcite.reports import report as report
    from hexcite.reports.plotting import plot as plot
    from planner._plan import plan as plan
    from planner._plan import plan_poses as plan_poses
    from planner.bounds.bound import bound as bound
    from planner.families.settings import Fourier as Fourier
    from planner.families.settings import Manual as Manual
    from planner.families.settings import PointToPoint as PointToPoint
    from planner.families.settings import Spline as Spline
    from planner.plans.plan import Plan as Plan
    from planner.retiming import retime as retime

__getattr__, __dir__ = door(__name__)
