"""Acceptance limits, and what certificates say of a machine: written into the case at once."""

from urllib.parse import quote

from cases.base.errors import HexciteError, Write
from cases.editing import write_keys
from hexcite.page import forms
from hexcite.page.actions.common import Context, line
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.refusals import Unfit

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
        raise Unfit("built_in_stays")
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
        raise Unfit.of(error.sentences) from error
    stage = chosen(fields, "stage", ("result", "use"))
    return f"{context.address}/{stage}?result={quote(field(fields, 'result'))}&stated=1"
