"""Actions of the stage Plan."""

from collections.abc import Mapping
from urllib.parse import quote

from hexcite.page import forms
from hexcite.page.actions.common import Action, Context, case_name, job_of
from hexcite.page.forms import Fields, field
from hexcite.page.jobs import Job
from hexcite.page.stages import Workspace


def _plan(context: Context, there: Workspace, fields: Fields) -> Job:
    family = field(fields, "family", "best")
    output = context.free(f"{case_name(context)}-{'plan' if family in ('best', '') else family}")
    command = forms.plan(context.machine, fields, output)
    goto = f"{context.address}/plan?plan={quote(output)}"
    search = command[0] == "plan" and family != "manual"
    return job_of(context, "plan", command, output=output, goto=goto, search=search)


ACTIONS: Mapping[str, Action] = {
    "plan": _plan,
}
"""Name in an address -> what it starts."""
