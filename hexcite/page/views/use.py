"""The stage Use: exports, forces, tare and payload."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cases.certificate import CertificateOf
from hexcite.page.actions.common import Context
from hexcite.page.stages import Made, Workspace
from hexcite.page.views.common import Query, beginning, chosen, parameter
from hexcite.page.views.result import failed_checks, outcome
from hexcite.page.words import Words
from identification.texts import std_text

BODY = ("m", "xC", "yC", "zC")  # parameters of a history that are shown on the stage


def _history(words: Words, answer: Mapping[str, Any]) -> dict[str, Any]:
    """Results of the machine in the order of time: body and offsets in a table, the page with their curves."""
    results = list(answer.get("results", ()))
    names = list(dict.fromkeys(name for each in results for name in each["parameters"] if name in BODY))
    rows = []
    for each in results:
        cells = []
        for name in names:
            value = each["parameters"].get(name)
            _, digits, std, _, unit = parameter(words, name, value) if value else ("", "", "", "", "")
            cells.append(f"{digits} ± {std} {unit}" if std else f"{digits} {unit}".strip())
        when, folder = str(each["when"])[:16].replace("T", " "), Path(str(each["result"])).parent.name
        rows.append((when, folder, f"{each['payload_kg']:g}", cells))
    return {"report": answer["report"], "heads": [words.parameter(name) for name in names], "rows": rows}


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Use shows of a machine, for its template."""
    from identification.options import FRAMES
    from postprocessors.export.targets import FRAMED, SINGLE_FILES, TARGETS

    result: Made | None = chosen(there.results, query.get("result"))
    latest = {
        word: context.jobs.latest(context.machine.key, word, result.name) if result is not None else None
        for word in ("export", "force", "certificate")
    }
    about = None if result is None else outcome(context.words, result)
    recorded = {recording.name for recording in there.recordings}
    answers = {word: job.answer if job is not None and job.state == "done" else None for word, job in latest.items()}
    export = answers["export"] or {}
    texts = dict(export.get("texts") or {})
    for file in export.get("files") or ():
        texts[file] = beginning(context.root / file)[0]
    pdf = query.get("certificate", "")
    verified = context.jobs.latest(context.machine.key, "certificate", pdf) if pdf else None
    past = context.jobs.latest(context.machine.key, "history", "history")
    case = context.machine.case
    stated_about = case.certificate if case is not None and case.certificate is not None else CertificateOf()
    force = answers["force"] or {}
    return {
        "results": there.results,
        "recordings": there.recordings,
        "chosen": result,
        "outcome": about,
        "failed": [] if result is None else failed_checks(context, result),
        "again": about["recording"] if about is not None and about["recording"] in recorded else "",
        "targets": [
            (target, context.words.target(target, SINGLE_FILES[target].what if target in SINGLE_FILES else "C99"))
            for target in TARGETS
        ],
        "to": query.get("to", "c"),
        "texts": texts,
        "files": export.get("files") or (),
        "force": force,
        "force_rows": [
            (n, f"{v:.4g}", f"{force['peak'][n]:.4g}", std_text(force["expanded_k2"][n]))
            for n, v in (force.get("rms") or {}).items()
        ],
        "frames": FRAMES,
        "links": FRAMED,
        "certificate": (answers["certificate"] or {}).get("certificate", ""),
        "certificates": sorted(file.name for file in context.root.glob("*.pdf") if file.is_file()),
        "pdf": pdf,
        "verified": verified,
        "about": stated_about,
        "serials": stated_about.serial_numbers or {},
        "stated": query.get("stated") == "1",
        "history": _history(context.words, past.answer)
        if past is not None and past.state == "done" and past.answer
        else None,
    }
