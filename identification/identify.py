"""From a recording to parameters: kinematics (7)-(9), regressor (17)-(22), an estimator, physical form.

The delay between forces and motion of a moving run is estimated together with the parameters. What speaks against a
run is looked for before the estimate (`sample_checks`) and in what the estimate leaves (`wiring`, `contact`).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from cases.errors import IdentificationError, NegativeMass, RecordingError
from cases.schema import Case
from identification.criteria import Identifiability, analyse
from identification.estimation.biases import Biases, accelerometer_bias, drift_told, mass_told
from identification.estimation.compressed import require_alive
from identification.estimation.estimators import FitProblem, Method
from identification.estimation.fit import Uncertain
from identification.estimation.noise_sources import NoiseSources, noise_sources
from identification.findings import Finding, Kind, note, warning
from identification.findings.contact import contacts_told, free_of_contact, touched
from identification.findings.fit_checks import fit_findings, leaves_much
from identification.findings.sample_checks import Scan, scan
from identification.findings.wiring import require_wiring
from identification.fitting import GAUSS_MARKOV, SANDWICHED, Fitted, excerpt, fit_samples
from identification.model import Model, full_model, identification_model
from identification.parameters import MASS, RIGID
from identification.recording import Recording
from identification.result import Estimate, estimate_of
from identification.runs.averaging import PeriodicRun, periodic_run
from identification.runs.evaluation import CLEAR, MOST_DELAY, Run, smoothed, smoothing_of, smoothing_told
from identification.runs.preparation import moving_run, standstills
from identification.runs.wrist import WristRun, delay_band, wrist_run
from identification.samples import USUAL, Conditioning, Samples

Array = NDArray[np.float64]


def default_model(recording: Recording, case: Case) -> int:
    """The model that a recording can carry: 9 moving, 5 standing with struts, 6 and 0 of joints, 0 of orientations."""
    if recording.struts is None:
        return 0
    most = full_model(case)
    return most if recording.t is not None else 5 if most > RIGID else 0


def identify(
    recording: Recording,
    case: Case,
    number: int | None = None,
    how: Method = GAUSS_MARKOV,
    terms: Sequence[str] = (),
    conditioning: Conditioning = USUAL,
) -> Estimate:
    """Identifies the parameters of a model from one recording.

    Its matrices are small: a second thread of BLAS would only wait for the first, and wait long on a busy machine. BLAS
    therefore has one thread meanwhile; the caller's setting is restored at the end.

    Args:
        recording: the run.
        case: machine, sensor frame and gravity.
        number: number of the model in Table 2; by default what the recording can carry.
        how: estimator, and what is known beforehand.
        terms: other forms of the error compensation than the model's: K1 to K5.
        conditioning: what is done to a moving run beforehand.

    Raises:
        IdentificationError: the run does not determine the parameters; the message names them.
        RecordingError: the run cannot be evaluated.
        CaseError: the case lacks what the evaluation needs.
    """
    model = identification_model(case, default_model(recording, case) if number is None else number, terms)
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            try:
                estimate = _estimated(recording, case, model, how, conditioning)
            except (IdentificationError, RecordingError) as error:
                require_wiring(recording, case, model, negative=isinstance(error, NegativeMass))
                raise
            if estimate.warnings or leaves_much(estimate.fit, estimate.evaluated.forces, case):
                require_wiring(recording, case, model)
        return estimate
    except (IdentificationError, RecordingError) as error:
        raise error.at(recording.source) from error


def _estimated(recording: Recording, case: Case, model: Model, method: Method, conditioning: Conditioning) -> Estimate:
    if len(recording.forces) > 1:
        require_alive(recording.forces)
    moves = recording.t is not None and case.setup != "1a"
    if not moves and conditioning != USUAL:
        raise RecordingError("is not a moving run; --period and --flexible are for moving runs")
    if not moves and model.needs_motion and not set(method.known) >= _inertia(model) | set(method.dropped):
        raise IdentificationError(
            f"{recording.source}: model {model.number} contains inertia, which standstills cannot excite; choose a "
            "model from 0 to 5, or record a motion"
        )
    estimate = _evaluated(recording, case, model, method, conditioning)
    softer = _below(case, estimate.told.get("structural_mode_Hz")) if conditioning.flexible else None
    if softer is not None:
        return replace(_evaluated(recording, softer, model, method, conditioning), case=case)
    return estimate


def _samples(
    recording: Recording, case: Case, model: Model, conditioning: Conditioning, found: Scan, biases: Biases | None
) -> Samples:
    """A recording ready to be evaluated, as it was asked for; `biases` are those of a wrist run, known beforehand."""
    if recording.t is None or case.setup == "1a":
        return standstills(recording, case, model, found)
    if conditioning.periodic:
        return periodic_run(recording, case, model, conditioning, found)
    if recording.struts is None:
        return wrist_run(recording, case, model, MOST_DELAY, biases, bad=found.bad)
    return replace(moving_run(recording, case, model, found=found), smoothing=conditioning.flexible)


def _evaluated(recording: Recording, case: Case, model: Model, method: Method, conditioning: Conditioning) -> Estimate:
    scanned = scan(recording, case)
    problem = FitProblem.of(model, case, method)
    samples = _samples(recording, case, model, conditioning, scanned, method.biases)
    if conditioning.flexible and (method.priors or not isinstance(samples, Run)):
        raise RecordingError("--flexible sees a mode in struts behind the low-pass, without --prior; leave it out")
    findings = [*scanned.findings]
    delay, wide = None, None
    if isinstance(samples, WristRun):
        band = delay_band(recording)
        wide = wrist_run(recording, case, model, MOST_DELAY, cutoff=band, bad=scanned.bad)
        delay = fit_samples(wide, GAUSS_MARKOV, problem).delay
        sentence = (
            f"delay estimated in the band up to {band:.3g} Hz, the widest that all streams carry; parameters up to "
        )
        sentence += f"{samples.filter.cutoff:g} Hz at that delay, its uncertainty propagated"
        findings.append(note(Kind.CLOCK, sentence))
    fitted = fit_samples(samples, method, problem, held=delay)
    fitted, contacts = free_of_contact(recording, fitted, method, problem, delay)
    if contacts and wide is not None:
        delay = fit_samples(wide.without(touched(wide.t, contacts)), GAUSS_MARKOV, problem).delay
        fitted = fit_samples(fitted.samples, method, problem, held=delay)
    if isinstance(fitted.samples, Run) and not method.priors and not conditioning.flexible:
        rich = smoothed(fitted.samples, fitted.fit, method.selection(model).basis, fitted.w, fitted.at)
        if rich.smoothing:
            fitted = fit_samples(rich, method, problem, fitted.at)
    if isinstance(fitted.samples, Run) and fitted.samples.smoothing:
        smoothing = smoothing_of(fitted.samples, fitted.fit)
        findings += _mode_found(smoothing, case) if conditioning.flexible else [smoothing_told(smoothing)]
    findings += [warning(Kind.CONTACT, f"{text}; left out") for text in contacts_told(recording, contacts)]
    noise = stated_noise(case, fitted, method)
    findings += [] if noise is None else noise.findings
    if method.biases is not None:
        free = fit_samples(fitted.samples, method.without_biases, problem, fitted.at, delay)
        findings += drift_told(method.biases, model, free.fit)
        if fitted.samples.nuisances and MASS in model.blocks:
            exactly = replace(method, biases=method.biases.exact)
            findings.append(
                mass_told(model, fitted.fit, fit_samples(fitted.samples, exactly, problem, fitted.at, delay).fit)
            )
    findings += fit_findings(recording, case, method, fitted)
    bias = None
    if not samples.nuisances and recording.specific_forces is not None and recording.rotations is not None:
        good = ~scanned.bad
        bias = accelerometer_bias(recording.specific_forces[good], recording.rotations[good], case.gravity)
    return estimate_of(fitted, recording.source, case, method, noise, bias, tuple(findings))


def stated_noise(case: Case, fitted: Fitted, how: Method) -> NoiseSources | None:
    """What s0 of a run with struts consists of, where the case states noise and least squares were asked for."""
    samples = fitted.samples
    if not case.sensors.state_noise or how.name not in SANDWICHED or how.priors:
        return None
    if not isinstance(samples, Run | PeriodicRun):
        return None
    return noise_sources(samples, fitted.fit, fitted.w, fitted.at, case.sensors)


def identifiability(estimate: Estimate) -> Identifiability:
    """What the run determines, alone and together, of the parameters that were estimated (section 5)."""
    samples = excerpt(estimate.evaluated)
    selection = estimate.how.selection(samples.model)
    matrices = samples.regressors(estimate.at)
    return analyse(matrices @ selection.basis, selection.names)


def _inertia(model: Model) -> set[str]:
    return {name for name in model.names if name[0] == "I"}


SHARE = 0.5  # of the mode's frequency: there the first term that is left out is a sixteenth


def _mode_found(found: Uncertain, case: Case) -> list[Finding]:
    """What is to be told of the mode that sharpens the forces so, behind the low-pass of a case."""
    entries = {"smoothing_s2": found._asdict()}
    if -found.value < CLEAR * found.std:
        sentence = "no structural mode is seen: the forces do not grow with frequency; identify without --flexible"
        return [note(Kind.MODEL, sentence, **entries)]
    frequency = float(1.0 / (2.0 * np.pi * np.sqrt(-found.value)))
    std = frequency * found.std / (2.0 * -found.value)
    sentence = f"a structural mode at {frequency:.3g} +- {std:.2g} Hz amplifies the forces: estimated and "
    sentence += f"compensated, behind a low-pass at {case.recording.filter_cutoff_Hz:.3g} Hz"
    return [note(Kind.MODEL, sentence, **entries, structural_mode_Hz={"value": frequency, "std": std})]


def _below(case: Case, told: Any) -> Case | None:
    """The case with a low-pass at half the mode that an estimate was told of; None where it is as low already.

    Args:
        told: `structural_mode_Hz` of the estimate; None where none is seen.
    """
    cutoff = case.recording.filter_cutoff_Hz
    if told is None or cutoff is None or cutoff <= SHARE * told["value"]:
        return None
    recording = case.recording.model_copy(update={"filter_cutoff_Hz": SHARE * float(told["value"])})
    return case.model_copy(update={"recording": recording})
