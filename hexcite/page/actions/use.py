"""Actions of the stage Use."""

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import quote

from hexcite.page import forms
from hexcite.page.actions.common import Action, Context, case_name, job_of, line, recording_of, result_of
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import Job
from hexcite.page.refusals import Unfit
from hexcite.page.stages import Workspace


def _export(context: Context, there: Workspace, fields: Fields) -> Job:
    from identification.options import FRAMES
    from postprocessors.export.targets import FRAMED, TARGETS

    result, target = result_of(there, fields), chosen(fields, "to", TARGETS)
    query = f"?result={quote(result)}&to={quote(target)}"
    command = ["export", forms.place(result), "--to", target, "--case", context.machine.argument]
    frame = chosen(fields, "frame", ("", *FRAMES), "")
    if frame and target in FRAMED:
        command += ["--frame", frame]
    if field(fields, "preview"):
        return job_of(
            context, "use", [*command, "--preview"], about=result, query=query, goto=f"{context.address}/use{query}"
        )
    output = context.free(f"{result}-{target}", suffix_of(target))
    force = ["--force"] if field(fields, "force") else []
    goto = f"{context.address}/use{query}"
    return job_of(context, "use", [*command, *force, "-o", output], output=output, about=result, query=query, goto=goto)


def suffix_of(target: str) -> str:
    """The suffix of what an export writes; empty where it is a folder."""
    from postprocessors.export.targets import SINGLE_FILES

    return SINGLE_FILES[target].suffix if target in SINGLE_FILES else ""


def _force(context: Context, there: Workspace, fields: Fields) -> Job:
    result, recording = result_of(there, fields), recording_of(context, there, fields)
    output = context.free(f"{Path(recording.name).stem}-force", ".csv")
    names = [
        *map(forms.place, recording.arguments),
        "--parameters",
        forms.place(result),
        "--case",
        context.machine.argument,
    ]
    query = f"?result={quote(result)}"
    return job_of(
        context, "use", ["force", *names, "-o", output], output=output, about=result, query=query,
        goto=f"{context.address}/use{query}",
    )  # fmt: skip


def _certificate(context: Context, there: Workspace, fields: Fields) -> Job:
    result = result_of(there, fields)
    output = context.free(f"{result}-certificate", ".pdf")
    command = ["certificate", forms.place(result), "--case", context.machine.argument]
    for name in ("operator", "conditions", "number"):
        if text := field(fields, name):
            command.append(f"--{name}={line(name, text)}")
    if context.words.language != "en":
        command.append(f"--language={context.words.language}")
    query = f"?result={quote(result)}"
    goto = f"{context.address}/use{query}#certificate"
    return job_of(context, "use", [*command, "-o", output], output=output, about=result, query=query, goto=goto)


def _verify(context: Context, there: Workspace, fields: Fields) -> Job:
    """`certificate --verify`."""
    certificates = [file.name for file in context.root.glob("*.pdf") if file.is_file()]
    file, result = chosen(fields, "certificate", certificates), result_of(there, fields)
    query = f"?result={quote(result)}&certificate={quote(file)}"
    of = ["--result", forms.place(result), "--case", context.machine.argument]
    goto = f"{context.address}/use{query}#certificate"
    command = ["certificate", forms.place(file), "--verify", *of]
    return job_of(context, "use", command, about=file, query=query, goto=goto)


def _history(context: Context, there: Workspace, fields: Fields) -> Job:
    """`history` of all results of the machine in the folder."""
    output = context.free(f"{case_name(context)}-history", ".html")
    names = [forms.place(result.name) for result in there.results]
    if not names:
        raise Unfit("no_results")
    command = ["history", *names, "--case", case_name(context), "-o", output]
    goto = f"{context.address}/use#history"
    return job_of(context, "use", command, output=output, about="history", goto=goto)


ACTIONS: Mapping[str, Action] = {
    "export": _export,
    "force": _force,
    "certificate": _certificate,
    "verify": _verify,
    "history": _history,
}
"""Name in an address -> what it starts."""
