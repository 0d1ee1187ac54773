"""The fit of a model to a run: without damage and contact, with the delay, and with sizes that the case tolerates."""

from typing import NamedTuple

from cases.base.errors import Code, IdentificationError, RecordingError
from cases.base.phrases import phrase
from cases.schema import Case
from identification.estimation.estimators import Method
from identification.estimation.fit import require_alive
from identification.finding import Finding, Kind, note
from identification.findings.contact import Contact, free_of_contact, touched
from identification.findings.off_case import without
from identification.findings.told import Told, findings_of, told_by
from identification.model.blocks import INERTIA
from identification.model.model import Model, identification_model
from identification.recording.recording import Recording
from identification.samples.making import evaluated_samples
from identification.samples.sample_checks import CleanRun, scan
from identification.samples.samples import Fitted, fit_samples
from identification.samples.treatment import Treatment

ROUNDS_OF_SIZES = 6  # at most, until estimated sizes settle


class FittedRun(NamedTuple):
    """A fit, with what was seen on the way to it."""

    clean: CleanRun
    fitted: Fitted
    contacts: tuple[Contact, ...]


def fitted_run(
    recording: Recording, case: Case, model: Model, method: Method, treatment: Treatment | None = None
) -> FittedRun:
    """The fit of a model to a recording; errors as of `identify`."""
    if len(recording.forces) > 1:
        require_alive(recording.forces)
    moves = recording.t is not None and case.setup != "1a"
    if not moves and {p.name for p in INERTIA.parameters} & {*method.selection(model).names}:
        raise IdentificationError(
            place=recording.source,
            problem=phrase(
                "inertia_at_rest", "model {model} contains inertia, which standstills cannot excite", model=model.number
            ),
            remedy=phrase("model_to_5", "choose a model from 0 to 5, or record a motion"),
            code=Code.NO_EXCITATION,
        )
    clean = scan(recording, case)
    plain = Method(weights=method.weights_for(case.sensors))
    samples = evaluated_samples(clean, case, model, treatment)
    delay = None if samples.wide is None else fit_samples(samples.wide, plain, case.sensors).delay
    fitted, contacts = free_of_contact(clean.recording, fit_samples(samples, method, case.sensors, fixed_delay=delay))
    if contacts and samples.wide is not None:
        delay = fit_samples(samples.wide.without(touched(samples.wide.t, contacts)), plain, case.sensors).delay
        fitted = fit_samples(fitted.samples, method, case.sensors, fixed_delay=delay)
    return FittedRun(clean, refined(fitted), contacts)


def refined(fitted: Fitted) -> Fitted:
    """The fit with what else the samples show to be worth an estimate."""
    method = fitted.method
    if method.priors:
        return fitted
    rich = fitted.samples.refined(fitted.fit, method.selection(fitted.samples.model).basis, fitted.w, fitted.at)
    return fitted if rich is fitted.samples else fitted.again(rich)


class JointFit(NamedTuple):
    """A fit, and what the run tells of sizes that its case tolerates, where these were estimated beside it."""

    run: FittedRun
    case: Case  # with which it was evaluated
    told: Told | None
    findings: tuple[Finding, ...]


def fitted_with_sizes(
    recording: Recording, case: Case, method: Method, number: int, treatment: Treatment | None = None
) -> JointFit:
    """The fit of a model, by its number, with what the run tells of tolerated sizes; errors as of `identify`.

    By least squares alone where that is as good. Else the run is evaluated with the case of a machine that is off by
    the most probable sizes, until these settle.
    """
    plain = fitted_run(recording, case, identification_model(case, number), method, treatment)
    sizes = told_by(plain.fitted, case)
    if sizes is None or not sizes.worth(len(plain.fitted.samples.model.names)):
        return JointFit(plain, case, None, ())
    for _ in range(ROUNDS_OF_SIZES):
        try:
            run, edited = without(recording, case, sizes.by_key)
            joint = fitted_run(run, edited, identification_model(edited, number), method, treatment)
            sizes = told_by(joint.fitted, edited, sizes.sizes)
        except (IdentificationError, RecordingError):  # sizes that no machine has, found in a run that follows no model
            break
        if sizes is None:
            break
        if sizes.settled:
            findings = tuple(findings_of(sizes, case, joint.fitted))
            joint = joint._replace(fitted=sizes.allowed_for(joint.fitted))
            return JointFit(joint, edited, sizes, findings)
    sentence = "what the residuals show of the sizes in [tolerances] did not settle: they are not estimated beside"
    return JointFit(plain, case, None, (note(Kind.CASE, f"{sentence} the parameters"),))
