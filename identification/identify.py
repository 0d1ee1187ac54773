"""From a recording to parameters: kinematics (7)-(9), regressor (17)-(22), an estimator, physical form.

The delay between forces and motion of a moving run is estimated together with the parameters. What speaks against a
run is looked for before the estimate (`plausibility`) and in what the estimate leaves (`wiring`, `contact`).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimation.biases import accelerometer_bias, drift_told, mass_told, with_uncertain_offsets
from identification.estimation.estimator import independent_poses, require_alive
from identification.estimation.estimators import Method, Problem
from identification.estimation.weighing import of_forces, w_of, whitened
from identification.findings.contact import touched
from identification.findings.contact_free import contacts_told, free_of_contact
from identification.findings.doubts import doubts, other_mass, require_scale, require_sense, systematic
from identification.findings.feed import about_feed
from identification.findings.plausibility import cut_off, scan
from identification.findings.wiring import require_wiring
from identification.hexapod import StrutsDoNotClose
from identification.identifiability import Identifiability, analyse
from identification.model import Model, identification_model
from identification.noise.coloured import coloured_covariance
from identification.noise.components import noise_components
from identification.noise.sources import noise_sources
from identification.noise.turned import turned
from identification.periodic.averaging import PeriodicRun
from identification.recording import Recording
from identification.regressor_blocks import MASS
from identification.result import Delay, Estimate, Evaluation, estimate_of
from identification.runs.conditioning import USUAL, Conditioning
from identification.runs.evaluation import MOST_DELAY, Run, fair_part
from identification.runs.flexible import NO_MODE, below, mode_of
from identification.runs.moving import GAUSS_MARKOV, SANDWICHED, fit_with_delay, run_of
from identification.runs.preparation import standstills
from identification.runs.smoothing import smoothed, smoothing_of
from identification.runs.wrist import WristRun, delay_band, wrist_run

Array = NDArray[np.float64]

RATE_TOLERANCE = 0.02  # of the rate of a recording
SUSPICIOUS_DELAY = 0.02  # [s]; more than any filter of a force channel, and a sign of unrelated streams


def default_model(recording: Recording) -> int:
    """The model that a recording can carry: 9 moving, 5 standing with struts, 0 with orientations only."""
    if recording.struts is None:
        return 0
    return 5 if recording.t is None else 9


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
        number: of the model in Table 2; by default what the recording can carry.
        how: estimator, and what is known beforehand.
        terms: other forms of the error compensation than the model's: K1 to K5.
        conditioning: what is done to a moving run beforehand.

    Raises:
        IdentificationError: the run does not determine the parameters; the message names them.
        RecordingError: the run cannot be evaluated.
        CaseError: the case lacks what the evaluation needs.
    """
    model = identification_model(case, default_model(recording) if number is None else number, terms)
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            try:
                found = _estimated(recording, case, model, how, conditioning)
            except (IdentificationError, RecordingError):
                require_wiring(recording, case, model)
                raise
            if found.warnings:
                require_wiring(recording, case, model)
        return found
    except StrutsDoNotClose as error:
        place = error.place if recording.source in error.place else f"{recording.source}: {error.place}"
        raise StrutsDoNotClose(error.sample, error.lengths, place) from error
    except IdentificationError as error:
        raise IdentificationError(placed(recording.source, error)) from error
    except RecordingError as error:
        raise RecordingError(placed(recording.source, error)) from error


def _estimated(recording: Recording, case: Case, model: Model, how: Method, conditioning: Conditioning) -> Estimate:
    if len(recording.forces) > 1:
        require_alive(recording.forces)
    if recording.t is None or case.setup == "1a":
        if conditioning != USUAL:
            raise RecordingError("is no moving run; --period and --flexible are for moving runs")
        found = _from_standstills(recording, case, model, how)
    else:
        found = _from_motion(recording, case, model, how, conditioning)
        softer = below(case, found.told.get("structural_mode_Hz")) if conditioning.flexible else None
        if softer is not None:
            found = replace(_from_motion(recording, softer, model, how, conditioning), case_hash=case.hash)
    require_scale(model, found.values, case)
    return replace(found, warnings=(*found.warnings, *other_mass(model, found.values, case)))


def placed(source: str, error: Exception) -> str:
    """The message with the file in front, which the mathematics does not know."""
    return str(error) if source in str(error) else f"{source}: {error}"


def identifiability(recording: Recording, case: Case, estimate: Estimate) -> Identifiability:
    """What the run determines, alone and together, of the parameters that were estimated (section 5).

    Args:
        recording: the run of the estimate.
        case: its case.
        estimate: gives model, selection and delay.
    """
    model = identification_model(case, estimate.model, estimate.terms)
    selection = estimate.how.selection(model)
    if recording.t is None or case.setup == "1a":
        matrices = standstills(recording, case, model, scan(recording, case)).regressors
    else:
        run = run_of(recording, case, model, estimate.conditioning, scan(recording, case), estimate.how.biases)
        matrices = run.excerpt().regressors(estimate.delay.value if estimate.delay else 0.0)
    return analyse(matrices @ selection.basis, selection.names)


def _from_standstills(recording: Recording, case: Case, model: Model, how: Method) -> Estimate:
    if model.needs_motion and not set(how.known) >= _inertia(model) | set(how.dropped):
        raise IdentificationError(
            f"{recording.source}: model {model.number} contains inertia, which standstills cannot excite; choose a "
            "model from 0 to 5, or record a motion"
        )
    found = scan(recording, case)
    data = standstills(recording, case, model, found)
    problem = Problem.of(model, case, how)
    scale = np.ones(data.samples) if recording.weights is None else recording.weights[~found.bad]
    matrices, forces = data.regressors * scale[:, None, None], data.forces * scale[:, None]
    selection = how.selection(model)
    whitening = None
    if problem.noise is not None:
        whitening = problem.noise.whitening_from(matrices, forces, selection)
    white = whitened(whitening, matrices, forces)
    fit = how.estimator(problem)(*white, model.names)
    if how.name in SANDWICHED and not how.priors and recording.t is None:
        reduced = independent_poses(white[0] @ selection.basis, fit)
        fit = replace(fit, covariance_robust=selection.basis @ reduced @ selection.basis.T)
    elif how.name in SANDWICHED and not how.priors and recording.t is not None:
        part = fair_part(data.samples)
        coloured = coloured_covariance(turned(white[0][part] @ selection.basis, fit.residuals[part], fit.weights))
        if coloured is not None:
            robust = len(part) / data.samples * selection.basis @ coloured @ selection.basis.T
            fit = replace(fit, covariance_robust=robust)
    fit = of_forces(whitening, fit, matrices, forces)
    require_sense(model, fit)
    warnings = [*found.warnings, *doubts(fit, data.forces)]
    if how.biases is not None:
        free = how.without_biases.estimator(problem)(*white, model.names)
        warnings += drift_told(how.biases, model, free)
        fit = with_uncertain_offsets(fit, model, selection.basis, matrices, w_of(whitening, fit), how.biases)
    felt = None
    if recording.specific_forces is not None and recording.rotations is not None and case.setup != "1a":
        felt = accelerometer_bias(recording.specific_forces[~found.bad], recording.rotations[~found.bad], case.gravity)
    evaluation = Evaluation(data.samples, fit.residuals / scale[:, None], None, accelerometer=felt)
    return estimate_of(model, fit, recording.source, case, evaluation, how, tuple(warnings))


def other_rate(recording: Recording, case: Case) -> list[str]:
    """What to say of a recording whose rate is not the one that predictions assume."""
    if recording.t is None or recording.struts is None:
        return []
    rate, assumed = 1.0 / float(np.median(np.diff(recording.t))), case.recording.rate_Hz
    if recording.averaged is not None or abs(rate / assumed - 1.0) <= RATE_TOLERANCE:
        return []
    return [
        f"recorded at {rate:.4g} Hz; predictions assume {assumed:g} Hz, and standard deviations of this run are "
        f"{np.sqrt(assumed / rate):.3g} times as large for it; set recording.rate_Hz = {rate:.4g}"
    ]


def _inertia(model: Model) -> set[str]:
    return {name for name in model.names if name[0] == "I"}


def _from_motion(recording: Recording, case: Case, model: Model, how: Method, conditioning: Conditioning) -> Estimate:
    found = scan(recording, case)
    problem = Problem.of(model, case, how)
    held: Delay | None = None
    notes: list[str] = []
    run = run_of(recording, case, model, conditioning, found, how.biases)
    if conditioning.flexible and (how.priors or not isinstance(run, Run)):
        raise RecordingError("--flexible sees a mode in struts behind the low-pass, without --prior; leave it out")
    if isinstance(run, WristRun):
        band = delay_band(recording)
        wide = wrist_run(recording, case, model, MOST_DELAY, cutoff=band, bad=found.bad)
        held = fit_with_delay(wide, GAUSS_MARKOV, problem).delay
        notes.append(
            f"delay estimated in the band up to {band:.3g} Hz, the widest that all streams carry; parameters up to "
            f"{run.filter.cutoff:g} Hz at that delay, its uncertainty propagated"
        )
    moving = fit_with_delay(run, how, problem, held=held)
    moving, contacts = free_of_contact(recording, run, moving, how, problem, held)
    if contacts and isinstance(run, WristRun) and isinstance(moving.run, WristRun):
        held = fit_with_delay(wide.without(touched(wide.t, contacts)), GAUSS_MARKOV, problem).delay
        moving = fit_with_delay(moving.run, how, problem, held=held)
    told: dict[str, Any] = {}
    if isinstance(moving.run, Run) and not how.priors:
        basis = how.selection(model).basis
        rich = (
            replace(moving.run, smoothing=True)
            if conditioning.flexible
            else smoothed(moving.run, moving.fit, basis, moving.w, moving.delay.value)
        )
        if rich.smoothing:
            moving = fit_with_delay(rich, how, problem, moving.delay.value)
            smoothing = smoothing_of(rich, moving.fit)
            told["smoothing_s2"] = smoothing._asdict()
            notes += [] if conditioning.flexible else smoothing.notes
            if conditioning.flexible:
                mode = mode_of(smoothing)
                notes.append(NO_MODE if mode is None else mode.note(case.recording.filter_cutoff_Hz))
                told |= {} if mode is None else {"structural_mode_Hz": mode.to_json()}
    warnings = [*found.warnings, *cut_off(recording), *run.warnings]
    warnings += [f"{text}; left out" for text in contacts_told(recording, contacts)]
    if abs(moving.delay.value) >= SUSPICIOUS_DELAY:
        warnings.append(f"delay of {moving.delay.value * 1e3:.1f} ms: do the streams match?")
    warnings += doubts(moving.fit, moving.run.forces)
    warnings += systematic(moving.fit, moving.run.noise_correlation)
    noise = None
    if case.sensors.state_noise and not isinstance(moving.run, WristRun):
        if how.name in SANDWICHED and not how.priors:
            noise = noise_sources(moving.run, moving.fit, moving.w, moving.delay.value, case.sensors)
            warnings += noise.doubts
        else:
            warnings.append(
                "the noise that the case states is compared with s0 for gauss-markov and consistent without priors only"
            )
    if isinstance(moving.run, Run):
        components = noise_components(moving.run, moving.fit, case.sensor_frame.bars is None)
        if components is not None:
            told["noise_components"] = components.to_json()
            notes += components.notes(how.weights or case.sensors.weights)
    if how.biases is not None:
        free = fit_with_delay(moving.run, how.without_biases, problem, moving.delay.value, held)
        warnings += drift_told(how.biases, model, free.fit)
        if MASS in model.blocks:
            exactly = replace(how, biases=how.biases.exact)
            exact = fit_with_delay(moving.run, exactly, problem, moving.delay.value, held)
            notes.append(mass_told(model, moving.fit, exact.fit))
    if isinstance(moving.run, PeriodicRun):
        notes, told = [*notes, *moving.run.notes], moving.run.told
        warnings += moving.run.doubts(moving.fit, moving.w)
    if recording.override is not None:
        slower, entries = about_feed(recording)
        warnings, told = warnings + slower, told | entries
    notes = [*notes, *other_rate(recording, case)]
    if recording.averaged is not None:
        notes, told = [*notes, recording.averaged.note(moving.w, moving.fit.s0)], told | recording.averaged.to_json()
    evaluation = Evaluation(
        moving.run.samples, moving.residuals, moving.delay, noise, notes=tuple(notes), conditioning=conditioning,
        told=told,
    )  # fmt: skip
    return estimate_of(model, moving.fit, recording.source, case, evaluation, how, tuple(warnings))
