"""The stage Data: recordings, and how each is read."""

from pathlib import Path
from typing import Any

from hexcite.page import reading
from hexcite.page.actions.common import Context
from hexcite.page.actions.data import for_linuxcnc, looked_at, remedies_of
from hexcite.page.forms import ini_in
from hexcite.page.machine_inis import inis
from hexcite.page.stages import RECORDINGS, Recording, Workspace, is_program
from hexcite.page.views.common import Query, chosen, recording_in, remedies


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Data shows of a machine, for its template."""
    from postprocessors.controllers.linuxcnc.session import linuxcnc_missing

    recording: Recording | None = chosen(there.recordings, query.get("recording"))
    answer = looked_at(context, recording.name) if recording is not None else None
    refused = context.jobs.latest(context.machine.key, "identify", recording.name) if recording is not None else None
    stated = remedies_of(refused.answer) if refused is not None and refused.state == "failed" else []
    picture = f"{Path(recording.name).stem}-look.svg" if recording is not None else ""
    program = query.get("program", "")
    on_linuxcnc = any(for_linuxcnc(each.name) for each in there.programs)
    return {
        "recordings": there.recordings,
        "no_recording": program if program and is_program(context.root, program) else "",
        "chosen": recording,
        "programs": there.programs,
        "kinds": ", ".join(sorted(RECORDINGS)),
        "come_to": {each.name: state for each in there.recordings if (state := _come_to(context, there, each))},
        "controllers": ("virtual", "linuxcnc")
        if on_linuxcnc and "linuxcnc" in context.machine.dialects and linuxcnc_missing() is None
        else ("virtual",),
        **_inis(context, there),
        "cannot_run": context.machine.lacks("run"),
        "looked": answer,
        "remedies": remedies(stated),
        "forms": () if answer is None else reading.tables(context.words, answer, context.machine.case),
        "reading": reading,
        "picture": picture if answer is not None and (context.root / picture).is_file() else "",
    }


def _come_to(context: Context, there: Workspace, recording: Recording) -> str:
    """What came of a recording: identified, refused, read, unread; empty where nothing was asked."""
    key = context.machine.key
    identified = context.jobs.latest(key, "identify", recording.name)
    if identified is not None and identified.state in ("done", "failed"):
        return "identified" if identified.state == "done" else "refused"
    if any(recording_in(result.record) == recording.name for result in there.results):
        return "identified"
    looked = context.jobs.latest(key, "look", recording.name)
    return "" if looked is None or looked.answer is None else "read" if looked.answer.get("reads") else "unread"


def _inis(context: Context, there: Workspace) -> dict[str, Any]:
    """INI files that a rehearsal on LinuxCNC may be compared with, and that which the newest program was."""
    written = [context.jobs.latest(context.machine.key, "post", program.plan) for program in there.programs[:1]]
    used = next((ini_in(job.command) for job in written if job is not None), "")
    return {"inis": inis(context.root), "ini": used}
