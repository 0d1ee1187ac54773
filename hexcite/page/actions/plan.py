"""Actions of the stage Plan."""

from collections.abc import Mapping
from urllib.parse import quote

from hexcite.page import forms
from hexcite.page.actions.common import Action, Context, case_name, job_of
from hexcite.page.forms import BY_HAND, Fields, field
from hexcite.page.jobs import Job
from hexcite.page.stages import Workspace


def _plan(context: Context, there: Workspace, fields: Fields) -> Job:
    family = field(fields, "family", "best")
    output = context.free(f"{case_name(context)}-{'plan' if family in ('best', '') else family}")
    command = forms.plan(context.machine, fields, output, [result.name for result in there.results if result.fresh])
    goto = f"{context.address}/plan?plan={quote(output)}"
    search = command[0] == "plan" and family != BY_HAND
    return job_of(
        context, "plan", command, output=output, goto=goto, search=search, beside=_by_hand(context, there, family)
    )


def _by_hand(context: Context, there: Workspace, family: str) -> tuple[Job, ...]:
    """The manual motion, that the plan is compared with, where there is none that is up to date nor under way."""
    latest = context.jobs.latest(context.machine.key, "plan", BY_HAND)
    under_way = latest is not None and not latest.over
    if family == BY_HAND or under_way or any(plan.fresh and plan.by_hand for plan in there.plans):
        return ()
    output = context.free(f"{case_name(context)}-{BY_HAND}")
    command = forms.plan(context.machine, {"family": [BY_HAND]}, output)
    return (job_of(context, "", command, output=output, about=BY_HAND),)


ACTIONS: Mapping[str, Action] = {
    "plan": _plan,
}
"""Name in an address -> what it starts."""
