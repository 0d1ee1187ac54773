"""Plans, programs and evaluates the motion that calibrates a force-measuring machine in seconds.

    import hexcite as hx

    case = hx.load_case("hexapod")
    plan = hx.plan(case, hx.PointToPoint(moves=40), duration=12.0)
    program = hx.write(plan, "sinumerik")
    recording = hx.run(program, case, on="virtual", seed=0)
    result = hx.identify(recording, case)
    result["m"].value, result["m"].reported

Values are in SI and radians and have a short `repr`. Plans, programs, recordings and results have `save` and `load`;
`hx.report(value, "page.html")` makes the page of a plan, result, comparison or validation, `hx.plot(value)` a figure of
matplotlib. What stands here is public,
and nothing else. It is imported when it is first used; an argument of a wrong type is refused with its name, its value
and what it should be.
"""

from typing import TYPE_CHECKING

from cases.base.doors import door

if TYPE_CHECKING:
    from cases import Case as Case
    from cases import HexciteError as HexciteError
    from cases import load_case as load_case
    from cases import new_case as new_case
    from hexcite._check_case import check_case as check_case
    from hexcite._demo import demo as demo
    from hexcite._identifiability import identifiability as identifiability
    from hexcite._new_arm import new_arm as new_arm
    from hexcite._run import run as run
    from hexcite._version import __version__ as __version__
    from hexcite._write import check as check
    from hexcite._write import write as write
    from hexcite.comparison.comparison import compare as compare
    from hexcite.comparison.trials import ValidationSettings as ValidationSettings
    from hexcite.comparison.validation import validate as validate
    from hexcite.comparison.validation import validate_results as validate_results
    from hexcite.reports import report as report
    from hexcite.reports.certificate import certificate as certificate
    from hexcite.reports.certificate import verify_certificate as verify_certificate
    from hexcite.reports.plotting import plot as plot
    from hexcite.studies.conduct import study as study
    from identification import Finding as Finding
    from identification import History as History
    from identification import Identifiability as Identifiability
    from identification import Look as Look
    from identification import Method as Method
    from identification import Model as Model
    from identification import ModelChoice as ModelChoice
    from identification import Prior as Prior
    from identification import Recording as Recording
    from identification import Result as Result
    from identification import Treatment as Treatment
    from identification import Verdict as Verdict
    from identification import accept as accept
    from identification import force as force
    from identification import history as history
    from identification import identify_models as identify_models
    from identification import look as look
    from identification import payload as payload
    from identification import pool as pool
    from identification import read as read
    from identification import tare as tare
    from identification import verify as verify
    from identification.identify import identify as identify
    from planner import Fourier as Fourier
    from planner import Manual as Manual
    from planner import Plan as Plan
    from planner import PointToPoint as PointToPoint
    from planner import Spline as Spline
    from planner import bound as bound
    from planner import plan as plan
    from planner import plan_poses as plan_poses
    from planner import retime as retime
    from postprocessors import Program as Program
    from postprocessors import read_program as read_program
    from postprocessors.export import export as export
    from postprocessors.export import preview as preview

PUBLIC = {
    "Case": "cases",
    "HexciteError": "cases",
    "load_case": "cases",
    "new_case": "cases",
    "check_case": "hexcite._check_case",
    "demo": "hexcite._demo",
    "identifiability": "hexcite._identifiability",
    "new_arm": "hexcite._new_arm",
    "run": "hexcite._run",
    "__version__": "hexcite._version",
    "check": "hexcite._write",
    "write": "hexcite._write",
    "compare": "hexcite.comparison.comparison",
    "ValidationSettings": "hexcite.comparison.trials",
    "validate": "hexcite.comparison.validation",
    "validate_results": "hexcite.comparison.validation",
    "report": "hexcite.reports",
    "certificate": "hexcite.reports.certificate",
    "verify_certificate": "hexcite.reports.certificate",
    "plot": "hexcite.reports.plotting",
    "study": "hexcite.studies.conduct",
    "Finding": "identification",
    "History": "identification",
    "Identifiability": "identification",
    "Look": "identification",
    "Method": "identification",
    "Model": "identification",
    "ModelChoice": "identification",
    "Prior": "identification",
    "Recording": "identification",
    "Result": "identification",
    "Treatment": "identification",
    "Verdict": "identification",
    "accept": "identification",
    "force": "identification",
    "history": "identification",
    "identify_models": "identification",
    "look": "identification",
    "payload": "identification",
    "pool": "identification",
    "read": "identification",
    "tare": "identification",
    "verify": "identification",
    "identify": "identification.identify",
    "Fourier": "planner",
    "Manual": "planner",
    "Plan": "planner",
    "PointToPoint": "planner",
    "Spline": "planner",
    "bound": "planner",
    "plan": "planner",
    "plan_poses": "planner",
    "retime": "planner",
    "Program": "postprocessors",
    "read_program": "postprocessors",
    "export": "postprocessors.export",
    "preview": "postprocessors.export",
}
"""Public names, and the modules that they are imported from when they are first used."""
__getattr__, __dir__ = door(__name__, PUBLIC, checked=True)
