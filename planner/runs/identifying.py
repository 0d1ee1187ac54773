"""From a recording to a result: standstills averaged where a run holds them, parameters, what speaks against them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.basis import KEPT, result_basis
from cases.errors import IdentificationError, RecordingError
from cases.files import provenance
from cases.schema import Case
from identification.estimation.estimators import Method
from identification.finding import Kind, warning
from identification.fitting import GAUSS_MARKOV
from identification.hexapod import StrutsDoNotClose
from identification.identify import default_model, identifiability
from identification.identify import identify as estimate_parameters
from identification.model import Model, identification_model
from identification.outcome import TOLD_OF_RUNS, Result, residuals_of
from identification.recording import Recording, files_of, read
from identification.result import Estimate
from identification.runs.rates import on_one_clock
from identification.samples import USUAL, Conditioning
from planner.plans import Plan
from planner.runs.recorded import UNSAID, StandstillWish, fitting_case, shorter_than_planned, standing_of


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked of an identification."""

    model: int | None = None  # number in Table 2; None for what the run can carry
    how: Callable[[Model], Method] = lambda model: GAUSS_MARKOV  # estimator, and what is known beforehand, for a model
    terms: tuple[str, ...] = ()  # forms of the error compensation instead of the model's: K1 to K5
    conditioning: Conditioning = USUAL
    still: StandstillWish = UNSAID  # what is known of standstills in a run with a clock


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
    still = UNSAID if poses is None else StandstillWish(poses.poses)
    return identified(recording, case, Wish(model, lambda _: how, tuple(terms), conditioning, still))


def identified(recording: Recording, case: Case, wish: Wish, stale: tuple[str, ...] = ()) -> Result:
    """`identify` for what is asked as one value."""
    whole = on_one_clock(recording, case)
    run, standing = standing_of(whole, case, wish.still)
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
    return result_of(run, case, estimate, standing, (*stale, *(() if method.biases is None else method.biases.stale)))


def result_of(
    run: Recording, case: Case, estimate: Estimate, standing: dict[str, Any] | None, stale: tuple[str, ...]
) -> Result:
    """The result of an estimate."""
    changed = tuple(warning(Kind.CASE, sentence) for sentence in stale)
    estimate = replace(estimate, findings=(*estimate.findings, *changed))
    record = {
        **estimate.to_json(),
        KEPT: result_basis(case),
        **({"stale": list(stale)} if stale else {}),
        **provenance(files_of(run.paths)),
        **_about_run(run, case, estimate),
        **({"run": {k: run.record[k] for k in ("simulated", *TOLD_OF_RUNS) if k in run.record}} if run.record else {}),
        **({} if standing is None else {"standstills": standing}),
    }
    analysis = identifiability(estimate)
    return Result(case, record, analysis, estimate, residuals_of(estimate))


def _about_run(run: Recording, case: Case, estimate: Estimate) -> dict[str, Any]:
    """What a result says of its run: the file of the case, the plan that it followed, the time that it took."""
    seconds = run.record.get("executed_s")
    if seconds is None and run.t is not None:
        seconds = estimate.evaluation.evaluated.samples * float(np.median(np.diff(run.t)))  # stamps of a host jitter
    return {"case_file": case.origin, "plan_hash": run.record.get("plan_hash"), "measuring_s": seconds}


def identified_file(paths: Sequence[Path], case: Case, wish: Wish, stale: tuple[str, ...] = ()) -> Result:
    """`identified` for the files of one run."""
    return identified(read(paths, case), case, wish, stale)
