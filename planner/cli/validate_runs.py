"""Carries out the methods of a validation: each planned, written as a proven program, and executed on a controller."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planner.cli.console import progress

if TYPE_CHECKING:
    from cases.schema import Case
    from planner.validation import Excitation

# LinuxCNC has no limits for these, and no metal moves: the machine is simulated. Programs for the virtual controller
# are SINUMERIK's, whose point-to-point moves limit jerk as the paper's machine does.
ACCEPTED = ("acceleration", "jerk", "strut acceleration", "sensor force")


@dataclass(frozen=True, slots=True)
class Settings:
    """How methods are carried out.

    Args:
        on: controller: virtual or linuxcnc.
        starts: random starts of the optimised methods.
        seed: of the starts and of the sensors' noise.
        plans: folder of an earlier validation whose plans are taken; None: plan anew.
    """

    on: str
    starts: int
    seed: int
    plans: Path | None = None


def carry_out(
    name: str, case: "Case", methods: Sequence[str], settings: Settings, folder: Path, quiet: bool
) -> tuple[list["Excitation"], dict[str, str]]:
    """Plans, writes and executes methods; what a controller cannot run is told, and the others go on.

    Args:
        name: of the case, as the user gave it.
        case: loaded.
        methods: their names.
        settings: how.
        folder: that takes plans and programs.
        quiet: show no progress.

    Returns:
        Excitations, and reasons of the methods that did not come to one.

    Raises:
        HexciteError: no method could be carried out.
    """
    from cases.errors import HexciteError

    done, failed = [], {}
    with progress("carrying out", len(methods), quiet) as count:
        for method in methods:
            try:
                done.append(_excitation(name, case, method, settings, folder))
            except HexciteError as error:
                failed[method] = str(error).replace(f"{folder}/", "")
            count(method)
    if not done:
        raise HexciteError("; ".join(f"{method}: {why}" for method, why in failed.items()))
    return done, failed


def _excitation(name: str, case: "Case", method: str, settings: Settings, folder: Path) -> "Excitation":
    import numpy as np

    from planner.cli.post import make_program
    from planner.running import carried_out
    from planner.standing_run import stood
    from planner.validation import METHODS, Excitation
    from postprocessors.measured import measured_poses, measures_at_poses

    plan = folder / "plans" / method
    if settings.plans is None:
        _plan(name, method, settings, plan)
    else:
        _copied(settings.plans / "plans" / method, plan)
    on = settings.on
    dialect, suffix, accepted = ("linuxcnc", "ngc", ACCEPTED) if on == "linuxcnc" else ("sinumerik", "mpf", ())
    program = folder / "programs" / f"{method}.{suffix}"
    make_program(plan, dialect, 1.0, accepted, program, quiet=True)
    _, parts, run = carried_out(program, case, on)
    poses, duration = np.zeros((0, 6)), run.excitation
    if measures_at_poses(parts):
        poses = measured_poses(parts)
        duration = stood(run, poses, program).duration
    return Excitation(case, method, METHODS[method], duration, run.execution, run.trigger, poses, settings.seed)


def _plan(name: str, method: str, settings: Settings, plan: Path) -> None:
    from planner.cli.plan import make_plan
    from planner.cli.poses import make_poses
    from planner.poses.request import Method, PoseRequest
    from planner.request import Request

    starts, seed = settings.starts, settings.seed
    if method == "Q5M":
        make_poses(PoseRequest(name, method=Method.ALL), plan, quiet=True)
    elif method == "Q5N":
        make_poses(PoseRequest(name, criterion="N", count=30, method=Method.BACKWARD), plan, quiet=True)
    else:
        requests = {
            "D9M": Request(name, family="manual"),
            "D9N": Request(name, criterion="N", order=3, period=4.0, starts=starts, seed=seed),
            "ptp": Request(name, family="ptp", starts=starts, seed=seed),
            "spline": Request(name, family="spline", starts=starts, seed=seed),
        }
        make_plan(requests[method], plan, quiet=True)


def _copied(source: Path, plan: Path) -> None:
    from cases.errors import FileProblem

    if not (source / "plan.json").is_file():
        raise FileProblem(f"{source}: holds no plan; name the folder of a validation that ran this method")
    plan.parent.mkdir(exist_ok=True)
    shutil.copytree(source, plan)
