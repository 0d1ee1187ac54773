"""What each stage shows: plain values for its template, read from the folders."""

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, Self

from markupsafe import Markup

from cases.base.errors import UNTOUCHED
from cases.readiness import languages_of
from hexcite.page import drawing
from hexcite.page.actions.common import Context
from hexcite.page.jobs import Job
from hexcite.page.stages import STAGES, Machine, built_in, own_machines, workspace
from hexcite.page.words import Words
from hexcite.texts import TEXTS, Language, text


class Example(NamedTuple):
    """A built-in machine that others may begin from.

    Args:
        picture: from the side; empty of sensors without a machine.
        controls: whose programs can be written.
    """

    machine: Machine
    picture: Markup
    controls: tuple[str, ...]

    @classmethod
    def of(cls, machine: Machine) -> Self:
        """Of a machine."""
        planned = not machine.lacks("plan") and machine.case is not None
        picture = drawing.views(machine.case).side if planned and machine.case is not None else Markup("")
        controls = languages_of(machine.case) if planned and machine.case is not None else ()
        return cls(machine, picture, tuple(each for each in controls if each != "virtual"))

    def rank(self) -> tuple[bool, bool]:
        """Of hexapods, then other machines, then sensors alone."""
        return not self.controls, self.machine.case is None or self.machine.case.hexapod is None


def machines(root: Path) -> dict[str, Any]:
    """Machines to choose from, and the URDF files to begin from."""
    return {
        "own": own_machines(root),
        "built_in": sorted(map(Example.of, built_in()), key=Example.rank),
        "urdfs": sorted(file.name for file in root.glob("*.urdf") if file.is_file()),
    }


def stage(context: Context, name: str, query: Mapping[str, str], language: Language) -> dict[str, Any]:
    """What a stage shows of its machine."""
    folder = workspace(context.root, context.machine)
    view: Callable[..., dict[str, Any]] = import_module(f"{__name__}.{name}").shown  # each when it is first asked for
    values = view(context, folder, query)
    states = {stage: folder.state(stage) for stage in STAGES}
    return {"machine": context.machine, "address": context.address, "states": states, "there": folder, **values}


HEAVY = ("scipy.linalg", "casadi", "scipy.spatial.transform", "scipy.optimize", "identification.results.verdicts")
"""What the stages Result and Use need, in pieces that each hold up an answer for a short time only."""

LATE = (
    "hexcite.page.actions.table", "hexcite.reports.plan", "planner.plans.plan",
    "identification.results.frames", "postprocessors.export.targets", "postprocessors.controllers.linuxcnc.session",
    "postprocessors.program",
)  # fmt: skip
"""Modules that stages import when they are asked for."""


def warm_up() -> Iterator[None]:
    """Imports and reads what stages take long for when they first need it, a little at each step."""
    for name in HEAVY:
        import_module(name)
        yield
    for name in STAGES:
        import_module(f"{__name__}.{name}")
        yield
    from hexcite.page import values
    from hexcite.page.views import machine
    from hexcite.reports.page import space_page

    for each in built_in():
        values.sections(each.file.read_text(encoding="utf-8"), each.case)
        machine.drawn(each.case, {})
        yield
    space_page()
    for name in LATE:
        yield
        import_module(name)


QUIET = 8.0  # [s] after which an identification says what it may be busy with


def _patience(job: Job, words: Words) -> str:
    """What a command that says nothing itself may take long for."""
    return words.say("causes_tried") if job.command[0] == "identify" and job.seconds > QUIET else ""


def job(job: Job, language: Language) -> dict[str, Any]:
    """What a panel shows of a command."""
    last = job.progress[-1] if job.progress else None
    words, failed = Words(language), job.state == "failed"
    refused = words.error(job.refused) if failed else None
    drawn: Markup = drawing.curve(job.progress, job.seconds, text("best_curve", language)) if job.search else Markup("")
    ended = job.state in ("failed", "stopped", "killed")
    return {
        "name": text(kind, language) if (kind := f"job_{job.command[0]}") in TEXTS else job.command[0],
        "line": "" if job.over else words.progress(last) if last is not None else _patience(job, words),
        "curve": drawn,
        "messages": [each for each in job.messages[-8:] if each != UNTOUCHED] if ended else [],
        "refused": refused,
        "refusal": words.refusal(str(job.refused.get("code"))) if failed and refused is None else "",
        "warnings": job.messages[-8:] if job.state == "done" else [],
    }
