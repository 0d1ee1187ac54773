"""What forms of the stages ask for: commands as jobs, and values that are written into a case."""

from collections.abc import Mapping

from hexcite.page.actions import data, machine, plan, program, result, use
from hexcite.page.actions.common import Action, Context
from hexcite.page.forms import Fields
from hexcite.page.jobs import Job
from hexcite.page.stages import workspace

ACTIONS: Mapping[str, Action] = {
    name: action for part in (machine, plan, program, data, result, use) for name, action in part.ACTIONS.items()
}
"""Name in an address -> what it starts."""


def asked(action: Action, context: Context, fields: Fields) -> Job:
    """The job of an action."""
    return action(context, workspace(context.root, context.machine), fields)
