"""What forms of the stages ask for: commands as jobs, and values that are written into a case."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from cases.base.errors import HexciteError, Remedy, Write
from cases.base.files import toml_value
from cases.editing import placed, write_keys, write_table
from cases.tables import built_in_cases
from hexcite.page import forms, values
from hexcite.page.forms import Fields, Unfit, chosen, field
from hexcite.page.jobs import Job, Jobs
from hexcite.page.stages import Machine, Workspace, free, workspace


@dataclass(frozen=True)
class Context:
    """The machine that a request is about, the root folder, and the commands under way."""

    root: Path
    machine: Machine
    jobs: Jobs

    @property
    def address(self) -> str:
        """Of its stages."""
        return f"/m/{quote(self.machine.key, safe='+')}"

    def free(self, name: str, suffix: str = "") -> str:
        """A name for what a command writes."""
        return free(self.root, name, self.jobs.outputs, suffix)


RUN_FILE = "recording.csv"  # in the folder of a rehearsal

Action = Callable[[Context, Workspace, Fields], Job]


def asked(action: Action, context: Context, fields: Fields) -> Job:
    """The job of an action."""
    return action(context, workspace(context.root, context.machine), fields)


def _name(context: Context) -> str:
    if context.machine.case is None:
        raise Unfit(context.machine.problem)
    return context.machine.case.name


def _job(context: Context, stage: str, command: list[str], **more: Any) -> Job:
    return Job(context.machine.key, stage, tuple(command), **more)


def _check(context: Context, there: Workspace, fields: Fields) -> Job:
    propose = ["--propose"] if field(fields, "propose") else []
    return _job(context, "machine", ["case", "check", context.machine.argument, *propose], about="check")


def _box(context: Context, there: Workspace, fields: Fields) -> Job:
    """The box that the last check proposed becomes that of `[limits.motion]`, and is checked."""
    checked = context.jobs.latest(context.machine.key, "case", "check")
    proposal = ((checked.answer if checked is not None else None) or {}).get("proposal")
    if not context.machine.own or not proposal:
        raise Unfit("there is no proposal for this machine; look for the largest reachable box first")
    values.write_motion_box(context.machine.file, proposal["limits_motion"])
    return _check(context, there, {})


def _plan(context: Context, there: Workspace, fields: Fields) -> Job:
    family = field(fields, "family", "best")
    output = context.free(f"{_name(context)}-{'plan' if family in ('best', '') else family}")
    command = forms.plan(context.machine, fields, output)
    goto = f"{context.address}/plan?plan={quote(output)}"
    search = command[0] == "plan" and family != "manual"
    return _job(context, "plan", command, output=output, goto=goto, search=search)


def _program(context: Context, there: Workspace, fields: Fields) -> Job:
    plan = chosen(fields, "plan", [plan.name for plan in there.plans])
    dialect = chosen(fields, "dialect", context.machine.dialects)
    from postprocessors.program import DIALECTS

    slow = "-slow" if field(fields, "speed") == "slow" else ""
    output = context.free(f"{plan}{slow}", DIALECTS[dialect].suffix)
    query = f"?plan={quote(plan)}"
    goto = f"{context.address}/program?plan={quote(plan)}&program={quote(output)}"
    command = forms.post(fields, plan, dialect, output)
    return _job(context, "program", command, output=output, about=plan, query=query, goto=goto)


def _rehearse(context: Context, there: Workspace, fields: Fields) -> Job:
    program = chosen(fields, "program", [program.name for program in there.programs])
    output = context.free(f"{Path(program).stem}-recording")
    goto = f"{context.address}/data?recording={quote(output)}"
    on = chosen(fields, "on", ("virtual", "linuxcnc"), "virtual")
    command = forms.run(context.machine, program, on, output)
    return _job(context, "data", command, output=output, goto=goto)


def _recording(there: Workspace, fields: Fields) -> str:
    return chosen(fields, "recording", [recording.name for recording in there.recordings])


def _look(context: Context, there: Workspace, fields: Fields, write: bool = False) -> Job:
    recording = _recording(there, fields)
    query = f"?recording={quote(recording)}"
    picture = f"{Path(recording).stem}-look.svg"
    rehearsed = any(each.simulated for each in there.recordings if each.name == recording)
    command = forms.look(context.machine, f"{recording}/{RUN_FILE}" if rehearsed else recording, picture, write)
    goto = f"{context.address}/data{query}"
    return _job(context, "data", command, about=recording, query=query, goto=goto, writes=write)


def _take(context: Context, there: Workspace, fields: Fields) -> Job:
    """`look --write`: the proposal becomes the case's."""
    if not context.machine.own:
        raise Unfit("a built-in case is not changed")
    return _look(context, there, fields, write=True)


def _menus(context: Context, there: Workspace, fields: Fields) -> Job:
    """What menus say of the columns becomes the `[recording]` of the case, and the file is looked at again."""
    recording, looked = (
        _recording(there, fields),
        context.jobs.latest(context.machine.key, "look", field(fields, "recording")),
    )
    if not context.machine.own:
        raise Unfit("a built-in case is not changed")
    if looked is None or looked.answer is None:
        raise Unfit(f"{recording}: look at it first")
    write_table(context.machine.file, "recording", chosen_settings(looked.answer, fields))
    return _look(context, there, fields)


def chosen_settings(answer: Mapping[str, Any], fields: Fields) -> dict[str, Any]:
    """The table `[recording]` that `look` proposed, with the columns and units of the menus in it."""
    names = {column["name"] for column in answer["columns"]}
    settings: dict[str, Any] = dict(answer["settings"])
    ours = [name.removeprefix("c.") for name in fields if name.startswith("c.")]
    columns = dict(settings.get("columns", {}))
    for own in ours:
        theirs = field(fields, f"c.{own}")
        if theirs and theirs not in names:
            raise Unfit(f"{own}: {theirs!r} is not a column of the file")
        columns.pop(own, None)
        if theirs:
            columns[own] = theirs
    twice = [name for name in {*columns.values()} if list(columns.values()).count(name) > 1]
    if twice:
        raise Unfit(f"{twice[0]!r} is chosen twice; a column is one channel")
    settings["columns"] = columns
    units = dict(settings.get("units", {}))
    for name in fields:
        if name.startswith("u."):
            unit = field(fields, name)
            units.pop(name[2:], None)
            if unit:
                units[name[2:]] = unit
    settings.pop("units", None)
    return settings | ({"units": units} if units else {})


def _apply(context: Context, there: Workspace, fields: Fields) -> Job:
    """Writes the keys of a remedy into the case, and identifies again where the recording is there."""
    if not context.machine.own:
        raise Unfit("a built-in case is not changed")
    found = remedies(context, there, fields)
    number = field(fields, "remedy")
    if not number.isdecimal() or int(number) >= len(found):
        raise Unfit("remedy: there is none of this number any more; identify again")
    remedy = found[int(number)]
    if field(fields, "words") != remedy.words.strip():
        raise Unfit("remedy: it was identified again meanwhile; look at the stage anew")
    job = _identify(context, there, fields)
    try:
        written = write_keys(context.machine.file, remedy.keys)
    except HexciteError as error:
        raise Unfit("; ".join(error.lines)) from error
    arguments = [placed(place) + ("" if value is None else f"={toml_value(value)}") for place, value in remedy.keys]
    job.before = ("case", "set", context.machine.argument, *arguments)
    notes = [f"{key}: {_shown(before)} → {_shown(after)}" for key, before, after in written.changes]
    job.notes = (
        *notes,
        *([] if written.earlier is None else [f"{written.earlier.parent.name}/{written.earlier.name}"]),
    )
    return job


def remedies(context: Context, there: Workspace, fields: Fields) -> list[Remedy]:
    """The remedies by keys that findings of a result name, or the refusal of a recording."""
    name = field(fields, "result")
    if name:
        result = next(result for result in there.results if result.name == _result(there, fields))
        stated = [each for finding in result.record.get("findings", ()) for each in remedies_of(finding)]
    else:
        refused = context.jobs.latest(context.machine.key, "identify", _recording(there, fields))
        stated = remedies_of(refused.answer) if refused is not None and refused.state == "failed" else []
    return stated


def remedies_of(answer: Any) -> list[Remedy]:
    """Remedies in an answer, or in a finding of a result file."""
    if not isinstance(answer, Mapping):
        return []
    return [
        Remedy(str(each["words"]), tuple(Write(tuple(place), value) for place, value in each["keys"]))
        for each in answer.get("remedies") or ()
    ]


def _shown(value: Any) -> str:
    return "–" if value is None else toml_value(value)


def _identify(context: Context, there: Workspace, fields: Fields) -> Job:
    recording = _recording(there, fields)
    output = context.free(f"{Path(recording).stem}-result")
    goto = f"{context.address}/result?result={quote(output)}"
    command = forms.identify(context.machine, recording, output)
    return _job(
        context, "data", command, output=output, about=recording, query=f"?recording={quote(recording)}", goto=goto
    )


def _result(there: Workspace, fields: Fields, name: str = "result") -> str:
    return chosen(fields, name, [result.name for result in there.results])


def _export(context: Context, there: Workspace, fields: Fields) -> Job:
    from identification.results.frames import FRAMES
    from postprocessors.export.targets import LINKS, TARGETS

    result, target = _result(there, fields), chosen(fields, "to", TARGETS)
    query = f"?result={quote(result)}&to={quote(target)}"
    command = ["export", forms.place(result), "--to", target, "--case", context.machine.argument]
    frame = chosen(fields, "frame", ("", *FRAMES), "")
    if frame and target in LINKS:
        command += ["--frame", frame]
    if field(fields, "preview"):
        return _job(
            context, "use", [*command, "--preview"], about=result, query=query, goto=f"{context.address}/use{query}"
        )
    output = context.free(f"{result}-{target}", suffix_of(target))
    force = ["--force"] if field(fields, "force") else []
    goto = f"{context.address}/use{query}"
    return _job(context, "use", [*command, *force, "-o", output], output=output, about=result, query=query, goto=goto)


def suffix_of(target: str) -> str:
    """The suffix of what an export writes; empty where it is a folder."""
    from postprocessors.export.targets import SINGLE_FILES

    return SINGLE_FILES[target].suffix if target in SINGLE_FILES else ""


def _force(context: Context, there: Workspace, fields: Fields) -> Job:
    result, recording = _result(there, fields), _recording(there, fields)
    output = context.free(f"{Path(recording).stem}-force", ".csv")
    names = [forms.place(recording), "--parameters", forms.place(result), "--case", context.machine.argument]
    query = f"?result={quote(result)}"
    return _job(
        context, "use", ["force", *names, "-o", output], output=output, about=result, query=query,
        goto=f"{context.address}/use{query}",
    )  # fmt: skip


def _tare(context: Context, there: Workspace, fields: Fields) -> Job:
    result, recording = _result(there, fields), _recording(there, fields)
    output = context.free(f"{result}-tared")
    names = [forms.place(recording), "--parameters", forms.place(result), "--case", context.machine.argument]
    goto = f"{context.address}/result?result={quote(output)}&other={quote(result)}"
    query = f"?result={quote(result)}"
    return _job(context, "result", ["tare", *names, "-o", output], output=output, about=result, query=query, goto=goto)


def _payload(context: Context, there: Workspace, fields: Fields) -> Job:
    before, after = _result(there, fields, "before"), _result(there, fields, "after")
    command = ["payload", forms.place(before), forms.place(after), "--case", context.machine.argument]
    for name, (unit, low, high) in REFERENCES.items():
        if field(fields, f"r.{name}"):
            value, expanded = forms.number(fields, f"r.{name}", low, high), forms.number(fields, f"U.{name}", 0, high)
            command.append(f"--reference={name}={value}+-{expanded}{unit}")
    query = f"?result={quote(after)}"
    return _job(context, "result", command, about=after, query=query, goto=f"{context.address}/result{query}#payload")


def _pool(context: Context, there: Workspace, fields: Fields) -> Job:
    known = [result.name for result in there.results]
    names = [name for name in known if name in fields.get("results", ())]
    if len(names) < 2:
        raise Unfit("results: choose two or more to pool")
    output = context.free(f"{_name(context)}-pooled")
    command = ["pool", *map(forms.place, names), "--case", context.machine.argument, "-o", output]
    goto = f"{context.address}/result?result={quote(output)}"
    return _job(context, "result", command, output=output, goto=goto)


REFERENCES: Mapping[str, tuple[str, float, float]] = {
    "m": ("kg", 0.0, 1e5), "xC": ("mm", -1e5, 1e5), "yC": ("mm", -1e5, 1e5), "zC": ("mm", -1e5, 1e5),
}  # fmt: skip
"""Parameters that a payload may be compared in: unit of the form, least and largest value."""


def _certificate(context: Context, there: Workspace, fields: Fields) -> Job:
    result = _result(there, fields)
    output = context.free(f"{result}-certificate", ".pdf")
    command = ["certificate", forms.place(result), "--case", context.machine.argument]
    for name in ("operator", "conditions", "number"):
        if text := field(fields, name):
            command.append(f"--{name}={line(name, text)}")
    query = f"?result={quote(result)}"
    goto = f"{context.address}/use{query}#certificate"
    return _job(context, "use", [*command, "-o", output], output=output, about=result, query=query, goto=goto)


def line(name: str, text: str) -> str:
    """A text of one line; raises Unfit for any other."""
    if len(text) > 500 or not text.isprintable():
        raise Unfit(f"{name}: is too long, or has control characters")
    return text


def _verify(context: Context, there: Workspace, fields: Fields) -> Job:
    """`certificate --verify`."""
    known = [file.name for file in context.root.glob("*.pdf") if file.is_file()]
    file, result = chosen(fields, "certificate", known), _result(there, fields)
    query = f"?result={quote(result)}&certificate={quote(file)}"
    of = ["--result", forms.place(result), "--case", context.machine.argument]
    goto = f"{context.address}/use{query}#certificate"
    command = ["certificate", forms.place(file), "--verify", *of]
    return _job(context, "use", command, about=file, query=query, goto=goto)


def _history(context: Context, there: Workspace, fields: Fields) -> Job:
    """`history` of all results of the machine in the folder."""
    output = context.free(f"{_name(context)}-history", ".html")
    names = [forms.place(result.name) for result in there.results]
    if not names:
        raise Unfit("results: there is none yet")
    command = ["history", *names, "--case", _name(context), "-o", output]
    goto = f"{context.address}/use#history"
    return _job(context, "use", command, output=output, about="history", goto=goto)


LIMITS = (
    "noise_times", "mass_percent", "path_percent", "duration_percent", "path_error_mm", "deviations.mass_kg",
    "deviations.centre_of_gravity_mm", "deviations.inertia_kg_m2", "deviations.offset_N", "deviations.offset_Nm",
    "reference.mass_kg", "reference.mass_U_kg",
)  # fmt: skip
"""Keys of `[accept]` that a form states."""
ISSUED = ("laboratory", "serial_numbers.machine", "serial_numbers.sensors")
"""Keys of `[certificate]` that a form states."""


def state(context: Context, fields: Fields) -> str:
    """Writes acceptance limits, or what certificates say of the machine, into the case; returns where to go.

    Raises:
        Unfit: a value cannot be, or the case is built in.
    """
    if not context.machine.own:
        raise Unfit("a built-in case is not changed")
    writes = list[Write]()
    for key in LIMITS:
        if f"accept.{key}" in fields:
            typed = field(fields, f"accept.{key}")
            value = float(forms.number(fields, f"accept.{key}", 0, 1e9)) if typed else None
            writes.append(Write(("accept", *key.split(".")), value))
    for key in ISSUED:
        if f"certificate.{key}" in fields:
            text = line(key, field(fields, f"certificate.{key}"))
            writes.append(Write(("certificate", *key.split(".")), text or None))
    try:
        write_keys(context.machine.file, writes)
    except HexciteError as error:
        raise Unfit("; ".join(error.lines)) from error
    stage = chosen(fields, "stage", ("result", "use"))
    return f"{context.address}/{stage}?result={quote(field(fields, 'result'))}&stated=1"


ACTIONS: Mapping[str, Action] = {
    "check": _check, "box": _box, "plan": _plan, "program": _program, "rehearse": _rehearse, "look": _look,
    "take": _take, "menus": _menus, "identify": _identify, "apply": _apply, "export": _export, "force": _force,
    "tare": _tare, "payload": _payload, "pool": _pool, "certificate": _certificate, "verify": _verify,
    "history": _history,
}  # fmt: skip
"""Name in an address -> what it starts."""


def new(root: Path, fields: Fields) -> Job:
    """`hexcite case new`, from a built-in case or from a URDF file of the root."""
    name = field(fields, "name")
    if not name or name.startswith("-") or "/" in name or "\\" in name or len(name) > 100:
        raise Unfit(f"{name!r} is not a name of a machine")
    urdf, like = field(fields, "urdf"), field(fields, "like")
    if urdf:
        chosen(fields, "urdf", [file.name for file in root.glob("*.urdf")])
        flange = [f"--flange={field(fields, 'flange')}"] if field(fields, "flange") else []
        command = ["case", "new", name, "--urdf", forms.place(urdf), *flange]
    else:
        chosen(fields, "like", built_in_cases())
        command = ["case", "new", name, "--like", like]
    return Job("", "machine", tuple(command), output=name, goto=f"/m/+{quote(name)}/machine")


class Saved(NamedTuple):
    """What became of a form of values: why it was not written, a sentence or the key of a text; what was converted."""

    refused: str
    converted: tuple[str, ...] = ()


def save(context: Context, fields: Fields) -> Saved:
    """Writes changed values into a case of one's own."""
    if not context.machine.own:
        raise Unfit("a built-in case is not changed")
    content = context.machine.file.read_text(encoding="utf-8")
    if values.digest(content) != field(fields, "digest"):
        return Saved("changed_elsewhere")
    try:
        written = values.edited(content, given_values(fields), context.machine.file)
    except values.Refused as error:
        return Saved(str(error))
    if context.machine.case is not None:  # one that cannot be read yet is filled in step by step
        try:
            values.case_of(written.text, context.machine.file)
        except values.Refused as error:
            return Saved(str(error))
    values.save(context.machine.file, written.text)
    return Saved("", written.converted)


def given_values(fields: Fields) -> dict[str, str]:
    """What a form says of values, by the names of its fields."""
    return {name: field(fields, name) for name in fields if name.partition(".")[0] in ("v", "u", "w", "on")}
