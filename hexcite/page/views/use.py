"""The stage Use: exports, forces, tare and payload."""

from typing import Any

from hexcite.page.actions import Context
from hexcite.page.stages import Made, Workspace
from hexcite.page.views.common import Query, beginning, chosen, parameter
from hexcite.page.views.result import outcome


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Use shows of a machine, for its template."""
    from postprocessors.export.targets import SINGLE_FILES, TARGETS

    result: Made | None = chosen(there.results, query.get("result"))
    latest = {
        word: context.jobs.latest(context.machine.key, word, result.name) if result is not None else None
        for word in ("export", "force", "tare", "payload")
    }
    answers = {word: job.answer if job is not None and job.state == "done" else None for word, job in latest.items()}
    export = answers["export"] or {}
    shown = dict(export.get("texts") or {})
    for file in export.get("files") or ():
        shown[file] = beginning(context.root / file)[0]
    payload = (answers["payload"] or {}).get("parameters") or {}
    force = answers["force"] or {}
    return {
        "results": there.results,
        "recordings": there.recordings,
        "chosen": result,
        "outcome": None if result is None else outcome(result),
        "targets": [(target, SINGLE_FILES[target].what if target in SINGLE_FILES else "C99") for target in TARGETS],
        "to": query.get("to", "c"),
        "texts": shown,
        "files": export.get("files") or (),
        "force": force,
        "force_rows": [(n, f"{v:.4g}", f"{force['peak'][n]:.4g}") for n, v in (force.get("rms") or {}).items()],
        "payload": [parameter(name, value) for name, value in payload.items()],
    }
