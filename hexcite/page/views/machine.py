"""The start page and the stage Machine: values of the case, its drawings, its check."""

from pathlib import Path
from typing import Any

from cases.base.errors import HexciteError
from cases.schema import Case
from hexcite.page import drawing, values
from hexcite.page.actions.common import Context
from hexcite.page.actions.machine import given_values
from hexcite.page.forms import Fields
from hexcite.page.stages import Workspace, built_in, own_machines
from hexcite.page.views.common import Query


def machines(root: Path) -> dict[str, Any]:
    """Machines to choose from, and the URDF files to begin from."""
    return {
        "own": own_machines(root),
        "built_in": built_in(),
        "urdfs": sorted(file.name for file in root.glob("*.urdf") if file.is_file()),
    }


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Machine shows of a machine, for its template."""
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
        **drawn(machine.case),
    }


def drawn(case: Case | None, problem: str = "") -> dict[str, Any]:
    """The drawings of a case, or why there are none."""
    if case is None:
        return {"views": None, "why": problem, "converted": ()}
    try:
        return {"views": drawing.views(case), "why": "", "converted": ()}
    except HexciteError as error:
        return {"views": None, "why": "; ".join(error.lines), "converted": ()}


def preview(context: Context, fields: Fields) -> dict[str, Any]:
    """The drawings of a case with values that are not written yet."""
    content = context.machine.file.read_text(encoding="utf-8")
    try:
        written = values.edited(content, given_values(fields), context.machine.file)
        case = values.case_of(written.text, context.machine.file)
    except values.Refused as error:
        return {"views": None, "why": str(error), "converted": ()}
    return {**drawn(case), "converted": written.converted}
