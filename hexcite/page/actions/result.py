"""Actions of the stage Result."""

from collections.abc import Mapping
from urllib.parse import quote

from hexcite.page import forms
from hexcite.page.actions.common import Action, Context, case_name, job_of, recording_of, result_of
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import Job
from hexcite.page.refusals import Unfit
from hexcite.page.stages import Workspace

REFERENCES: Mapping[str, tuple[str, float, float]] = {
    "m": ("kg", 0.0, 1e5), "xC": ("mm", -1e5, 1e5), "yC": ("mm", -1e5, 1e5), "zC": ("mm", -1e5, 1e5),
}  # fmt: skip
"""Parameters that a payload may be compared in: unit of the form, least and largest value."""


def _tare(context: Context, there: Workspace, fields: Fields) -> Job:
    result, recording = result_of(there, fields), recording_of(context, there, fields)
    output = context.free(f"{result}-tared")
    names = [
        *map(forms.place, recording.arguments),
        "--parameters",
        forms.place(result),
        "--case",
        context.machine.argument,
    ]
    goto = f"{context.address}/result?result={quote(output)}&other={quote(result)}"
    query = f"?result={quote(result)}"
    return job_of(
        context, "result", ["tare", *names, "-o", output], output=output, about=result, query=query, goto=goto
    )


def _payload(context: Context, there: Workspace, fields: Fields) -> Job:
    """`payload`: a table and its page, or a file for a robot or simulator."""
    from identification.options import FRAMES
    from postprocessors.export.targets import FRAMED, LOADS, SINGLE_FILES

    before, after = result_of(there, fields, "before"), result_of(there, fields, "after")
    command = ["payload", forms.place(before), forms.place(after), "--case", context.machine.argument]
    for name, (unit, low, high) in REFERENCES.items():
        if field(fields, f"r.{name}"):
            value, expanded = forms.number(fields, f"r.{name}", low, high), forms.number(fields, f"U.{name}", 0, high)
            command.append(f"--reference={name}={value}+-{expanded}{unit}")
    to, frame = chosen(fields, "to", ("", *LOADS), ""), chosen(fields, "frame", ("", *FRAMES), "")
    output = context.free(f"{after}-payload{f'-{to}' if to else ''}", SINGLE_FILES[to].suffix if to else ".json")
    if frame and (not to or to in FRAMED):
        command += ["--frame", frame]
    if to:
        command += ["--to", to, *(["--force"] if field(fields, "force") else [])]
    query = f"?result={quote(after)}"
    goto = f"{context.address}/result{query}#payload"
    return job_of(context, "result", [*command, "-o", output], output=output, about=after, query=query, goto=goto)


def _pool(context: Context, there: Workspace, fields: Fields) -> Job:
    results = [result.name for result in there.results]
    names = [name for name in results if name in fields.get("results", ())]
    if len(names) < 2:
        raise Unfit("too_few_results")
    output = context.free(f"{case_name(context)}-pooled")
    command = ["pool", *map(forms.place, names), "--case", context.machine.argument, "-o", output]
    goto = f"{context.address}/result?result={quote(output)}"
    return job_of(context, "result", command, output=output, goto=goto)


ACTIONS: Mapping[str, Action] = {
    "tare": _tare,
    "payload": _payload,
    "pool": _pool,
}
"""Name in an address -> what it starts."""
