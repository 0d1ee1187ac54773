"""The stage Data: recordings, and how each is read."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cases.base.errors import HexciteError
from cases.schema import Case
from hexcite.page.actions.common import Context
from hexcite.page.actions.data import remedies_of
from hexcite.page.jobs import Job
from hexcite.page.stages import Machine, Recording, Workspace
from hexcite.page.views.common import Query, chosen, remedies


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Data shows of a machine, for its template."""
    from postprocessors.controllers.linuxcnc.session import linuxcnc_missing

    recording: Recording | None = chosen(there.recordings, query.get("recording"))
    looked = context.jobs.latest(context.machine.key, "look", recording.name) if recording is not None else None
    answer = looked.answer if looked is not None and looked.over and _since(looked, context.machine) else None
    refused = context.jobs.latest(context.machine.key, "identify", recording.name) if recording is not None else None
    stated = remedies_of(refused.answer) if refused is not None and refused.state == "failed" else []
    picture = f"{Path(recording.name).stem}-look.svg" if recording is not None else ""
    return {
        "recordings": there.recordings,
        "chosen": recording,
        "programs": there.programs,
        "controllers": ("virtual",) if linuxcnc_missing() is not None else ("virtual", "linuxcnc"),
        "cannot_run": context.machine.lacks("run"),
        "looked": answer,
        "remedies": remedies(stated),
        "menus": _menus(context.machine.case, answer) if answer is not None else None,
        "picture": picture if answer is not None and (context.root / picture).is_file() else "",
    }


def _since(looked: Job, machine: Machine) -> bool:
    """Whether the case is still the one that a file was looked at with."""
    return looked.finished >= machine.file.stat().st_mtime


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
