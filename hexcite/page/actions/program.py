"""Actions of the stage Program."""

from collections.abc import Mapping
from urllib.parse import quote

from hexcite.page import forms
from hexcite.page.actions.common import Action, Context, job_of
from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import Job
from hexcite.page.machine_inis import ini_of
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


ACTIONS: Mapping[str, Action] = {
    "program": _program,
}
"""Name in an address -> what it starts."""
