"""Carries out the methods of a validation: each planned, written as a proven program, executed and identified."""

import hashlib
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from planner.cli.console import progress
from planner.interruption import Interrupted

if TYPE_CHECKING:
    from cases.disturbances import Disturbances
    from cases.schema import Case
    from planner.validation.experiment import Excitation
    from planner.validation.kept import Kept
    from postprocessors.execute.executed_run import ExecutedRun

# LinuxCNC has no limits for these, and no metal moves: the machine is simulated. Programs for the virtual controller
# are SINUMERIK's, whose point-to-point moves limit jerk as the paper's machine does, but for moves with steps.
ACCEPTED = ("acceleration", "jerk", "strut velocity", "strut acceleration", "sensor force")


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


@contextmanager
def unfinished(output: Path, case: "Case", settings: Settings, overwrite: bool = False) -> Iterator[Path]:
    """Yields the folder that keeps plans, programs, runs and steps until the validation is written, whatever ends it.

    What an earlier one left there is used where it belongs to the same case and settings.

    Args:
        output: folder of the validation; its neighbour of the same name with `.unfinished` is yielded.
        case: loaded.
        settings: how methods are carried out.
        overwrite: drop what belongs to another case or other settings.

    Raises:
        FileProblem: the folder is somebody's, or of another case or other settings.
    """
    from cases.errors import FileProblem
    from cases.files import UNFINISHED, check_folder, json_text, write_text

    folder = output.absolute().with_name(f"{output.name}.unfinished")
    check_folder(folder, UNFINISHED, overwrite=True)
    about = folder / "unfinished.json"
    plans = None if settings.plans is None else str(settings.plans.resolve())
    wanted = json_text({"case_hash": case.hash, "starts": settings.starts, "seed": settings.seed, "plans": plans})
    if folder.exists() and not (about.is_file() and about.read_text(encoding="utf-8") == wanted):
        if _worth_keeping(folder) and not overwrite:
            raise FileProblem(
                f"{folder}: an unfinished validation of another case or other settings stands there; choose another "
                "place with -o, or drop it with --overwrite"
            )
        shutil.rmtree(folder)
    for name in ("plans", "programs", "runs", "steps"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    write_text(about, wanted)
    try:
        yield folder
    except Interrupted:
        if _worth_keeping(folder):
            raise Interrupted(f"what is done is kept in {folder.name}, the same command goes on") from None
        raise
    else:
        shutil.rmtree(folder)
    finally:
        if folder.exists() and not _worth_keeping(folder):
            shutil.rmtree(folder)


def _worth_keeping(folder: Path) -> bool:
    return any(folder.glob("plans/*/plan.json"))


@dataclass(frozen=True, slots=True)
class CarriedOut:
    """What became of the methods.

    Args:
        steps: of those that could be carried out, with their remedies.
        failed: why the others could not.
    """

    steps: "list[Kept]"
    failed: dict[str, str]


def carry_out(
    name: str,
    case: "Case",
    methods: Sequence[str],
    mounted: Sequence[int],
    disturbances: "Disturbances | None",
    settings: Settings,
    folder: Path,
    quiet: bool,
) -> CarriedOut:
    """Plans, writes, executes and identifies methods; what a controller cannot run is told, and the others go on.

    Args:
        name: of the case, as the user gave it.
        case: loaded.
        methods: their names.
        mounted: numbers of weights, from 0 on.
        disturbances: of the simulated machine.
        settings: how.
        folder: that takes plans, programs, runs and steps; what it holds already is not made again.
        quiet: show no progress.

    Raises:
        HexciteError: no method could be carried out.
    """
    from cases.errors import HexciteError
    from planner.validation.kept import kept_step

    done, failed = [], {}
    with progress("validating", len(methods) * len(mounted), quiet) as count:
        for method in methods:
            try:
                count(f"{method}: planning", 0)
                program = _program(method, settings, _planned(name, method, settings, folder), folder)
                key = _key(program, case, settings, disturbances)
                own = {k: found for k in mounted if (found := kept_step(folder, method, k, key)) is not None}
                if len(own) < len(mounted):
                    count(f"{method}: on {settings.on}", 0)
                    excitation = _excitation(case, method, settings, program, key, folder)
            except HexciteError as error:
                failed[method] = str(error).replace(f"{folder}/", "")
                count(method, len(mounted))
                continue
            count(f"{method}: identifying", len(own))
            if missing := [k for k in mounted if k not in own]:
                for found in _identified(excitation, missing, disturbances, own.get(0), key, folder):
                    own[found.step.weights] = found
                    count(f"{method} {found.step.load:.0f} kg")
            done += [own[k] for k in mounted]
    if not done:
        raise HexciteError("; ".join(f"{method}: {why}" for method, why in failed.items()))
    return CarriedOut(done, failed)


def _program(method: str, settings: Settings, plan: Path, folder: Path) -> Path:
    from planner.cli.post import make_program

    smooth = settings.on == "virtual" and method != "ptp-steps"
    dialect, suffix, accepted = ("sinumerik", "mpf", ()) if smooth else ("linuxcnc", "ngc", ACCEPTED)
    program = folder / "programs" / f"{method}.{suffix}"
    make_program(plan, dialect, 1.0, accepted, program, quiet=True, overwrite=True)
    return program


def _key(program: Path, case: "Case", settings: Settings, disturbances: "Disturbances | None") -> str:
    """Fingerprint of a run, and of what its steps follow from beside the settings of the whole validation."""
    about = (case.controller_hash, settings.on, "undisturbed" if disturbances is None else "", version("hexcite"))
    return hashlib.sha256(program.read_bytes() + repr(about).encode()).hexdigest()[:16]


def _identified(
    excitation: "Excitation",
    missing: Sequence[int],
    disturbances: "Disturbances | None",
    bare: "Kept | None",
    key: str,
    folder: Path,
) -> "Iterator[Kept]":
    """Steps that were not finished before, each kept as soon as it is."""
    from planner.validation.experiment import steps
    from planner.validation.kept import Kept, keep
    from planner.validation.remedy import remedy_of

    for step in steps(excitation, missing, disturbances, None if bare is None else bare.step.estimate):
        remedy = None if disturbances is None else remedy_of(excitation, step, disturbances)
        found = Kept(key, excitation.controller, step, remedy)
        keep(folder, found)
        yield found


def _excitation(case: "Case", method: str, settings: Settings, program: Path, key: str, folder: Path) -> "Excitation":
    import numpy as np

    from planner.runs.standing import stood
    from planner.validation.experiment import METHODS, Excitation
    from postprocessors.files import read_program
    from postprocessors.proving.measured import measured_poses, measures_at_poses
    from postprocessors.proving.stretches import stretches

    run = _executed(program, case, settings.on, key, folder / "runs" / f"{method}.npz")
    parts = stretches(read_program(program, case).reading)
    poses, duration = np.zeros((0, 6)), run.excitation
    if measures_at_poses(parts):
        poses = measured_poses(parts)
        duration = stood(run, poses, program).duration
    told = f"{run.controller}; {run.remark}" if run.remark else run.controller
    return Excitation(case, method, METHODS[method], duration, run.execution, run.trigger, poses, settings.seed, told)


def _executed(program: Path, case: "Case", on: str, key: str, kept: Path) -> "ExecutedRun":
    """The run of a program; it is kept, and found again."""
    from planner.runs.running import carried_out

    run = _kept(key, case, on == "linuxcnc", kept)
    if run is None:
        _, _, run = carried_out(program, case, on)
        _keep(run, key, kept)
    return run


def _keep(run: "ExecutedRun", key: str, kept: Path) -> None:
    import numpy as np

    from cases.files import atomic_file

    spline = run.execution.spline
    with atomic_file(kept) as part, part.open("wb") as file:
        np.savez(
            file, knots=spline.t, coefficients=spline.c, trigger=run.trigger, controller=run.controller,
            remark=run.remark, key=key,
        )  # fmt: skip


def _kept(key: str, case: "Case", real: bool, kept: Path) -> "ExecutedRun | None":
    """A run that was kept; None where there is none of exactly this program on this controller."""
    import numpy as np
    from scipy.interpolate import BSpline

    from identification.hexapod import Hexapod
    from identification.trajectories.executed import StrutExecution
    from postprocessors.execute.executed_run import ExecutedRun

    if not kept.is_file():
        return None
    with np.load(kept) as found:
        if "key" not in found or str(found["key"]) != key:
            return None
        execution = StrutExecution(Hexapod.of(case), BSpline(found["knots"], found["coefficients"], 3))
        trigger, words = found["trigger"], [str(found[name]) for name in ("controller", "remark")]
    return ExecutedRun(words[0], execution, trigger, real=real, remark=words[1])


def _planned(name: str, method: str, settings: Settings, folder: Path) -> Path:
    """The plan of a method: an earlier one, or made now; one that Ctrl-C ended early is none."""
    from planner.cli.plan import make_plan
    from planner.cli.poses import make_poses
    from planner.poses.request import Method, PoseRequest
    from planner.request import Request

    plan = folder / "plans" / method
    starts, seed = settings.starts, settings.seed
    if (plan / "plan.json").is_file():
        pass
    elif settings.plans is not None:
        _copied(settings.plans / "plans" / method, plan)
    elif method == "Q5M":
        make_poses(PoseRequest(name, method=Method.ALL), plan, quiet=True)
    elif method == "Q5N":
        make_poses(PoseRequest(name, criterion="N", count=30, method=Method.BACKWARD), plan, quiet=True)
    else:
        requests = {
            "D9M": Request(name, family="manual"),
            "D9N": Request(name, family="fourier", criterion="N", order=3, period=4.0, starts=starts, seed=seed),
            "ptp": Request(name, controller="virtual", starts=starts, seed=seed),
            "ptp-steps": Request(name, controller="linuxcnc", starts=starts, seed=seed),
            "spline": Request(name, family="spline", starts=starts, seed=seed),
        }
        if make_plan(requests[method], plan, quiet=True)["interrupted"]:
            shutil.rmtree(plan)
            raise Interrupted
    return plan


def _copied(source: Path, plan: Path) -> None:
    from cases.errors import FileProblem
    from cases.files import PLAN, atomic_folder

    if not (source / "plan.json").is_file():
        raise FileProblem(f"{source}: holds no plan; name the folder of a validation that ran this method")
    with atomic_folder(plan, PLAN) as part:
        shutil.copytree(source, part, dirs_exist_ok=True)
