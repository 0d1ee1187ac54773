"""The stage Use: exports, forces, tare and payload."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cases.certificate import CertificateOf
from cases.readiness import other_machine
from hexcite.page.actions.common import Context
from hexcite.page.stages import Machine, Made, Workspace
from hexcite.page.views.common import Query, beginning, chosen, parameter
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


OF_CONTROLS = {"linuxcnc": ("linuxcnc",), "twincat": ("st",), "urscript": ("urscript",), "ros2": ("ros2", "ft-tools")}
"""Controllers that programs are written for, and exports that run on them."""
ANYWHERE = ("json", "python", "c")


def targets_of(machine: Machine) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Targets that fit a machine, then all others, each group with the key of its name."""
    from postprocessors.export.targets import LOADS, TARGETS

    controls = dict.fromkeys(each for control in machine.dialects for each in OF_CONTROLS.get(control, ()))
    arm = machine.case is not None and machine.case.chain is not None and other_machine(machine.case, "linuxcnc")
    fitting = tuple(dict.fromkeys((*controls, *ANYWHERE, *(LOADS if arm else ()))))
    others = tuple(target for target in TARGETS if target not in fitting)
    return ("targets_fit", fitting), ("targets_other", others)


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Use shows of a machine, for its template."""
    result: Made | None = chosen(there.results, query.get("result"))
    if result is None:
        return {"chosen": None}
    from hexcite.page.views.result import failed_checks, outcome  # with scipy, which a stage without results is without
    from identification.options import FRAMES
    from postprocessors.export.targets import FRAMED

    latest = {
        word: context.jobs.latest(context.machine.key, word, result.name) for word in ("export", "force", "certificate")
    }
    about = outcome(context.words, result)
    targets = targets_of(context.machine)
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
        "failed": failed_checks(context, result),
        "again": about["recording"] if about["recording"] in recorded else "",
        "targets": targets,
        "to": query.get("to", targets[0][1][0]),
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
