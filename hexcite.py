"""Plans, programs and evaluates the motion that calibrates a force-measuring machine in seconds.

    import hexcite as hx

    case = hx.load_case("hexapod")
    plan = hx.plan(case, hx.PointToPoint(moves=40), duration=12.0)
    program = hx.write(plan, "linuxcnc", accept=("jerk", "strut acceleration"))
    recording = hx.run(program, case, on="virtual", seed=0)
    result = hx.identify(recording, case)
    result["m"].value, result["m"].std

Values are in SI and radians. Each has a short `repr`, `save` and `load`; `hx.report(value, "page.html")` makes its
page. What stands here is public, and nothing else. It is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cases.errors import HexciteError as HexciteError
    from cases.loading import load_case as load_case
    from cases.schema import Case as Case
    from identification.estimation.estimators import method as method
    from identification.force import tare as tare
    from identification.outcome import Result as Result
    from identification.recording import Recording as Recording
    from identification.recording import read as read
    from planner.comparison.compare import compare as compare
    from planner.demo import demo as demo
    from planner.families.settings import Fourier as Fourier
    from planner.families.settings import Manual as Manual
    from planner.families.settings import PointToPoint as PointToPoint
    from planner.families.settings import Spline as Spline
    from planner.library import plan as plan
    from planner.library import plan_poses as plan_poses
    from planner.plan import Plan as Plan
    from planner.reports.report import report as report
    from planner.retiming.plan import retime as retime
    from planner.runs.identified import identify as identify
    from planner.runs.running import run as run
    from planner.runs.writing import write as write
    from planner.validation.validate import validate as validate
    from postprocessors.export.targets import export as export
    from postprocessors.files import Program as Program
    from postprocessors.files import read_program as read_program

_PLACES = {
    "cases.errors": ("HexciteError",),
    "cases.loading": ("load_case",),
    "cases.schema": ("Case",),
    "identification.estimation.estimators": ("method",),
    "identification.force": ("force=external_force", "tare"),
    "identification.outcome": ("Result",),
    "identification.recording": ("Recording", "read"),
    "planner.bounds.kept": ("bound=information_bound",),
    "planner.comparison.compare": ("compare",),
    "planner.demo": ("demo",),
    "planner.families.settings": ("Fourier", "Manual", "PointToPoint", "Spline"),
    "planner.library": ("plan", "plan_poses"),
    "planner.plan": ("Plan",),
    "planner.reports.report": ("report",),
    "planner.retiming.plan": ("retime",),
    "planner.runs.identified": ("identify",),
    "planner.runs.running": ("run",),
    "planner.runs.writing": ("write",),
    "planner.validation.validate": ("validate",),
    "postprocessors.export.targets": ("export",),
    "postprocessors.files": ("Program", "read_program"),
}


def __getattr__(name: str) -> object:
    for place, names in _PLACES.items():
        for shown, _, own in (entry.partition("=") for entry in names):
            if shown == name:
                return getattr(import_module(place), own or shown)
    raise AttributeError(f"hexcite has no {name}; it has {', '.join(__dir__())}")


def __dir__() -> list[str]:
    return sorted(entry.partition("=")[0] for names in _PLACES.values() for entry in names)
