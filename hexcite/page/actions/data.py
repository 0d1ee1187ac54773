"""Actions of the stage Data: a rehearsal, how a file is read, remedies by keys, identification."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pydantic import ValidationError

from cases.base.errors import HexciteError, Remedy, Write
from cases.base.places import placed
from cases.base.text_formats import toml_value
from cases.editing import write_keys, write_table
from cases.recording_format import RecordingFormat
from hexcite.page import forms, reading
from hexcite.page.actions.common import Action, Context, job_of, recording_of, result_of
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import Job
from hexcite.page.machine_inis import ini_of
from hexcite.page.refusals import Unfit
from hexcite.page.stages import RUN_FILE, Workspace

KEPT_UNITS = ("recording.units", "recording.clock")  # keys whose change is said beside the result


def for_linuxcnc(program: str) -> bool:
    """Whether a rehearsal on LinuxCNC may execute a program."""
    from postprocessors.program import DIALECTS

    return program.endswith(DIALECTS["linuxcnc"].suffixes)


def _rehearse(context: Context, there: Workspace, fields: Fields) -> Job:
    program = chosen(fields, "program", [program.name for program in there.programs])
    output = context.free(f"{Path(program).stem}-recording")
    goto = f"{context.address}/data?recording={quote(output)}"
    on = chosen(fields, "on", ("virtual", "linuxcnc"), "virtual")
    if on == "linuxcnc" and not for_linuxcnc(program):
        raise Unfit("not_for_linuxcnc", name=program)
    ini = ini_of(context.root, field(fields, "ini")) if on == "linuxcnc" else ""
    command = forms.run(context.machine, program, on, output, ini)
    return job_of(context, "data", command, output=output, goto=goto)


def _look(context: Context, there: Workspace, fields: Fields, write: bool = False) -> Job:
    recording = recording_of(context, there, fields)
    query = f"?recording={quote(recording.name)}"
    picture = f"{Path(recording.name).stem}-look.svg"
    files = (f"{recording.name}/{RUN_FILE}",) if recording.simulated else recording.arguments
    command = forms.look(context.machine, files, picture, write)
    goto = f"{context.address}/data{query}"
    return job_of(context, "data", command, about=recording.name, query=query, goto=goto, writes=write)


def _take(context: Context, there: Workspace, fields: Fields) -> Job:
    """`look --write`: the proposal becomes the case's; and with `identify` in the form what was written is used."""
    if not context.machine.own:
        raise Unfit("built_in_stays")
    writing = _look(context, there, fields, write=True)
    if not field(fields, "identify"):
        return writing
    job, look_job = _identify(context, there, fields), _looked(context, field(fields, "recording"))
    changes = write_table(context.machine.file, "recording", look_job["settings"])
    job.before = writing.command
    units = [change for change in changes if change[1] is not None and change[0].startswith(KEPT_UNITS)]
    job.notes = (*(f"{key}: {_shown(before)} → {_shown(after)}" for key, before, after in units), "") if units else ()
    return job


def _looked(context: Context, recording: str) -> Mapping[str, Any]:
    """What the latest look at a recording answered, by the case as it is now."""
    answer = looked_at(context, recording)
    if answer is None:
        raise Unfit("look_at_it_first", place=recording)
    return answer


def looked_at(context: Context, recording: str) -> Mapping[str, Any] | None:
    """What the latest look at a recording answered, where that still holds; None where one has to look again.

    It holds for the case that it was asked of, and for one that states what it proposed.
    """
    look_job = context.jobs.latest(context.machine.key, "look", recording)
    if look_job is None or look_job.answer is None:
        return None
    if look_job.finished >= context.machine.file.stat().st_mtime:
        return look_job.answer
    case, settings = context.machine.case, look_job.answer.get("settings")
    with suppress(ValidationError):
        if case is not None and settings and case.recording == RecordingFormat.model_validate(settings):
            return {**look_job.answer, "unchanged": True, "changes": []}
    return None


def _menus(context: Context, there: Workspace, fields: Fields) -> Job:
    """What menus say of the columns becomes the `[recording]` of the case, and the file is looked at again."""
    if not context.machine.own:
        raise Unfit("built_in_stays")
    settings = reading.chosen_settings(_looked(context, recording_of(context, there, fields).name), fields)
    write_table(context.machine.file, "recording", settings)
    return _look(context, there, fields)


def _apply(context: Context, there: Workspace, fields: Fields) -> Job:
    """Writes the keys of a remedy into the case, and identifies again where the recording is there."""
    if not context.machine.own:
        raise Unfit("built_in_stays")
    offered = remedies(context, there, fields)
    number = field(fields, "remedy")
    if not number.isdecimal() or int(number) >= len(offered):
        raise Unfit("no_such_remedy")
    remedy = offered[int(number)]
    if field(fields, "words") != remedy.words.strip():
        raise Unfit("other_remedy")
    job = _identify(context, there, fields)
    try:
        written = write_keys(context.machine.file, remedy.keys)
    except HexciteError as error:
        raise Unfit.of(error.sentences) from error
    arguments = [placed(place) + ("" if value is None else f"={toml_value(value)}") for place, value, _ in remedy.keys]
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
        result = next(result for result in there.results if result.name == result_of(there, fields))
        remedies = [each for finding in result.record.get("findings", ()) for each in remedies_of(finding)]
    else:
        refused = context.jobs.latest(context.machine.key, "identify", recording_of(context, there, fields).name)
        remedies = remedies_of(refused.answer) if refused is not None and refused.state == "failed" else []
    return remedies


def remedies_of(answer: Any) -> list[Remedy]:
    """Remedies in an answer, or in a finding of a result file."""
    if not isinstance(answer, Mapping):
        return []
    return [Remedy(str(each["words"]), _writes(each), each.get("phrase")) for each in answer.get("remedies") or ()]


def _writes(remedy: Mapping[str, Any]) -> tuple[Write, ...]:
    """Keys of a remedy, with deviations where results state them."""
    deviations = remedy.get("deviations") or [None] * len(remedy["keys"])
    both = zip(remedy["keys"], deviations, strict=True)
    return tuple(Write(tuple(place), value, deviation) for (place, value), deviation in both)


def _shown(value: Any) -> str:
    return "–" if value is None else toml_value(value)


def _identify(context: Context, there: Workspace, fields: Fields) -> Job:
    recording = recording_of(context, there, fields)
    output = context.free(f"{Path(recording.name).stem}-result")
    goto = f"{context.address}/result?result={quote(output)}"
    command = forms.identify(context.machine, recording.arguments, output)
    query = f"?recording={quote(recording.name)}"
    return job_of(context, "data", command, output=output, about=recording.name, query=query, goto=goto)


ACTIONS: Mapping[str, Action] = {
    "rehearse": _rehearse,
    "look": _look,
    "take": _take,
    "menus": _menus,
    "apply": _apply,
    "identify": _identify,
}
"""Name in an address -> what it starts."""
