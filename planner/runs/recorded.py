"""What stands beside a recording: its case, the poses of a plan, and how a run stood at those of its program."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cases.basis import Artefact, recording_basis
from cases.errors import ExecutionError, HexciteError, RecordingError
from cases.files import another_kind
from cases.loading import CASE_FILE, built_in_cases, find_case, load_case
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.motion import Joined, Standstill, Trajectory
from identification.recording import record_of as about_recording
from identification.saved_result import load_result
from planner.plan_folder import load_plan
from postprocessors.execute import ExecutedRun
from postprocessors.proving.guarantees import Guarantees
from postprocessors.proving.homing import predicted
from postprocessors.proving.stretches import Stretch, Timed, Untimed

Array = NDArray[np.float64]


def case_of(
    path: Path, case: str | None, stale: bool = False, result: Path | None = None
) -> tuple[Case, tuple[str, ...]]:
    """The case that was named, or the one of a recording folder; and what has changed in it since, with `stale`.

    Args:
        case: named case, which is taken as it is now; None where the folder knows.
        result: folder of a result, whose case is taken where the recording names none.

    Raises:
        RecordingError: no recording, or nothing says which machine it is from.
        FileProblem: its case has changed, and `stale` is not set.
        CaseError: the case cannot be read.
    """
    recorded = any((path / f"recording.{suffix}").is_file() for suffix in ("json", "csv", "parquet"))
    if not recorded and (other := another_kind(path, "recording.json")):
        raise RecordingError(path, other, "here a recording is wanted, such as hexcite run writes")
    if case is not None:
        return load_case(case), ()
    about = about_recording(path)
    if not about:
        if result is not None:
            return load_result(result).artefact.case(), ()
        raise RecordingError(path, "does not say which machine it is from", "name it with --case")
    artefact = Artefact(path / "recording.json", about, "run the program again")
    loaded = artefact.case()
    return loaded, artefact.require_unchanged(recording_basis(loaded), loaded, stale)


def fitting_case(lengths: Array, case: Case, name: str | None) -> str | None:
    """A case whose machine has a pose with such strut lengths: built in, or in a folder beside this one's, or here.

    Args:
        lengths: lengths of a sample that no pose of the case has, shape (6,) [m].
        case: case that was tried.
        name: its name, if it has one.
    """
    own = None if name is None or name in built_in_cases() else find_case(name)
    places = [Path.cwd()] if own is None else [own.resolve().parent.parent, Path.cwd()]
    around = dict.fromkeys(file for place in places for file in sorted(place.glob(f"*/{CASE_FILE}")))
    for candidate in (*built_in_cases(), *map(str, around)):
        try:
            other = load_case(candidate)
            if other.machine == case.machine or other.machine is None or other.workspace is None:
                continue
            low, high = other.workspace.strut_length
            if np.all((lengths >= low) & (lengths <= high)):
                Hexapod.of(other).poses(lengths[None])
                return candidate
        except HexciteError:
            continue
    return None


def poses_of_plan(folder: Path, case: Case) -> Array:
    """Poses of a plan in the order of visit, shape (n, k) [m or rad].

    Raises:
        FileProblem: no plan there, or damaged.
        HexciteError: no plan of poses.
    """
    plan = load_plan(folder, case, stale=True)  # of a plan of poses only these are wanted
    if not len(plan.poses):
        raise HexciteError(f"{folder}: is a plan of family {plan.family}, not of poses; name one of hexcite poses")
    return plan.poses


STANDS = 1e-4  # [m or rad] that a drive may move while the trigger is on: it settles for some cycles


def way_of(parts: tuple[Stretch, ...], case: Case, guarantees: Guarantees) -> Trajectory:
    """The whole way of a program that measures standing still, from home on, as its controller is expected to go it."""
    home, limits = case.need_motion("a run")
    last_pose, way = home, list[Trajectory]()
    for part in parts:
        motion: Trajectory | None
        if isinstance(part, Timed):
            motion = part.points
        elif isinstance(part, Untimed):
            motion = predicted(part, limits, guarantees)
        else:
            motion = Standstill(last_pose, part.duration) if part.duration > 0.0 else None
        if motion is not None:
            way.append(motion)
            last_pose = motion.at([motion.duration]).pose[0]
    return Joined(tuple(way))


def stood(run: ExecutedRun, poses: NDArray[np.float64], program: Path) -> tuple[float, float]:
    """How long it took from home to home [s], and how far the machine stood from the program's poses, shape (n, k) [m].

    Raises:
        ExecutionError: the trigger did not come on once at each pose, or the machine moved while it was on.
    """
    if len(run.trigger) != len(poses):
        raise ExecutionError(
            program,
            f"the trigger came on {len(run.trigger)} times for {len(poses)} poses on {run.controller}",
            "report this",
        )
    for k, (start, end) in enumerate(run.trigger, 1):
        within = run.execution.struts(np.arange(start, end, 1e-3))
        if (way := float(np.ptp(within, axis=0).max())) > STANDS:
            raise ExecutionError(
                program,
                f"at pose {k} a drive moved by {way * 1e3:.3g} mm or mrad with the trigger on, on {run.controller}",
                "run again",
            )
    actual = run.execution.kinematics(run.trigger.mean(axis=1)).pose
    t = np.arange(0.0, run.execution.duration, 1e-3)
    moving = np.flatnonzero(np.abs(np.diff(run.execution.struts(t), axis=0)).max(axis=1) > 1e-9)
    off = float(np.linalg.norm(actual[:, :3] - run.execution.machine.positions(poses), axis=1).max())
    return float(t[moving[-1] + 1] - t[moving[0]]), off
