"""What each stage shows: plain values for its template, read from the folders."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from cases.base.errors import HexciteError
from cases.schema import Case
from hexcite.page import drawing, values
from hexcite.page.actions import Context, given_values
from hexcite.page.forms import EFFORTS, FAMILIES, Fields
from hexcite.page.jobs import Job
from hexcite.page.stages import STAGES, Made, Recording, Workspace, built_in, own_machines, workspace
from hexcite.page.texts import Language, text
from identification.finding import ABOUT_THE_RUN
from identification.texts import legible, parameter_words, std_text, value_text

MOST_TEXT = 40_000  # characters of a program or export that are shown
Query = Mapping[str, str]


def machines(root: Path) -> dict[str, Any]:
    """Machines to choose from, and the URDF files to begin from."""
    return {
        "own": own_machines(root),
        "built_in": built_in(),
        "urdfs": sorted(file.name for file in root.glob("*.urdf") if file.is_file()),
    }


def stage(context: Context, name: str, query: Query, language: Language) -> dict[str, Any]:
    """What a stage shows of its machine."""
    there = workspace(context.root, context.machine)
    shown = {
        "machine": _machine, "plan": _plan, "program": _program, "data": _data, "result": _result, "use": _use,
    }[name](context, there, query)  # fmt: skip
    states = {stage: there.state(stage) for stage in STAGES}
    return {"machine": context.machine, "address": context.address, "states": states, "there": there, **shown}


def _machine(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    machine = context.machine
    content = machine.file.read_text(encoding="utf-8", errors="replace")
    check = context.jobs.latest(machine.key, "case", "check")
    return {
        "saved": query.get("saved") == "1",
        "digest": values.digest(content),
        "sections": values.sections(content, machine.case),
        "given": {},
        "checked": check.answer if check is not None else None,
        "doubts": machine.case.doubts if machine.case is not None else (),
        **_drawn(machine.case),
    }


def _drawn(case: Case | None, problem: str = "") -> dict[str, Any]:
    """The drawings of a case, or why there are none."""
    if case is None:
        return {"views": None, "why": problem}
    try:
        return {"views": drawing.views(case), "why": ""}
    except HexciteError as error:
        return {"views": None, "why": "; ".join(error.lines)}


def preview(context: Context, fields: Fields) -> dict[str, Any]:
    """The drawings of a case with values that are not written yet."""
    content = context.machine.file.read_text(encoding="utf-8")
    try:
        case = values.case_of(values.edited(content, given_values(fields)), context.machine.file)
    except values.Refused as error:
        return {"views": None, "why": str(error)}
    return _drawn(case)


def _chosen(made: Sequence[Any], name: str | None) -> Any:
    """The one that is asked for, else the newest that is fresh, else the newest; None where there is none."""
    named = next((each for each in made if each.name == name), None)
    fresh = next((each for each in made if not each.changed), None)
    return named or fresh or (made[0] if made else None)


def _plan(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    plan: Made | None = _chosen(there.plans, query.get("plan"))
    others = [p for p in there.plans if plan is not None and p.name != plan.name and p.fresh][:2]
    return {
        "lacks": context.machine.lacks("plan"),
        "families": FAMILIES,
        "efforts": tuple(EFFORTS),
        "dialects": context.machine.dialects,
        "chosen": plan,
        "facts": None if plan is None else _facts(plan),
        "plans": [(p, _facts(p)) for p in there.plans],
        "predicted": _predicted([plan, *others]) if plan is not None else None,
        "limits": _limits(plan.record.get("limits", {})) if plan is not None else [],
    }


def _facts(plan: Made) -> dict[str, Any]:
    record = plan.record
    efficiency = record.get("d_efficiency")
    return {
        "family": record.get("family", ""),
        "seconds": f"{record['duration_s']:.3g}" if isinstance(record.get("duration_s"), int | float) else "",
        "efficiency": f"{efficiency:.3f}" if isinstance(efficiency, float) else "",
        "interrupted": bool(record.get("interrupted")),
        "mass": _deviation("m", record.get("predicted_std", {}).get("m")),
        "notes": [str(note) for note in record.get("notes", ()) if isinstance(note, str)][:6],
    }


def _unit(name: str) -> str:
    """The SI unit of a physical parameter, by its letters."""
    if name == "m":
        return "kg"
    if name in ("xC", "yC", "zC"):
        return "m"
    return "kg m^2" if name.startswith("IC") else ""


def _deviation(name: str, value: object) -> str:
    if not isinstance(value, int | float) or not math.isfinite(value):
        return "–"
    scale, unit = legible(_unit(name))
    return f"{std_text(value * scale)} {unit}".strip()


def _predicted(plans: Sequence[Made]) -> dict[str, Any]:
    """Predicted deviations of plans side by side, a row a parameter."""
    stds = [plan.record.get("predicted_std") or {} for plan in plans]
    names = list(dict.fromkeys(name for std in stds for name in std))
    rows = [(parameter_words(name), [_deviation(name, std.get(name)) for std in stds]) for name in names]
    return {"heads": [plan.name for plan in plans], "rows": rows}


def _limits(limits: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Limits with the share that is used, the most used first."""
    rows = [
        {
            "name": str(check.get("at", name)),
            "share": min(max(float(check["ratio"]), 0.0), 1.2),
            "text": f"{100 * float(check['ratio']):.1f} %",
            "status": str(check.get("status", "")),
        }
        for name, check in limits.items()
        if isinstance(check, Mapping) and isinstance(check.get("ratio"), int | float)
    ]
    return sorted(rows, key=lambda row: -float(str(row["share"])))


def _program(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    plan: Made | None = _chosen(there.plans, query.get("plan"))
    programs = [p for p in there.programs if plan is not None and p.plan == plan.name]
    program = next((p for p in programs if p.name == query.get("program")), programs[0] if programs else None)
    content, cut = _text(context.root / program.name) if program is not None else ("", False)
    last = context.jobs.latest(context.machine.key, "post", plan.name) if plan is not None else None
    refused = last is not None and last.state == "failed"
    exceeded = (last.answer or {}).get("violations", []) if refused and last is not None else []
    kinds = sorted(plan.record.get("limits", {})) if plan is not None else []
    return {
        "plans": there.plans,
        "chosen": plan,
        "programs": programs,
        "program": program,
        "text": content,
        "cut": cut,
        "dialects": context.machine.dialects,
        "preferred": _preferred(plan, context) if plan is not None else "",
        "refused": refused,
        "exceeded": exceeded[:20],
        "answerable": [kind.replace(" ", "-") for kind in kinds] if refused else [],
        "written": last.answer if last is not None and last.state == "done" else None,
        "limits": _limits((last.answer or {}).get("limits", {})) if last is not None and last.state == "done" else [],
    }


def _preferred(plan: Made, context: Context) -> str:
    """The controller that a plan was made for, else the first that limits jerk as the plan does."""
    settings = plan.record.get("settings") or {}
    made_for = str(settings.get("made_for") or "")
    steps = bool(plan.record.get("without") or settings.get("without"))
    order = ("linuxcnc", "urscript") if steps else ("sinumerik", "twincat", "ros2", "setpoints")
    ready = context.machine.dialects
    return made_for if made_for in ready else next((name for name in order if name in ready), "")


def _text(path: Path) -> tuple[str, bool]:
    """The beginning of a text file, and whether there is more."""
    try:
        with open(path, "rb") as stream:
            content = stream.read(MOST_TEXT + 1)
    except OSError:
        return "", False
    return content[:MOST_TEXT].decode("utf-8", "replace"), len(content) > MOST_TEXT


def _data(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    from postprocessors.controllers.linuxcnc.session import linuxcnc_missing

    recording: Recording | None = _chosen(there.recordings, query.get("recording"))
    looked = context.jobs.latest(context.machine.key, "look", recording.name) if recording is not None else None
    answer = looked.answer if looked is not None and looked.over else None
    picture = f"{Path(recording.name).stem}-look.svg" if recording is not None else ""
    return {
        "recordings": there.recordings,
        "chosen": recording,
        "programs": there.programs,
        "controllers": ("virtual",) if linuxcnc_missing() is not None else ("virtual", "linuxcnc"),
        "cannot_run": context.machine.lacks("run"),
        "looked": answer,
        "menus": _menus(context.machine.case, answer) if answer is not None else None,
        "picture": picture if answer is not None and (context.root / picture).is_file() else "",
    }


QUANTITIES: Mapping[str, tuple[str, ...]] = {
    "forces": ("N", "kN", "lbf", "kgf", "mN"),
    "moments": ("Nm", "Nmm", "lbf-in", "lbf-ft"),
    "struts": ("mm", "m", "um", "in"),
    "angles": ("deg", "rad"),
}
"""Units that menus offer, by the keys of `recording.units`."""


def _menus(case: Case | None, answer: Mapping[str, Any]) -> dict[str, Any] | None:
    """Rows of menus: what hexcite needs, the column that it is read from, and all columns of the file."""
    if case is None or answer.get("topics") or not answer.get("columns"):
        return None
    read_from = {column["meaning"]: column for column in answer["columns"] if column["meaning"]}
    needed = ["t_s", "trigger", *case.sensor_frame.channels, *(() if "x_mm" in read_from else _drives(case))]
    names = list(dict.fromkeys([*needed, *read_from]))
    stated = answer.get("settings", {}).get("units", {})
    kinds = {
        "forces": any(name.endswith("_N") for name in names),
        "moments": any(name.endswith("_Nm") for name in names),
        "struts": any(name.startswith("l") and name.endswith("_mm") for name in names),
        "angles": any(name.endswith("_deg") for name in names),
    }
    return {
        "rows": [(name, read_from.get(name)) for name in names],
        "columns": [column["name"] for column in answer["columns"]],
        "units": [(kind, stated.get(kind, ""), QUANTITIES[kind]) for kind, there in kinds.items() if there],
    }


def _drives(case: Case) -> tuple[str, ...]:
    try:
        return tuple(case.drive_columns)
    except HexciteError:
        return ()


def _result(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    result: Made | None = _chosen(there.results, query.get("result"))
    return {"results": there.results, "chosen": result, **({} if result is None else _outcome(result))}


def _outcome(result: Made) -> dict[str, Any]:
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
        "parameters": [_row(name, value) for name, value in record.get("parameters", {}).items()],
        "not_counted": ", ".join(map(str, record.get("not_counted") or ())),
    }


def _row(name: str, value: Mapping[str, Any]) -> tuple[str, str, str, str]:
    """A parameter in words, its value, its deviation and its unit."""
    scale, unit = legible(str(value.get("unit", "")))
    std = max((float(value[key]) for key in ("std", "std_robust") if value.get(key) is not None), default=math.nan)
    if not math.isfinite(std) or std <= 0.0:
        return parameter_words(name), f"{float(value['value']) * scale:.6g}", "", unit
    return parameter_words(name), value_text(float(value["value"]) * scale, std * scale), std_text(std * scale), unit


def _use(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    from postprocessors.export.targets import SINGLE_FILES, TARGETS

    result: Made | None = _chosen(there.results, query.get("result"))
    latest = {
        word: context.jobs.latest(context.machine.key, word, result.name) if result is not None else None
        for word in ("export", "force", "tare", "payload")
    }
    answers = {word: job.answer if job is not None and job.state == "done" else None for word, job in latest.items()}
    export = answers["export"] or {}
    shown = dict(export.get("texts") or {})
    for file in export.get("files") or ():
        shown[file] = _text(context.root / file)[0]
    payload = (answers["payload"] or {}).get("parameters") or {}
    force = answers["force"] or {}
    return {
        "results": there.results,
        "recordings": there.recordings,
        "chosen": result,
        "outcome": None if result is None else _outcome(result),
        "targets": [(target, SINGLE_FILES[target].what if target in SINGLE_FILES else "C99") for target in TARGETS],
        "to": query.get("to", "c"),
        "texts": shown,
        "files": export.get("files") or (),
        "force": force,
        "force_rows": [(n, f"{v:.4g}", f"{force['peak'][n]:.4g}") for n, v in (force.get("rms") or {}).items()],
        "payload": [_row(name, value) for name, value in payload.items()],
    }


def warm_up() -> None:
    """Imports and reads what stages take long for when they first need it."""

    for machine in built_in():
        values.sections(machine.file.read_text(encoding="utf-8"), machine.case)
        _drawn(machine.case)


def job(job: Job, language: Language) -> dict[str, Any]:
    """What a panel shows of a command."""
    last = job.progress[-1] if job.progress else None
    drawn: Markup = drawing.curve(job.progress, job.seconds, text("best_curve", language)) if job.search else Markup("")
    return {
        "line": str(last.get("line", "")) if last is not None and not job.over else "",
        "curve": drawn,
        "messages": job.messages[-8:] if job.state in ("failed", "stopped") else [],
        "warnings": job.messages[-8:] if job.state == "done" else [],
    }
