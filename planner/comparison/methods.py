"""The methods of a validation, carried out: planned, written as a proven program, executed and identified."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from cases.controller import ControllerName
from cases.errors import HexciteError, Interrupted
from cases.schema import Case, fingerprint
from cases.tables import Part
from identification.criteria import Criterion
from identification.limit import KINETIC
from planner.comparison import METHOD_TABLES
from planner.comparison.trials import Excitation
from planner.execution import carried_out
from planner.families.settings import family_class
from planner.library import planned
from planner.plan_program import write
from planner.plans import Plan
from planner.poses.planned_poses import poses_planned
from planner.request import PoseRequest, Request
from postprocessors.execute import stood


class MethodSpec(Part):
    """A method, as a table of `cases/hexapod/validation.toml` states it."""

    label: str
    family: str
    criterion: Criterion = Criterion.D
    settings: dict[str, Any] = Field(default_factory=dict)
    program: Literal[ControllerName.SINUMERIK, ControllerName.LINUXCNC] = ControllerName.SINUMERIK

    @property
    def request(self) -> Request | PoseRequest:
        """What is planned."""
        if self.family == PoseRequest.name:
            return PoseRequest(self.criterion, **self.settings)
        return Request(family_class(self.family)(**self.settings), criterion=self.criterion)


METHODS = {name: MethodSpec.model_validate(entries) for name, entries in METHOD_TABLES.items()}

Remark = Callable[[str], None]
"""Function that is called with the present step in words."""


@dataclass(frozen=True, slots=True)
class ValidationSettings:
    """How `hx.validate` carries out its methods."""

    on: str = ControllerName.VIRTUAL  # controller: virtual or linuxcnc
    starts: int = 2  # random starts of the optimised methods
    seed: int = 0  # seed of the starts and of the sensors' noise
    workers: int | None = None  # processes that search; None for one a core

    def __post_init__(self) -> None:
        Request(starts=self.starts, seed=self.seed, workers=self.workers)  # which says what these can be


USUAL = ValidationSettings()


def require_methods(names: Sequence[str]) -> None:
    """Raises HexciteError where a name is none of `METHODS` or given twice, or there is none."""
    for name in names:
        if name not in METHODS:
            raise HexciteError(f"method {name!r} is unknown; choose {', '.join(METHODS)}")
    if not names or len(set(names)) < len(names):
        raise HexciteError(f"methods {', '.join(names)!r}: name each once, of {', '.join(METHODS)}")


@contextmanager
def unfinished(output: Path, case: Case, settings: ValidationSettings) -> Iterator[Path]:
    """Yields the folder that holds the plans until the validation is written, also after an interruption.

    It stands beside `output`, and a fingerprint of case and settings in its name lets the same command find it again.
    """
    key = fingerprint([case.hash, settings.starts, settings.seed])[:8]
    folder = output.absolute().with_name(f"{output.name}.unfinished-{key}")
    try:
        yield folder
    except Interrupted:
        if folder.exists():
            raise Interrupted(f"finished plans are kept in {folder.name}, the same command uses them") from None
        raise
    shutil.rmtree(folder, ignore_errors=True)


def executed(case: Case, method: str, settings: ValidationSettings, folder: Path, remark: Remark) -> Excitation:
    """A method planned, written as a proven program and executed; a plan that `folder` holds is not made again."""
    remark(f"{method}: planning")
    plan = _planned(case, method, settings, folder)
    dialect = METHODS[method].program if settings.on == ControllerName.VIRTUAL else ControllerName.LINUXCNC
    suffix, accepted = ("ngc", KINETIC) if dialect == ControllerName.LINUXCNC else ("mpf", ())
    file = folder / "programs" / f"{method}.{suffix}"
    program = write(plan, dialect, accept=accepted, file=file)
    program.save(file, overwrite=True)
    remark(f"{method}: on {settings.on}")
    run = carried_out(program, program.case, settings.on)
    poses, duration = np.zeros((0, 6)), run.excitation
    if program.reading.measures_at_poses:
        poses = program.reading.measured_poses
        duration = stood(run, poses, program.path)[0]
    controller = f"{run.controller}; {run.remark}" if run.remark else run.controller
    return Excitation(program.case, method, duration, run.execution, run.trigger, poses, settings.seed, controller)


def _planned(case: Case, method: str, settings: ValidationSettings, folder: Path) -> Plan:
    """The plan of a method: an earlier one, or made now; one that Ctrl-C ended early is none."""
    place = folder / "plans" / method
    if (place / "plan.json").is_file():
        return Plan.load(place, case)
    request = METHODS[method].request
    if isinstance(request, PoseRequest):
        plan = poses_planned(request, case)
    else:
        if request.family.optimised:
            request = replace(request, starts=settings.starts, seed=settings.seed, workers=settings.workers)
        plan = planned(request, case)
        if plan.interrupted:
            raise Interrupted
    plan.save(place)
    return Plan.load(place, case)
