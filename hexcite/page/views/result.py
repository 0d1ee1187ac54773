"""The stage Result: the verdict, and the parameters in words."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hexcite.page.actions import Context, remedies_of
from hexcite.page.stages import Made, Workspace
from hexcite.page.views.common import Query, chosen, parameter, remedies
from identification.finding import ABOUT_THE_RUN


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Result shows of a machine, for its template."""
    result: Made | None = chosen(there.results, query.get("result"))
    if result is None:
        return {"results": there.results, "chosen": None}
    made = context.jobs.writing(result.name)
    names = {recording.name for recording in there.recordings}
    return {
        "results": there.results,
        "chosen": result,
        **(about := outcome(result)),
        "remedies": remedies([each for finding in result.record.get("findings", ()) for each in remedies_of(finding)]),
        "written": made.notes if made is not None else (),
        "again": about["recording"].name if about["recording"].name in names else "",
    }


def outcome(result: Made) -> dict[str, Any]:
    """The verdict of a result, its findings and its parameters in words."""
    record = result.record
    findings = [f for f in record.get("findings", ()) if isinstance(f, Mapping) and f.get("sentence")]
    warnings = [f for f in findings if f.get("severity") == "warning"]
    doubts = [f for f in warnings if not f.get("counted") and f.get("kind") not in {str(k) for k in ABOUT_THE_RUN}]
    first = next(iter(doubts or warnings), None)
    run = record.get("run") or {}
    return {
        "light": "doubt" if doubts else "counted" if warnings else "good",
        "first": "" if first is None else str(first["sentence"]),
        "more": [str(f["sentence"]) for f in findings if f is not first],
        "simulated": bool(run.get("simulated")),
        "recording": Path(str(record.get("recording", ""))),
        "parameters": [parameter(name, value) for name, value in record.get("parameters", {}).items()],
        "not_counted": ", ".join(map(str, record.get("not_counted") or ())),
    }
