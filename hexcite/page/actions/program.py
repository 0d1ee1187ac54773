"""Actions of the stage Program."""

import tomllib
from collections.abc import Mapping
from urllib.parse import quote

from cases.base.places import placed
from cases.base.text_formats import toml_value
from cases.controller import ControllerName
from cases.readiness import languages_of
from hexcite.page import forms
from hexcite.page.actions.common import Action, Context, job_of
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import SETTINGS, Job
from hexcite.page.keys import missing
from hexcite.page.machine_inis import ini_of
from hexcite.page.refusals import Unfit
from hexcite.page.stages import FORMS, Workspace


def _program(context: Context, there: Workspace, fields: Fields) -> Job:
    plan = chosen(fields, "plan", [plan.name for plan in there.plans])
    dialect = chosen(fields, "dialect", context.machine.dialects)
    from postprocessors.program import DIALECTS

    slow = "-slow" if field(fields, "speed") == "slow" else ""
    forms_of = FORMS.get(dialect, ())
    suffix = chosen(fields, "form", forms_of, forms_of[0]) if forms_of else DIALECTS[dialect].suffix
    output = context.free(f"{plan}{slow}", suffix)
    query = f"?plan={quote(plan)}"
    goto = f"{context.address}/program?plan={quote(plan)}&program={quote(output)}"
    ini = ini_of(context.root, field(fields, "ini")) if dialect == "linuxcnc" else ""
    command = forms.post(fields, plan, dialect, output, ini)
    return job_of(context, "program", command, output=output, about=plan, query=query, goto=goto)


def without_settings(context: Context) -> list[str]:
    """Controllers that the machine can have, of which it has no settings."""
    case = context.machine.case
    ready = (*context.machine.dialects, ControllerName.VIRTUAL)
    return [] if case is None else [str(name) for name in languages_of(case) if name not in ready]


def _settings(context: Context, there: Workspace, fields: Fields) -> Job:
    """Usual settings of a controller that the case says nothing of, as `hexcite case set` writes them."""
    machine = context.machine
    plan = chosen(fields, "plan", [plan.name for plan in there.plans])
    if not machine.own or machine.case is None:
        raise Unfit("built_in_stays")
    control = chosen(fields, "control", without_settings(context))
    content = machine.file.read_text(encoding="utf-8")
    keys = [
        f"{placed(place)}={toml_value(value)}"
        for place, value in missing(tomllib.loads(content), machine.case, content).items()
        if place[:2] == ("controller", control) and value is not None
    ]
    goto = f"{context.address}/program?plan={quote(plan)}&dialect={quote(control)}"
    command = ["case", "set", machine.argument, *keys]
    return job_of(context, "program", command, about=SETTINGS, query=f"?plan={quote(plan)}", goto=goto, writes=True)


ACTIONS: Mapping[str, Action] = {
    "settings": _settings,
    "program": _program,
}
"""Name in an address -> what it starts."""
