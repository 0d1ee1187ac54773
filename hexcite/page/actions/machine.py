"""Actions of the stage Machine: checks, the motion box, a new case, changed values."""

import re
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from cases.base.errors import HexciteError, Write
from cases.editing import write_keys
from cases.tables import CASE_FILE, built_in_cases
from hexcite.page import forms, joint_table, values
from hexcite.page.actions.common import Action, Context, job_of
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import CHECK, Job
from hexcite.page.refusals import Refusal, Refused, Unfit
from hexcite.page.stages import Workspace, own_machines


def _check(context: Context, there: Workspace, fields: Fields) -> Job:
    propose = ["--propose"] if field(fields, "propose") else []
    return job_of(context, "machine", ["case", "check", context.machine.argument, *propose], about=CHECK)


def _box(context: Context, there: Workspace, fields: Fields) -> Job:
    """The box that the last check proposed becomes that of `[limits.motion]`, and is checked."""
    checked = context.jobs.latest(context.machine.key, "case", "check")
    proposal = ((checked.answer if checked is not None else None) or {}).get("proposal")
    if not context.machine.own or not proposal:
        raise Unfit("no_proposal")
    values.write_motion_box(context.machine.file, proposal["limits_motion"])
    return _check(context, there, {})


def _mine(context: Context, there: Workspace, fields: Fields) -> Job:
    """All values are those of the user's machine: the line that names the example goes, and the case is checked."""
    if not context.machine.own:
        raise Unfit("built_in_stays")
    try:
        write_keys(context.machine.file, [Write(("template",), None)])
    except HexciteError as error:
        raise Unfit.of(error.sentences) from error
    return _check(context, there, {})


def new(root: Path, fields: Fields) -> Job:
    """`hexcite case new`, from a case, built in or of the root, or from a URDF file of the root."""
    name = field(fields, "name")
    if not name or name.startswith("-") or "/" in name or "\\" in name or len(name) > 100:
        raise Unfit("no_machine_name", name=name)
    name = _as_name(name)
    urdf, like = field(fields, "urdf"), field(fields, "like")
    if urdf:
        chosen(fields, "urdf", [file.name for file in root.glob("*.urdf")])
        links = [f"--{key}={field(fields, key)}" for key in ("flange", "sensor") if field(fields, key)]
        bodies = ["--bodies"] if field(fields, "bodies") else []
        command = ["case", "new", name, "--urdf", forms.place(urdf), *links, *bodies]
    else:
        chosen(fields, "like", [*built_in_cases(), *(machine.key for machine in own_machines(root))])
        command = ["case", "new", name, "--like", f"{like[1:]}/{CASE_FILE}" if like.startswith("+") else like]
    return Job("", "machine", tuple(command), output=name, goto=f"/m/+{quote(name)}/machine")


def _as_name(typed: str) -> str:
    """A name of a case, as near to what was typed as can be: hx_260 of HX-260; raises Unfit where nothing is left."""
    plain = unicodedata.normalize("NFKD", typed.lower()).encode("ascii", "ignore").decode()
    name = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")
    if not name:
        raise Unfit("no_machine_name", name=typed)
    return name if name[0].isalpha() else f"machine_{name}"


class Saved(NamedTuple):
    """What became of a form of values: why it was not written, None where it was; what was converted."""

    refused: Refusal | None
    converted: tuple[str, ...] = ()


def save(context: Context, fields: Fields) -> Saved:
    """Writes changed values into a case of one's own."""
    if not context.machine.own:
        raise Unfit("built_in_stays")
    content = context.machine.file.read_text(encoding="utf-8")
    if values.digest(content) != field(fields, "digest"):
        return Saved(Refused("changed_elsewhere"))
    try:
        written = values.edited(content, given := given_values(fields), context.machine.file)
    except Refused as error:
        return Saved(error)
    if context.machine.case is not None:  # one that cannot be read yet is filled in step by step
        try:
            values.case_of(written.text, context.machine.file, given)
        except Refused as error:
            return Saved(error)
    values.save(context.machine.file, written.text)
    return Saved(None, written.converted)


def given_values(fields: Fields) -> dict[str, str]:
    """What a form says of values, by the names of its fields."""
    values = {name: field(fields, name) for name in fields if name.partition(".")[0] in ("v", "u", "w", "on")}
    return joint_table.spread(values)


ACTIONS: Mapping[str, Action] = {
    "check": _check,
    "box": _box,
    "mine": _mine,
}
"""Name in an address -> what it starts."""
