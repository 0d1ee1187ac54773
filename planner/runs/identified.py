"""From a recording to a result: standstills averaged where a run holds them, parameters, what speaks against them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.basis import KEPT, result_basis
from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimation.estimators import Method
from identification.hexapod import StrutsDoNotClose
from identification.identify import default_model, identifiability
from identification.identify import identify as estimate_parameters
from identification.long.blocks import fits_blocks
from identification.long.streaming import identify_long, in_blocks, is_long
from identification.model import Model, identification_model
from identification.outcome import TOLD_OF_RUNS, Result
from identification.provenance import provenance
from identification.recording import Recording, files_of, read, record_of
from identification.result import Estimate
from identification.runs.conditioning import USUAL, Conditioning
from identification.runs.moving import GAUSS_MARKOV
from identification.runs.rates import on_one_clock
from identification.runs.residuals import residuals_of
from planner.plan import Plan
from planner.runs.followed import Followed
from planner.runs.recorded import UNSAID, Still, fitting_case, knows_poses, standing_of, with_feed

NOT_COMPARED = (
    "the run is too long to be compared with its program at once: a feed other than 100 % is told where the recording "
    "has the override; --plan compares a run that fits into memory"
)


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked of an identification.

    Args:
        model: number in Table 2; None for what the run can carry.
        how: estimator, and what is known beforehand, for a model.
        terms: forms of the error compensation instead of the model's: K1 to K5.
        conditioning: what is done to a moving run beforehand.
        still: what is known of standstills in a run with a clock.
        followed: the motion that the run was to follow, where its feed is to be compared.
    """

    model: int | None = None
    how: Callable[[Model], Method] = lambda model: GAUSS_MARKOV
    terms: tuple[str, ...] = ()
    conditioning: Conditioning = USUAL
    still: Still = UNSAID
    followed: Followed | None = None


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
        case: of the machine; the recording's own unless given.
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
        raise RecordingError(f"{recording.source}: does not say which machine it is from; give its case")
    still = UNSAID if poses is None else Still(poses.poses)
    return identified(recording, case, Wish(model, lambda _: how, tuple(terms), conditioning, still))


def identified(recording: Recording, case: Case, wish: Wish, stale: tuple[str, ...] = ()) -> Result:
    """`identify` for what is asked as one value.

    Args:
        recording: the run.
        case: of the machine.
        wish: what is asked.
        stale: what has changed in the case since the run.
    """
    whole = replace(on_one_clock(recording, case), case=case, paths=recording.paths, record=recording.record)
    run, standing = standing_of(whole, case, wish.still)
    number = default_model(run) if wish.model is None else wish.model
    how = wish.how(identification_model(case, number, wish.terms))
    try:
        estimate = estimate_parameters(run, case, number, how, wish.terms, wish.conditioning)
    except StrutsDoNotClose as error:
        if other := fitting_case(error.lengths, case, case.origin or None):
            raise IdentificationError(f"{error}; they fit the case {other}, name it with --case") from error
        raise
    estimate = with_feed(estimate, run, case, wish.followed)
    return result_of(run, case, estimate, standing, stale)


def result_of(
    run: Recording, case: Case, estimate: Estimate, standing: dict[str, Any] | None, stale: tuple[str, ...]
) -> Result:
    """The result of an estimate.

    Args:
        run: as it was identified.
        case: of the machine.
        estimate: of its parameters.
        standing: what is to be said of averaged standstills.
        stale: what has changed in the case since the run.
    """
    if estimate.how.biases is not None:
        stale = (*stale, *estimate.how.biases.stale)
    estimate = replace(estimate, warnings=(*estimate.warnings, *stale))
    record = {
        **estimate.to_json(),
        KEPT: result_basis(case),
        **({"stale": list(stale)} if stale else {}),
        **provenance(files_of(run.paths)),
        **_about_run(run, case, estimate),
        **({"run": {k: run.record[k] for k in ("simulated", *TOLD_OF_RUNS) if k in run.record}} if run.record else {}),
        **({} if standing is None else {"standstills": standing}),
    }
    found = identifiability(run, case, estimate)
    return Result(case, record, found, estimate, residuals_of(run, case, estimate))


def _about_run(run: Recording, case: Case, estimate: Estimate) -> dict[str, Any]:
    """What a result says of its run: the file of the case, the plan that it followed, the time that it took."""
    taken = run.record.get("executed_s")
    if taken is None and run.t is not None:
        taken = estimate.samples * float(np.median(np.diff(run.t)))  # stamps of a host jitter
    return {"case_file": case.origin, "plan_hash": run.record.get("plan_hash"), "measuring_s": taken}


def identified_file(paths: Sequence[Path], case: Case, wish: Wish, stale: tuple[str, ...] = ()) -> Result:
    """`identified` for the files of one run; one that is too long to be read at once is read in blocks."""
    record = record_of(paths[0])
    blocks = len(paths) == 1 and wish.followed is None and not knows_poses(record, wish.still) and is_long(paths[0])
    if not blocks:
        return identified(read(paths, case), case, wish, stale)
    how = wish.how(identification_model(case, 9 if wish.model is None else wish.model, wish.terms))
    if not (in_blocks(how, wish.conditioning) and fits_blocks(paths[0], case)):
        return identified(read(paths, case), case, wish, stale)
    estimate, head = identify_long(paths[0], case, wish.model, how, wish.terms)
    if record.get("plan_hash") is not None:
        estimate = replace(estimate, notes=(*estimate.notes, NOT_COMPARED))
    return result_of(replace(head, case=case, paths=tuple(paths), record=record), case, estimate, None, stale)
