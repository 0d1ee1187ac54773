"""From a recording to a result: its case, standstills averaged where a run holds them, parameters, and what is odd."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.basis import KEPT, Artefact, recording_basis, result_basis
from cases.errors import FileProblem, HexciteError, IdentificationError, RecordingError
from cases.files import another_kind, provenance
from cases.loading import CASE_FILE, built_in_cases, find_case, load_case
from cases.schema import Case
from identification.estimation.estimators import Method
from identification.findings import Finding, Kind, warning
from identification.fitting import GAUSS_MARKOV
from identification.formats.reading import files_of
from identification.hexapod import Hexapod, StrutsDoNotClose
from identification.identify import default_model, identifiability
from identification.identify import identify as estimate_parameters
from identification.model import Model, identification_model
from identification.motion import Array
from identification.outcome import TOLD_OF_RUNS, Result, case_of_result
from identification.recording import Recording
from identification.recording import record_of as about_recording
from identification.result import residuals_of
from identification.runs.preparation import delimited, stands_only
from identification.runs.rates import on_one_clock
from identification.runs.standstills import average, find_standstills, match
from identification.samples import USUAL, Conditioning
from planner.plan_folder import load_plan
from planner.plans import Plan

SHORTER, SHORTER_BY = 0.02, 0.1  # of a plan, and [s], by which a run may be shorter
RESTLESS = 3.0  # times the usual scatter of an averaged force


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked of an identification."""

    model: int | None = None  # number in Table 2; None for what the run can carry
    how: Callable[[Model], Method] = lambda model: GAUSS_MARKOV  # estimator, and what is known beforehand, for a model
    terms: tuple[str, ...] = ()  # forms of the error compensation instead of the model's: K1 to K5
    conditioning: Conditioning = USUAL
    poses: Array | None = None  # poses whose standstills a run with a clock holds, shape (n, k) [m or rad]
    standstills: bool = False  # average standstills without knowing the poses


def identify(
    recording: Recording,
    case: Case | None = None,
    model: int | None = None,
    *,
    how: Method = GAUSS_MARKOV,
    terms: Sequence[str] = (),
    conditioning: Conditioning = USUAL,
    poses: Plan | None = None,
) -> Result:
    """Parameters with standard deviations from a recorded run.

    Args:
        recording: the run.
        case: case of the machine; the recording's own unless given.
        model: number in Table 2; by default what the run can carry.
        how: estimator, and what is known beforehand.
        terms: forms of the error compensation instead of the model's: K1 to K5.
        conditioning: what is done to a moving run beforehand.
        poses: plan of poses whose standstills the run holds; a run of hexcite knows its own.

    Raises:
        IdentificationError: the run does not determine the parameters; the message names them.
        RecordingError: the run cannot be evaluated.
        CaseError: the case lacks what the evaluation needs.
    """
    if case is None:
        case = recording.case
    if case is None:
        raise RecordingError(recording.source, "does not say which machine it is from", "give its case")
    stood = None if poses is None else poses.poses
    return identified(recording, case, Wish(model, lambda _: how, tuple(terms), conditioning, stood))


def identified(recording: Recording, case: Case, wish: Wish, stale: tuple[str, ...] = ()) -> Result:
    """`identify` for what is asked as one value."""
    whole = on_one_clock(recording, case)
    run, standing = standing_of(whole, case, wish.poses, wish.standstills)
    number = default_model(run, case) if wish.model is None else wish.model
    method = wish.how(identification_model(case, number, wish.terms))
    try:
        estimate = estimate_parameters(run, case, number, method, wish.terms, wish.conditioning)
    except (IdentificationError, RecordingError) as error:
        own = recording.record.get("case")
        if own not in (None, case.name):
            raise IdentificationError(f"{error.typed}; it was recorded with the case {own}, not {case.name}") from error
        if isinstance(error, StrutsDoNotClose) and (other := fitting_case(error.lengths, case, case.origin or None)):
            raise IdentificationError(f"{error.typed}; they fit the case {other}, name it with --case") from error
        raise
    estimate = replace(estimate, findings=(*estimate.findings, *shorter_than_planned(whole)))
    stale += () if method.biases is None else method.biases.stale
    seconds = run.record.get("executed_s")  # the time that it took
    if seconds is None and run.t is not None:
        seconds = estimate.evaluated.samples * float(np.median(np.diff(run.t)))  # stamps of a host jitter
    changed = tuple(warning(Kind.CASE, sentence) for sentence in stale)
    estimate = replace(estimate, findings=(*estimate.findings, *changed))
    record = {
        **estimate.to_json(),
        KEPT: result_basis(case),
        **({"stale": list(stale)} if stale else {}),
        **provenance(files_of(run.paths)),
        "case_file": case.origin,
        "plan_hash": run.record.get("plan_hash"),
        "measuring_s": seconds,
        **({"run": {k: run.record[k] for k in ("simulated", *TOLD_OF_RUNS) if k in run.record}} if run.record else {}),
        **({} if standing is None else {"standstills": standing}),
    }
    return Result(case, record, identifiability(estimate), estimate, residuals_of(estimate))


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
            return case_of_result(result), ()
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


def standing_of(
    recording: Recording, case: Case, poses: Array | None = None, asked: bool = False
) -> tuple[Recording, dict[str, Any] | None]:
    """The run's averaged standstills with what is to be told of them, where it was recorded at poses; else the run.

    A run of hexcite knows the poses of its program.

    Args:
        poses: other poses whose standstills the run holds, shape (n, k) [m or rad].
        asked: average standstills without knowing the poses.

    Raises:
        StandstillMismatch: a pose was not measured, or a standstill is none of the poses.
        RecordingError: no standstills, though there should be some.
    """
    expected = poses if poses is not None else poses_of_record(recording.record, len(case.drive_columns))
    if recording.t is None:
        if poses is None and not asked:
            return recording, None
        raise RecordingError(recording.source, "its rows are averaged already", "leave --poses and --standstills out")
    if expected is None and not asked and not stands_only(recording):
        return recording, None
    settle = case.poses.settle_s if case.poses is not None else 0.5
    averages = average(recording, find_standstills(recording, settle))
    if expected is not None:
        averages, _ = match(averages, case, expected, recording.source)
    assert averages.weights is not None
    entries = {
        "count": len(averages.forces),
        "matched_to_poses": expected is not None,
        "found_by": "trigger" if delimited(recording.trigger) else "motion",
        "restless": [k for k, weight in enumerate(averages.weights, 1) if weight * RESTLESS < 1.0],
    }
    return averages, entries


def poses_of_record(record: Mapping[str, Any], coordinates: int) -> Array | None:
    """Poses that a program measured, shape (n, coordinates); None where it measured a motion, or unknown.

    Raises:
        FileProblem: the entry is damaged.
    """
    entry = record.get("poses_m_rad")
    if not entry:
        return None
    try:
        poses = np.array(entry, dtype=float)
    except (TypeError, ValueError) as error:
        raise FileProblem(f"recording.json: poses_m_rad: {error}; run the program again") from error
    if poses.ndim != 2 or poses.shape[1] != coordinates or not np.isfinite(poses).all():
        raise FileProblem(f"recording.json: poses_m_rad: are not poses of {coordinates} numbers; run the program again")
    return poses


def shorter_than_planned(recording: Recording) -> tuple[Finding, ...]:
    """A trigger that was on for less than the program lasts, at the feed that was recorded, of a run of hexcite."""
    planned = recording.record.get("planned_s")
    if recording.record.get("poses_m_rad"):  # there it is on in the dwells only
        return ()
    if planned is None or recording.t is None or recording.trigger is None or recording.trigger.all():
        return ()
    feed = 1.0 if recording.override is None else recording.override[recording.trigger]
    duration = float(np.sum(np.ones(int(recording.trigger.sum())) * feed) * recording.step)
    if duration >= planned - max(SHORTER_BY, SHORTER * planned):
        return ()
    sentence = (
        f"the trigger is on for {duration:.3g} s, the program lasts {planned:.3g} s: the run or its recording was cut "
    )
    return (warning(Kind.WINDOW, f"{sentence}off; what the plan promises is not of this run"),)
