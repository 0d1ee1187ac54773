"""Carries out the methods of a validation: each planned, written as a proven program, executed and identified."""

import hashlib
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline

from cases.errors import FileProblem, HexciteError
from cases.files import PLAN, UNFINISHED, atomic_file, atomic_folder, check_folder, json_text, write_text
from cases.schema import Case
from cases.sensors import Disturbances
from identification.hexapod import Hexapod
from identification.trajectories.executed import DriveExecution
from planner.families.settings import Fourier, Manual, PointToPoint, Spline
from planner.interruption import Interrupted
from planner.library import planned
from planner.plan import Plan
from planner.poses.plan import poses_planned
from planner.poses.request import Method, PoseRequest
from planner.request import Request
from planner.runs.running import carried_out
from planner.runs.standing import stood
from planner.runs.writing import write
from planner.validation.experiment import METHODS, Excitation, steps
from planner.validation.remedy import Kept, keep, kept_step, remedy_of
from postprocessors.execute.executed_run import ExecutedRun
from postprocessors.files import Program
from postprocessors.proving.measured import measured_poses, measures_at_poses
from postprocessors.proving.stretches import stretches

# LinuxCNC has no limits for these, and no metal moves: the machine is simulated. Programs for the virtual controller
# are SINUMERIK's, whose point-to-point moves limit jerk as the paper's machine does, but for moves with steps.
ACCEPTED = ("acceleration", "jerk", "strut velocity", "strut acceleration", "sensor force")
REQUESTS: Mapping[str, Request | PoseRequest] = {
    "Q5M": PoseRequest(method=Method.ALL),
    "Q5N": PoseRequest(criterion="N", count=30, method=Method.BACKWARD),
    "D9M": Request(Manual()),
    "D9N": Request(Fourier(order=3, period=4.0), criterion="N"),
    "ptp": Request(PointToPoint(controller="virtual")),
    "ptp-steps": Request(PointToPoint(controller="linuxcnc")),
    "spline": Request(Spline()),
}

Count = Callable[[str, int], None]
"""Told of what is done now, and of how many steps that ends."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How methods are carried out.

    Args:
        on: controller: virtual or linuxcnc.
        starts: random starts of the optimised methods.
        seed: of the starts and of the sensors' noise.
        plans: folder of an earlier validation whose plans are taken; None: plan anew.
    """

    on: str = "virtual"
    starts: int = 2
    seed: int = 0
    plans: Path | None = None


USUAL = Settings()


@contextmanager
def unfinished(output: Path, case: Case, settings: Settings, overwrite: bool = False) -> Iterator[Path]:
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
    make_places(folder)
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


def make_places(folder: Path) -> None:
    """Makes the folders that `carry_out` fills."""
    for name in ("plans", "programs", "runs", "steps"):
        (folder / name).mkdir(parents=True, exist_ok=True)


def _worth_keeping(folder: Path) -> bool:
    return any(folder.glob("plans/*/plan.json"))


@dataclass(frozen=True, slots=True)
class CarriedOut:
    """What became of the methods.

    Args:
        steps: of those that could be carried out, with their remedies.
        failed: why the others could not.
    """

    steps: tuple[Kept, ...] = ()
    failed: Mapping[str, str] | None = None


def carry_out(
    case: Case,
    methods: Sequence[str],
    mounted: Sequence[int],
    disturbances: Disturbances | None,
    settings: Settings,
    folder: Path,
    count: Count,
) -> CarriedOut:
    """Plans, writes, executes and identifies methods; what a controller cannot run is told, and the others go on.

    Args:
        case: machine and weights.
        methods: their names.
        mounted: numbers of weights, from 0 on.
        disturbances: of the simulated machine.
        settings: how.
        folder: that takes plans, programs, runs and steps; what it holds already is not made again.
        count: told how it is getting on.

    Raises:
        HexciteError: no method could be carried out.
    """
    done, failed = [], {}
    for method in methods:
        try:
            count(f"{method}: planning", 0)
            plan = _planned(case, method, settings, folder)
            program = _program(method, settings, plan, folder)
            key = _key(program, settings, disturbances)
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
                count(f"{method} {found.step.load:.0f} kg", 1)
        done += [own[k] for k in mounted]
    if not done:
        raise HexciteError("; ".join(f"{method}: {why}" for method, why in failed.items()))
    return CarriedOut(tuple(done), failed)


def _program(method: str, settings: Settings, plan: Plan, folder: Path) -> Program:
    smooth = settings.on == "virtual" and method != "ptp-steps"
    dialect, suffix, accepted = ("sinumerik", "mpf", ()) if smooth else ("linuxcnc", "ngc", ACCEPTED)
    file = folder / "programs" / f"{method}.{suffix}"
    program = write(plan, dialect, accept=accepted, file=file)
    program.save(file, overwrite=True)
    return program


def _key(program: Program, settings: Settings, disturbances: Disturbances | None) -> str:
    """Fingerprint of a run, and of what its steps follow from beside the settings of the whole validation."""
    disturbed = "undisturbed" if disturbances is None else ""
    about = (program.case.controller_hash, settings.on, disturbed, version("hexcite"))
    return hashlib.sha256(program.content + repr(about).encode()).hexdigest()[:16]


def _identified(
    excitation: Excitation,
    missing: Sequence[int],
    disturbances: Disturbances | None,
    bare: Kept | None,
    key: str,
    folder: Path,
) -> Iterator[Kept]:
    """Steps that were not finished before, each kept as soon as it is."""
    for step in steps(excitation, missing, disturbances, None if bare is None else bare.step.estimate):
        remedy = None if disturbances is None else remedy_of(excitation, step, disturbances)
        found = Kept(key, excitation.controller, step, remedy)
        keep(folder, found)
        yield found


def _excitation(case: Case, method: str, settings: Settings, program: Program, key: str, folder: Path) -> Excitation:
    run = _executed(program, case, settings.on, key, folder / "runs" / f"{method}.npz")
    parts = stretches(program.reading)
    poses, duration = np.zeros((0, 6)), run.excitation
    if measures_at_poses(parts):
        poses = measured_poses(parts)
        duration = stood(run, poses, program.path).duration
    told = f"{run.controller}; {run.remark}" if run.remark else run.controller
    return Excitation(case, method, METHODS[method], duration, run.execution, run.trigger, poses, settings.seed, told)


def _executed(program: Program, case: Case, on: str, key: str, kept: Path) -> ExecutedRun:
    """The run of a program; it is kept, and found again."""
    run = _kept(key, case, on == "linuxcnc", kept)
    if run is None:
        _, run = carried_out(program, case, on)
        _keep(run, key, kept)
    return run


def _keep(run: ExecutedRun, key: str, kept: Path) -> None:
    spline = run.execution.spline
    with atomic_file(kept) as part, part.open("wb") as file:
        np.savez(
            file, knots=spline.t, coefficients=spline.c, trigger=run.trigger, controller=run.controller,
            remark=run.remark, key=key,
        )  # fmt: skip


def _kept(key: str, case: Case, real: bool, kept: Path) -> ExecutedRun | None:
    """A run that was kept; None where there is none of exactly this program on this controller."""
    if not kept.is_file():
        return None
    with np.load(kept) as found:
        if "key" not in found or str(found["key"]) != key:
            return None
        execution = DriveExecution(Hexapod.of(case), BSpline(found["knots"], found["coefficients"], 3))
        trigger, words = found["trigger"], [str(found[name]) for name in ("controller", "remark")]
    return ExecutedRun(words[0], execution, trigger, real=real, remark=words[1])


def _planned(case: Case, method: str, settings: Settings, folder: Path) -> Plan:
    """The plan of a method: an earlier one, or made now; one that Ctrl-C ended early is none."""
    place = folder / "plans" / method
    if (place / "plan.json").is_file():
        return Plan.load(place)
    if settings.plans is not None:
        _copied(settings.plans / "plans" / method, place)
        return Plan.load(place)
    request = REQUESTS[method]
    if isinstance(request, PoseRequest):
        plan = poses_planned(request, case)
    else:
        plan = planned(request.searched(settings.starts, settings.seed), case)
        if plan.interrupted:
            raise Interrupted
    plan.save(place)
    return Plan.load(place, case)


def _copied(source: Path, plan: Path) -> None:
    if not (source / "plan.json").is_file():
        raise FileProblem(f"{source}: holds no plan; name the folder of a validation that ran this method")
    with atomic_folder(plan, PLAN) as part:
        shutil.copytree(source, part, dirs_exist_ok=True)
