"""From a recording to a result: kinematics (7)-(9), regressor (17)-(22), an estimator, physical form.

Standstills are averaged where a run holds them. The delay between forces and motion of a moving run is estimated with
the parameters. What speaks against a run is looked for before the estimate (`sample_checks`) and in its residuals
(`contact`, `fit_checks`); then its cause is looked for (`causes`).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from cases.base.errors import Code, IdentificationError, RecordingError, option
from cases.base.options import default_of, documented
from cases.base.phrases import NOTHING, phrase
from cases.base.phrases import said as spoken
from cases.base.provenance import date_of
from cases.base.units import Array
from cases.basis import changes_since, recording_basis, result_basis
from cases.schema import Case
from identification.estimation.bounded import bounded
from identification.estimation.estimators import Method
from identification.finding import Finding, Kind, changed_cases, note, sentences, warning
from identification.findings.as_planned import as_planned
from identification.findings.causes.answer import Answer, answer
from identification.findings.causes.deviations import Evaluate
from identification.findings.clock import clock_findings, odd_clock
from identification.findings.contact import contact_findings
from identification.findings.drift import drift_findings, drift_of
from identification.findings.fit_checks import fit_findings
from identification.findings.known_body import (
    bounds_finding,
    left_open_with_bounds,
    shares_with_bounds,
    with_bounds,
)
from identification.findings.noise_level import doubtful, louder_than_stated, noise_of_channels, stated_noise
from identification.findings.plan_comparison import ANOTHER, Planned, closest
from identification.findings.structural_mode import mode_findings
from identification.findings.systematic import allowed_for, noisy_drives, not_shown, systematic_findings, systematic_of
from identification.findings.tolerances import budget_findings
from identification.fitting import fitted_run, fitted_with_sizes
from identification.model.blocks import RIGID
from identification.model.model import Model, full_model, identification_model
from identification.options import MODEL, PLAN, POSES, AverageStandstills
from identification.recording.formats.reading import files_of
from identification.recording.record import RunRecord
from identification.recording.recording import Recording
from identification.results.estimate import Estimate, entries_of, estimate_of
from identification.results.result import Result
from identification.samples.clocks import on_one_clock
from identification.samples.making import evaluated_samples
from identification.samples.moving_window import delimited, stands_only
from identification.samples.sample_checks import scan
from identification.samples.samples import GAUSS_MARKOV, Fitted, Samples
from identification.samples.standstills import among, average, find_standstills, match
from identification.samples.treatment import Treatment


@documented()
def identify(
    recording: Recording,
    case: Case | None = None,
    model: Annotated[int | None, MODEL] = None,
    *,
    how: Method | Callable[[Model], Method] = GAUSS_MARKOV,
    average_standstills: AverageStandstills = default_of(AverageStandstills),
    poses: Annotated[Array | None, POSES] = None,
    plan: Annotated[Planned | Sequence[Planned] | None, PLAN] = None,
    treatment: Treatment | None = None,
) -> Result:
    """Parameters with standard deviations from a recorded run.

    >>> result = hx.identify(hx.Recording.load("empty"))
    >>> mass = result["m"]
    >>> f"{mass.value:.2f} +- {mass.reported:.2f} {mass.unit}"
    '31.83 +- 0.01 kg'

    Args:
        recording: the run.
        case: case of the machine; the recording's own unless given.
        how: what is known beforehand, and how channels are weighted; or what gives it for a model.
        OPTIONS
        treatment: another treatment of a moving run; the result then holds what it changes beside the default.

    Raises:
        IdentificationError: the run does not determine the parameters; the message names them.
        RecordingError: the run cannot be evaluated.
        CaseError: the case lacks what the evaluation needs.
    """
    case = recording.machine_case(case)
    whole = on_one_clock(recording, case)
    comparison = None if plan is None else closest(whole, case, plan)
    differences = () if plan is None else as_planned(comparison, plan)
    try:
        evaluation = Asked(model, how, average_standstills, poses, treatment)
        result = _identified(recording, whole, case, evaluation, differences)
    except (IdentificationError, RecordingError) as error:
        raise error.beside((*_other_case(recording, case), *sentences(differences, "warning"))) from error
    if comparison is None or comparison.share < ANOTHER or result.estimate is None:
        return result
    return replace(result, estimate=replace(result.estimate, planned=(comparison.plan.motion, comparison.begins)))


class Asked(NamedTuple):
    """What is asked of a run; fields are arguments of `identify`."""

    model: int | None
    how: Method | Callable[[Model], Method]
    average_standstills: bool
    poses: Array | None
    treatment: Treatment | None

    def method(self, case: Case, number: int) -> Method:
        """The method for a model, by its number."""
        return self.how if isinstance(self.how, Method) else self.how(identification_model(case, number))


def _identified(
    recording: Recording, whole: Recording, case: Case, asked: Asked, differences: tuple[Finding, ...]
) -> Result:
    """`identify` of a recording that is on one clock, `whole`, with its differences from a plan."""
    try:
        run, standing = standing_of(whole, case, asked.poses, asked.average_standstills)
    except (IdentificationError, RecordingError) as error:
        if not error.doubtful:
            raise
        raise _explained(error, _cause_of_standstills(whole, case)).at(recording.source) from error
    number = default_model(run, case) if asked.model is None else asked.model
    method = asked.method(case, number)
    about = recording.record or RunRecord()
    estimate = estimate_parameters(run, case, number, method, asked.treatment)
    estimate = replace(estimate, findings=(*_changes_of_case(recording, case), *differences, *estimate.findings))
    files, treatment = files_of(run.paths), asked.treatment
    optional = {
        "treatment": None if treatment is None else _effect(run, case, estimate, method, treatment),
        "stale": recording.remarks or None,
        "run": None if run.record is None else run.record.origin,
        "standstills": standing,
        "recorded_at": date_of(files) if files else None,
        "channel_noise": _channel_noise(estimate, case),
    }
    record = entries_of(
        estimate,
        files,
        computed_from=result_basis(case),
        case_file=case.origin,
        plan_hash=about.origin.plan_hash,
        measuring_s=_measuring_time(about, run, estimate),
        **{key: entry for key, entry in optional.items() if entry is not None},
    )
    return Result(case, record, estimate).beside_physical()


def _other_case(recording: Recording, case: Case) -> tuple[str, ...]:
    """That it was recorded with another case, which may be why it cannot be evaluated."""
    about = recording.record or RunRecord()
    return () if about.case in (None, case.name) else (f"it was recorded with the case {about.case}, not {case.name}",)


def _changes_of_case(recording: Recording, case: Case) -> tuple[Finding, ...]:
    """What of the case has changed since the run, and what the case that it was recorded with states otherwise."""
    about = recording.record or RunRecord()
    changed = changed_cases(recording.remarks)
    changes = changes_since(about.to_json(), recording_basis(case), case.hash)
    if about.case in (None, case.name) or not changes:
        return changed
    more = phrase("more_of_them", " ({count} more)", count=len(changes) - 1) if len(changes) > 1 else NOTHING
    sentence = phrase(
        "recorded_with_another",
        "it was recorded with the case {before}, not {case}: {change}{more}; identify it with its own case",
        before=about.case,
        case=case.name,
        change=changes[0],
        more=more,
    )
    return (*changed, warning(Kind.CASE, sentence))


def _measuring_time(about: RunRecord, run: Recording, estimate: Estimate) -> float | None:
    """How long the run took [s]; None of standstills without a clock."""
    if about.executed is not None:
        return about.executed.executed_s
    if run.t is None:
        return None
    return estimate.samples.recorded_count * float(np.median(np.diff(run.t)))  # stamps of a host jitter


def _channel_noise(estimate: Estimate, case: Case) -> dict[str, Any]:
    """Noise of each channel, as entries of a result: measured, stated by the case, and rms of the residuals.

    Where it is above the stated one also what noise of the recorded drives makes of it.
    """
    noise_of_case = stated_noise(estimate.samples, estimate.fit, case)
    excess: dict[str, Any] = next(
        (f.quantity["noise_excess"] for f in estimate.findings if "noise_excess" in f.quantity), {}
    )
    by_drives = {"by_drives": excess["by_drives"]} if excess else {}
    return by_drives | {
        "measured": noise_of_channels(estimate.samples, estimate.fit).tolist(),
        "stated": None if noise_of_case is None else noise_of_case.tolist(),
        "evaluated": np.sqrt(np.mean(estimate.fit.residuals**2, axis=0)).tolist(),
    }


def default_model(recording: Recording, case: Case) -> int:
    """Number of a recording's largest model: 9 moving, 5 standing with struts, 6 and 0 of joints, 0 of orientations."""
    if recording.drives is None:
        return 0
    most = full_model(case)
    return most if recording.t is not None else 5 if most > RIGID else 0


def standing_of(
    recording: Recording, case: Case, poses: Array | None = None, asked: bool = False
) -> tuple[Recording, dict[str, Any] | None]:
    """The run's averaged standstills with entries about them, where it was recorded at poses; else the run.

    A run of hexcite knows the poses of its program.

    Args:
        poses: other poses whose standstills the run holds, shape (n, k) [m or rad]; a part of them is enough.
        asked: whether standstills are averaged where their poses are not known.

    Raises:
        RecordingError: no standstills, though there should be some; a pose was not measured, or one is none of them.
    """
    about = recording.record or RunRecord()
    expected = poses if poses is not None else about.poses(len(case.drive_columns))
    if recording.t is None:
        if poses is None and not asked:
            return recording, None
        if poses is not None and recording.drives is not None and (part := among(recording, case, poses)) is not None:
            return part, {"count": len(part.forces), "matched_to_poses": True, "found_by": "row"}
        raise RecordingError(
            place=recording.source,
            problem=phrase("averaged_already", "its rows are averaged already"),
            remedy=phrase(
                "leave_poses_out",
                "leave {poses} and {standstills} out",
                poses=option("poses"),
                standstills=option("average_standstills", "standstills"),
            ),
            code=Code.CONTRADICTION,
        )
    if expected is None and not asked and not stands_only(recording):
        return recording, None
    averages = average(recording, find_standstills(recording, _settling(case)))
    part = None if poses is None else among(averages, case, poses)
    if part is not None:
        averages = part
    elif expected is not None:
        averages, _ = match(averages, case, expected, recording.source)
    entries = {
        "count": len(averages.forces),
        "matched_to_poses": expected is not None,
        "found_by": "trigger" if delimited(recording.trigger) else "motion",
    }
    return averages, entries


def estimate_parameters(
    recording: Recording,
    case: Case,
    number: int | None = None,
    how: Method = GAUSS_MARKOV,
    treatment: Treatment | None = None,
) -> Estimate:
    """The estimate of a model's parameters from one recording, whose standstills are averaged already.

    Its matrices are small: a second thread of BLAS would only wait for the first, and wait long on a busy machine. BLAS
    therefore has one thread meanwhile; the caller's setting is restored at the end. Arguments and errors are those of
    `identify`.
    """
    model = identification_model(case, default_model(recording, case) if number is None else number)
    evaluate = fits(model.number, how)
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            try:
                estimate = _estimated(recording, case, model, how, treatment)
            except (IdentificationError, RecordingError) as error:
                if not error.doubtful:
                    raise
                raise _explained(error, answer(recording, case, model, evaluate)) from error
            if not doubtful(estimate.samples, estimate.fit, case, estimate.findings):
                return estimate
            cause = answer(recording, case, model, evaluate, estimate.fit)
            if cause is None:
                return estimate
            if cause.named:
                raise _named(cause)
        finding = warning(Kind.MODEL, cause.sentence) if cause.large else note(Kind.MODEL, cause.sentence)
        return replace(estimate, findings=(*estimate.findings, finding))
    except (IdentificationError, RecordingError) as error:
        raise error.at(recording.source).beside(sentences(recording.findings, "warning")) from error


def _effect(run: Recording, case: Case, estimate: Estimate, how: Method, treatment: Treatment) -> dict[str, Any]:
    """What a treatment changes beside the default: entries of `Result.record.treatment`."""
    with threadpool_limits(limits=1, user_api="blas"):
        plain = fitted_with_sizes(run, case, how, estimate.model.number).run.fitted
        usual = estimate_of(plain, run.source, case, ())
    both = {"default": usual, "treated": estimate}
    figures = {
        "s0": {key: e.s0 for key, e in both.items()},
        "white_noise": {key: e.fit.white_noise for key, e in both.items()},
        "samples": {key: e.samples.recorded_count for key, e in both.items()},
    }
    parameters = {
        name: {
            "default": value._asdict(),
            "treated": estimate.physical[name]._asdict(),
            "deviations": (estimate.physical[name].value - value.value) / value.reported if value.reported else 0.0,
        }
        for name, value in usual.physical.items()
    }
    return {**treatment.to_json(), **figures, "parameters": parameters}


def require_fit(recording: Recording, case: Case) -> None:
    """Raises IdentificationError or RecordingError where a run, on one clock, gets no estimate.

    Its causes are not looked for; what an estimate says of itself is not asked.
    """
    try:
        run, _ = standing_of(recording, case)
        with threadpool_limits(limits=1, user_api="blas"):
            fitted_run(run, case, identification_model(case, default_model(run, case)), GAUSS_MARKOV)
    except (IdentificationError, RecordingError) as error:
        raise error.at(recording.source) from error


def _settling(case: Case) -> float:
    """Time after a movement that is not averaged [s]."""
    return case.poses.settle_s if case.poses is not None else 0.5


def fits(number: int, how: Method) -> Evaluate:
    """What fits a model to a run with another case."""

    def evaluate(run: Recording, case: Case, robust: bool = True) -> Fitted:
        model = identification_model(case, number)
        return fitted_run(run, case, model, replace(how, robust=how.robust and robust)).fitted

    return evaluate


def _cause_of_standstills(recording: Recording, case: Case) -> Answer | None:
    """Why a run's standstills are not those of its poses, by their forces."""
    averages = average(recording, find_standstills(recording, _settling(case)))
    number = default_model(averages, case)
    with threadpool_limits(limits=1, user_api="blas"):
        return answer(averages, case, identification_model(case, number), fits(number, GAUSS_MARKOV))


def _named(said: Answer) -> IdentificationError:
    """The error that a cause is, with the keys that mend it."""
    error = IdentificationError(problem=said.sentence, code=Code.MISFIT)
    error.remedies = said.remedies
    return error


def _explained(
    error: IdentificationError | RecordingError, said: Answer | None
) -> IdentificationError | RecordingError:
    """The error with its cause, or with what was tried to find it."""
    if said is None:
        return error
    if said.named:
        return _named(said)
    kind = RecordingError if isinstance(error, RecordingError) else IdentificationError
    return kind(
        place=error.said.place,
        problem=phrase("explained", "{problem} ({tried})", problem=spoken(error.said.problem), tried=said.sentence),
        remedy=error.said.remedy,
        quantity=error.quantity,
        code=error.code,
    )


def samples_of(recording: Recording, case: Case, model: Model) -> Samples:
    """The samples of a recording from which `identify` estimates by default.

    Raises:
        IdentificationError: the model needs what the recording does not have.
        RecordingError: the run cannot be evaluated.
    """
    run, _ = standing_of(on_one_clock(recording, case), case)
    return evaluated_samples(scan(run, case), case, model)


def _estimated(
    recording: Recording, case: Case, model: Model, method: Method, treatment: Treatment | None = None
) -> Estimate:
    """The estimate with all that its residuals say; errors as of `identify`."""
    (clean, fitted, contacts), case_of_fit, sizes, told_of = fitted_with_sizes(
        recording, case, method, model.number, treatment
    )
    recording = clean.recording
    odd = odd_clock(recording, case) if fitted.samples.nuisances else None
    systematic = systematic_of(fitted, case_of_fit, odd, sizes)
    drift = drift_of(fitted) if systematic is None else systematic.drift
    findings = louder_than_stated(recording, case, fitted, None if systematic is None else systematic.motion)
    findings += systematic_findings(case, fitted, systematic)
    findings += noisy_drives(case, fitted, systematic)
    findings += mode_findings(fitted, None if systematic is None else systematic.ringing, case)
    findings += clock_findings(odd)
    findings += drift_findings(recording, case, fitted, drift)
    findings += [*clean.findings, *fitted.samples.findings(fitted.fit)]
    findings += contact_findings(recording, contacts)
    findings += fit_findings(recording, case, fitted)
    cautious, shares = allowed_for(fitted, systematic), None if systematic is None else systematic.tolerances
    findings += not_shown(cautious, systematic)
    if method.priors or _mounted(recording) > 0.0:  # of a payload's body, and beside priors of an own choice
        bounds = None
    else:
        fit = cautious.fit
        bounds = bounded(fitted.samples.model, fit.values, fit.covariance, fit.covariance_robust, case.bounds)
    if bounds is not None:
        fitted, cautious = with_bounds(fitted, bounds, False), with_bounds(cautious, bounds, True)
        shares = shares_with_bounds(shares, bounds)
        told_of = left_open_with_bounds(told_of, bounds)
        findings += [bounds_finding(bounds)]
    findings += told_of
    findings += budget_findings(fitted, cautious, shares, case)
    biases = {share.key: share.biases for share in shares or ()}
    return estimate_of(cautious, recording.source, case, tuple(findings), biases)


def _mounted(recording: Recording) -> float:
    """Mass of the payload that was mounted for a run of hexcite [kg]; 0 where the recording says nothing."""
    return 0.0 if recording.record is None else recording.record.origin.mounted
