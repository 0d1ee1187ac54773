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
    from identification.outcome import Result as Result
    from identification.outcome import force as force
    from identification.outcome import tare as tare
    from identification.recording import Recording as Recording
    from identification.recording import read as read
    from planner.bounds.kept import bound as bound
    from planner.comparison.advising import compare as compare
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
    "HexciteError": "cases.errors",
    "load_case": "cases.loading",
    "Case": "cases.schema",
    "method": "identification.estimation.estimators",
    "Result": "identification.outcome",
    "force": "identification.outcome",
    "tare": "identification.outcome",
    "Recording": "identification.recording",
    "read": "identification.recording",
    "bound": "planner.bounds.kept",
    "compare": "planner.comparison.advising",
    "demo": "planner.demo",
    "Fourier": "planner.families.settings",
    "Manual": "planner.families.settings",
    "PointToPoint": "planner.families.settings",
    "Spline": "planner.families.settings",
    "plan": "planner.library",
    "plan_poses": "planner.library",
    "Plan": "planner.plan",
    "report": "planner.reports.report",
    "retime": "planner.retiming.plan",
    "identify": "planner.runs.identified",
    "run": "planner.runs.running",
    "write": "planner.runs.writing",
    "validate": "planner.validation.validate",
    "export": "postprocessors.export.targets",
    "Program": "postprocessors.files",
    "read_program": "postprocessors.files",
}


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"hexcite has no {name}; it has {', '.join(_PLACES)}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return list(_PLACES)
