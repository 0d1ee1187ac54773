"""What the actions of all stages share."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from hexcite.page.forms import Fields, chosen, field
from hexcite.page.jobs import Job, Jobs
from hexcite.page.refusals import NoRecording, Unfit
from hexcite.page.stages import Machine, Recording, Workspace, free, is_program
from hexcite.page.words import ENGLISH, Words


@dataclass(frozen=True)
class Context:
    """The machine that a request is about, the root folder, the commands under way, and the language."""

    root: Path
    machine: Machine
    jobs: Jobs
    words: Words = ENGLISH

    @property
    def address(self) -> str:
        """Of its stages."""
        return f"/m/{quote(self.machine.key, safe='+')}"

    def free(self, name: str, suffix: str = "") -> str:
        """A name for what a command writes."""
        return free(self.root, name, self.jobs.outputs, suffix)


Action = Callable[[Context, Workspace, Fields], Job]


def case_name(context: Context) -> str:
    """Name of the machine's case; raises Unfit where its file is not read."""
    if context.machine.case is None:
        raise Unfit("", sentence=context.machine.problem)
    return context.machine.case.name


def job_of(context: Context, stage: str, command: list[str], **more: Any) -> Job:
    """A command as a job of a stage; `more` as `Job` has it."""
    return Job(context.machine.key, stage, tuple(command), **more)


def recording_of(context: Context, there: Workspace, fields: Fields) -> Recording:
    """The recording that a form chose; raises Unfit where there is none of this name."""
    names = {recording.name for recording in there.recordings}
    if (asked := field(fields, "recording")) not in names and is_program(context.root, asked):
        raise NoRecording(asked)
    name = chosen(fields, "recording", [recording.name for recording in there.recordings])
    return next(recording for recording in there.recordings if recording.name == name)


def result_of(there: Workspace, fields: Fields, name: str = "result") -> str:
    """The result that a field chose; raises Unfit where there is none of this name."""
    return chosen(fields, name, [result.name for result in there.results])


def line(name: str, text: str) -> str:
    """A text of one line; raises Unfit for any other."""
    if len(text) > 500 or not text.isprintable():
        raise Unfit("no_line", place=name)
    return text
