"""From a recording to parameters: kinematics (7)-(9), regressor (17)-(22), an estimator, physical form.

The delay between forces and motion of a moving run is estimated together with the parameters. What speaks against a
run is looked for before the estimate (`plausibility`) and in what the estimate leaves (`swapped`, `contact`).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.accelerated import accelerated, compared
from identification.biases import OFFSET_NAMES, Biases, accelerometer_bias, gain, widened
from identification.conditioning import USUAL, Conditioning
from identification.contact import Contact, find_contacts, touched
from identification.estimator import independent_poses, require_alive
from identification.estimators import Method, Problem, gauss_markov_of, method, robust_of
from identification.evaluation import MOST_DELAY, Run, moving_run, standstills
from identification.feed import about_feed, recorded_overrides
from identification.fit import Fit
from identification.flexible import NO_MODE, below, mode_of
from identification.formats.stream import Averaged
from identification.identifiability import Identifiability, analyse
from identification.long_contact import least_trimmed_squares
from identification.model import MASS, Model, identification_model
from identification.noise_components import noise_components
from identification.noise_sources import noise_sources
from identification.periodic import PeriodicRun, periodic_run
from identification.plausibility import Scan, places, scan
from identification.recording import Recording
from identification.result import Delay, Estimate, Evaluation, estimate_of
from identification.smoothing import smoothed, smoothing_of
from identification.swapped import other_wiring
from identification.wrist import WristRun, delay_band, wrist_run

Array = NDArray[np.float64]

DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-9  # [s]; the step that is left is in the fit's own nuisance
SUSPICIOUS_DELAY = 0.02  # [s]; more than any filter of a force channel, and a sign of unrelated streams
SUSPICIOUS_RATIO = 1.5  # of robust to white standard deviations: the residuals are far from white
SEARCHES = 4  # for contacts; each finds what the one before hid
SYSTEMATIC = 0.35  # lag-one autocorrelation of residuals beyond that of filtered white noise
CALMER = 0.7  # of the residuals, that leaving a long contact out must at least take
MOST_TOUCHED = 0.25  # of the samples in contact; more is no identification run
LEAST_SERIES = 50  # samples that tell an autocorrelation
LEAST_EXPLAINED = 0.5  # of the forces' variance; a model that leaves more does not belong to the run
SANDWICHED = ("gauss-markov", "consistent")  # whose robust covariance is the sandwich of the weights alone
GAUSS_MARKOV = method()
AnyRun = Run | WristRun | PeriodicRun


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
        if len(recording.forces) > 1:
            require_alive(recording.forces)
        if recording.t is None or case.setup == "1a":
            if conditioning != USUAL:
                raise RecordingError("is no moving run; --period, --accelerated and --flexible are for moving runs")
            return _from_standstills(recording, case, model, how)
        found = _from_motion(recording, case, model, how, conditioning)
        softer = below(case, found.told.get("structural_mode_Hz")) if conditioning.flexible else None
        if softer is not None:
            found = replace(_from_motion(recording, softer, model, how, conditioning), case_hash=case.hash)
        return found
    except IdentificationError as error:
        raise IdentificationError(placed(recording.source, error)) from error
    except RecordingError as error:
        raise RecordingError(placed(recording.source, error)) from error


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
        matrices = standstills(recording, case, model).regressors
    else:
        run = run_of(recording, case, model, estimate.conditioning, biases=estimate.how.biases)
        matrices = run.regressors(estimate.delay.value if estimate.delay else 0.0)
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
    white = _whitened(whitening, matrices, forces)
    fit = how.estimator(problem)(*white, model.names)
    if how.name in SANDWICHED and not how.priors and recording.t is None:
        reduced = independent_poses(white[0] @ selection.basis, fit)
        fit = replace(fit, covariance_robust=selection.basis @ reduced @ selection.basis.T)
    fit = _of_forces(whitening, fit, matrices, forces)
    _require_sense(model, fit)
    _require_wiring(matrices, forces, fit)
    warnings = [*found.warnings, *doubts(fit, data.forces)]
    if how.biases is not None:
        free = how.without_biases.estimator(problem)(*white, model.names)
        warnings += _drift(how.biases, model, free)
        fit = _with_uncertain_offsets(fit, model, selection.basis, matrices, _w(whitening, fit), how.biases)
    felt = None
    if recording.specific_forces is not None and recording.rotations is not None and case.setup != "1a":
        felt = accelerometer_bias(recording.specific_forces[~found.bad], recording.rotations[~found.bad], case.gravity)
    evaluation = Evaluation(data.samples, fit.residuals / scale[:, None], None, accelerometer=felt)
    return estimate_of(model, fit, recording.source, case, evaluation, how, tuple(warnings))


def _with_uncertain_offsets(fit: Fit, model: Model, basis: Array, matrices: Array, w: Array, biases: Biases) -> Fit:
    """The fit with the uncertainty of offsets that it took from another result."""
    offsets = [model.names.index(name) for name in OFFSET_NAMES]
    moves = -basis @ gain(matrices @ basis, w, matrices[:, :, offsets])
    moves[offsets] += np.eye(6)
    return widened(fit, moves, biases.covariance)


def _drift(biases: Biases, model: Model, free: Fit) -> list[str]:
    offsets = [model.names.index(name) for name in OFFSET_NAMES]
    spread = max(free.covariance, free.covariance_robust, key=lambda c: float(np.trace(c[np.ix_(offsets, offsets)])))
    units = tuple(model.parameters[k].unit for k in offsets)
    return biases.drift(free.values[offsets], spread[np.ix_(offsets, offsets)], units)


def _inertia(model: Model) -> set[str]:
    return {name for name in model.names if name[0] == "I"}


def _whitened(whitening: Array | None, matrices: Array, forces: Array) -> tuple[Array, Array]:
    """Both multiplied with the root of W."""
    return (matrices, forces) if whitening is None else (whitening @ matrices, forces @ whitening.T)


def _of_forces(whitening: Array | None, fit: Fit, matrices: Array, forces: Array) -> Fit:
    """A fit to whitened forces with the residuals of the forces themselves, and the diagonal of W."""
    if whitening is None:
        return fit
    return replace(fit, residuals=forces - matrices @ fit.values, weights=np.sum(whitening**2, axis=0))


def _w(whitening: Array | None, fit: Fit) -> Array:
    """W for one sample, shape (6, 6)."""
    return np.diag(fit.weights) if whitening is None else whitening.T @ whitening


class Moving(NamedTuple):
    """A run with its fit: residuals are those of the forces as recorded; W is the square of `whitening` where given."""

    run: AnyRun
    fit: Fit
    delay: Delay
    residuals: Array
    whitening: Array | None = None

    @property
    def w(self) -> Array:
        """W for one sample, shape (6, 6)."""
        return _w(self.whitening, self.fit)


def _from_motion(recording: Recording, case: Case, model: Model, how: Method, conditioning: Conditioning) -> Estimate:
    found = scan(recording, case)
    problem = Problem.of(model, case, how)
    held: Delay | None = None
    notes: list[str] = []
    run = run_of(recording, case, model, replace(conditioning, accelerated=None), found, how.biases)
    if conditioning.accelerated is not None and not isinstance(run, Run):
        raise RecordingError("--accelerated goes by the accelerations of struts, behind the low-pass; leave it out")
    if conditioning.flexible and (how.priors or not isinstance(run, Run)):
        raise RecordingError("--flexible sees a mode in struts behind the low-pass, without --prior; leave it out")
    if isinstance(run, WristRun):
        band = delay_band(recording)
        wide = wrist_run(recording, case, model, MOST_DELAY, cutoff=band)
        held = fit_with_delay(wide, GAUSS_MARKOV, problem).delay
        notes.append(
            f"delay estimated in the band up to {band:.3g} Hz, the widest that all streams carry; parameters up to "
            f"{run.filter.cutoff:g} Hz at that delay, its uncertainty propagated"
        )
    moving = fit_with_delay(run, how, problem, held=held)
    contacts: tuple[Contact, ...] = ()
    for _ in range(SEARCHES if isinstance(run, Run) else 0):  # a wrist run leaves too much for that
        # A contact biases the fit, and so the search for it: a robust fit begins, better ones follow.
        left = _without_pull(run, moving, how, problem)
        before, contacts = contacts, find_contacts(run.t, left, model.structure, run.forces - left)
        if contacts == before:
            break
        rows = touched(run.t, contacts)
        require_free(float(rows.mean()), [_told(recording, contact) for contact in contacts])
        assert isinstance(run, Run)
        moving = fit_with_delay(run.without(rows), how, problem, moving.delay.value)
    if isinstance(run, Run) and isinstance(moving.run, Run) and _systematic(moving):
        longer = _long_contacts(run, moving)
        rows = touched(run.t, longer)
        freed = (
            fit_with_delay(run.without(rows), how, problem, moving.delay.value) if 0.0 < rows.mean() < 1.0 else moving
        )
        if _spread(freed) < CALMER * _spread(moving) and not _systematic(freed):
            require_free(float(rows.mean()), [_told(recording, contact) for contact in longer])
            moving, contacts = freed, longer
    whole, section = moving, None
    if conditioning.accelerated is not None:
        assert isinstance(moving.run, Run)
        section = accelerated(moving.run, conditioning.accelerated)
        moving = fit_with_delay(section.run, how, problem, moving.delay.value)
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
    warnings = [*found.warnings, *run.warnings]
    warnings += [f"{_told(recording, contact)}; left out" for contact in contacts]
    if abs(moving.delay.value) >= SUSPICIOUS_DELAY:
        warnings.append(f"delay of {moving.delay.value * 1e3:.1f} ms: do the streams match?")
    warnings += doubts(moving.fit, moving.run.forces)
    warnings += _systematic(moving)
    noise = None
    if case.sensors.state_noise and isinstance(moving.run, Run):
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
        warnings += _drift(how.biases, model, free.fit)
    if isinstance(moving.run, PeriodicRun):
        notes, told = [*notes, *moving.run.notes], moving.run.told
        warnings += moving.run.doubts(moving.fit, moving.w)
    if recording.override is not None:
        slower, entries = about_feed(recording, recorded_overrides(recording), "the recorded override")
        warnings, told = warnings + slower, told | entries
    if recording.averaged is not None:
        notes, told = [*notes, _about_averages(recording.averaged, moving)], told | _averages(recording.averaged)
    evaluation = Evaluation(
        moving.run.samples, moving.residuals, moving.delay, noise, notes=tuple(notes), conditioning=conditioning,
        told=told,
    )  # fmt: skip
    chosen = estimate_of(model, moving.fit, recording.source, case, evaluation, how, tuple(warnings))
    if section is None:
        return chosen
    evaluation = Evaluation(whole.run.samples, whole.residuals, whole.delay)
    note, more = compared(section, chosen, estimate_of(model, whole.fit, "", case, evaluation, how, ()))
    return replace(chosen, notes=(*chosen.notes, note), told={**chosen.told, **more})


def _averages(averaged: Averaged) -> dict[str, Any]:
    """What result files say of forces that were averaged."""
    return {
        "averaged": {
            "ratio": averaged.ratio,
            "interval_s": averaged.interval,
            "sample_noise": averaged.noise.tolist(),
            "expected_noise": averaged.expected.tolist(),
        }
    }


def _about_averages(averaged: Averaged, moving: Moving) -> str:
    """What people are told of them: the noise that is left beside that which white samples would leave."""
    expected = float(np.sqrt(np.trace(moving.w @ np.diag(averaged.expected**2)) / 6.0))
    return (
        f"forces: {averaged.ratio:.4g} samples averaged for each of the motion ({averaged.interval * 1e3:.4g} ms, "
        f"centred: no group delay); noise of a sample {float(np.median(averaged.noise)):.3g} N; were it white, s0 "
        f"would be {expected:.3g}, it is {moving.fit.s0:.3g}"
    )


def run_of(
    recording: Recording,
    case: Case,
    model: Model,
    conditioning: Conditioning,
    found: Scan | None = None,
    biases: Biases | None = None,
) -> AnyRun:
    """A moving run, ready to be evaluated, as it was asked for.

    Args:
        recording: with a clock.
        case: its case.
        model: gives A.
        conditioning: what is done to it.
        found: samples that may not be used.
        biases: of a wrist run, known beforehand.

    Raises:
        RecordingError: it cannot be evaluated so.
        IdentificationError: the model needs what the recording does not have.
    """
    if conditioning.periodic is not None:
        return periodic_run(recording, case, model, conditioning.periodic, found)
    if recording.struts is None:
        return wrist_run(recording, case, model, MOST_DELAY, biases)
    run = moving_run(recording, case, model, found=found)
    return run if conditioning.accelerated is None else accelerated(run, conditioning.accelerated).run


def _long_contacts(run: Run, moving: Moving) -> tuple[Contact, ...]:
    """Contacts of up to half a run, by what the half of the samples that agree best says of all."""
    matrices = run.regressors(moving.delay.value)
    half = least_trimmed_squares(matrices, run.forces, moving.w, run.filter.step * run.filter.stride)
    if half is None:
        return ()
    left = half.residuals
    return find_contacts(run.t, left, run.model.structure, run.forces - left, left[half.explained])


def _spread(moving: Moving) -> float:
    """Rms of the weighted residuals."""
    left = moving.fit.residuals
    return float(np.sqrt(np.mean(np.einsum("ni,ij,nj->n", left, moving.w, left))))


def require_free(share: float, contacts: Sequence[str]) -> None:
    """Raises IdentificationError where too much of a run is in contact.

    Args:
        share: of its samples.
        contacts: what is told of each.
    """
    if share > MOST_TOUCHED:
        raise IdentificationError(
            f"the forces leave the model in {100 * share:.0f} % of the samples, as in contact ({contacts[0]}); an "
            "identification run must be free: check columns, struts and model, or record again"
        )


def _without_pull(run: AnyRun, moving: Moving, how: Method, problem: Problem) -> Array:
    """Residuals of a robust fit to all samples of a run, shape (n, 6): gross deviations do not draw it to them."""
    selection = how.selection(run.model)
    matrices, forces = run.regressors(moving.delay.value), run.forces
    pooled = problem.pooled if problem.noise is None else bool(np.ptp(problem.noise.force) == 0.0)
    robust = robust_of(replace(problem, pooled=pooled, filtered=run.filtered))
    return robust(matrices @ selection.basis, forces - matrices @ selection.offset, selection.names).residuals


def _told(recording: Recording, contact: Contact) -> str:
    assert recording.t is not None
    rows = (recording.t >= contact.start) & (recording.t <= contact.end)
    return (
        f"{places(recording.lines, rows)}: external contact from {contact.start:.3f} to {contact.end:.3f} s, up to "
        f"{contact.peak:.3g} N"
    )


def fit_with_delay(run: AnyRun, how: Method, problem: Problem, delay: float = 0.0, held: Delay | None = None) -> Moving:
    """Gauss-Newton over the delay; it stays in the last fit as a nuisance, so that its uncertainty counts.

    Args:
        run: to be evaluated.
        how: estimator.
        problem: the run's model, and which channels have the same noise.
        delay: to start from [s].
        held: a delay that is taken as known with its standard deviation, which is propagated, and not estimated.
    """
    model = run.model
    beside = len(run.nuisances) - (held is not None)
    delay = delay if held is None else held.value
    problem = replace(problem, nuisance=beside, filtered=run.filtered)
    search = gauss_markov_of(problem)
    forces, names = run.forces, [*model.names, *run.nuisances[:beside]]
    matrices = run.regressors(delay)
    channels = forces.std(axis=0)
    scale = 1.0 / np.where(channels > 0.0, channels, 1.0) if not problem.pooled else np.ones(6)
    selection, whitening = how.selection(model), None
    for _ in range(DELAY_STEPS):
        # The effect of the delay is that of the best forces of the moment, whatever parameters make them.
        left = (forces - matrices @ selection.offset) * scale
        reduced = matrices @ selection.basis * scale[:, None]
        free = np.linalg.lstsq(reduced.reshape(-1, reduced.shape[2]), left.ravel(), rcond=None)[0]
        values = selection.offset + selection.basis @ free
        effect = run.nuisance_columns(delay, matrices, values)[:, :, :beside]
        if problem.noise is not None:
            whitening = problem.noise.whitening(values)
        augmented = np.dstack([matrices, effect])
        first = np.dstack([matrices @ selection.basis, effect])
        rest = forces - matrices @ selection.offset
        fit = search(*_whitened(whitening, first, rest), [*selection.names, *run.nuisances[:beside]])
        if delay == 0.0:
            _require_wiring(first, rest, _of_forces(whitening, fit, first, rest))
        if held is not None:
            break
        step = float(np.clip(fit.values[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        if abs(step) < DELAY_TOLERANCE:
            break
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
        matrices = run.regressors(delay)
    if abs(delay) >= MOST_DELAY:
        raise IdentificationError(
            f"no delay up to {MOST_DELAY * 1e3:.0f} ms brings forces and motion together; are they of one run?"
        )
    white = _whitened(whitening, augmented, forces)
    fit = how.estimator(problem)(*white, names)
    if how.name in SANDWICHED and not how.priors:
        basis = block_diag(selection.basis, np.eye(beside))
        coloured = run.robust_covariance(white[0] @ basis, fit.residuals, fit.weights, whitening)
        if coloured is not None:
            fit = replace(fit, covariance_robust=basis @ coloured @ basis.T)
    fit = _of_forces(whitening, fit, augmented, forces)
    _require_sense(model, fit)
    told = augmented.shape[2] - (held is None)
    residuals = run.left(augmented[:, :, :told], fit.values[:told])
    basis = block_diag(selection.basis, np.eye(beside))
    if how.biases is not None:
        fit = _with_uncertain_offsets(fit, model, basis, augmented, _w(whitening, fit), how.biases)
    if isinstance(run, WristRun):
        fit = _with_uncertain_motion(run, fit, augmented, basis, _w(whitening, fit), how.biases, delay, held)
    if held is not None:
        return Moving(run, fit, held, residuals, whitening)
    value = delay + (float(fit.values[-1]) if abs(fit.values[-1]) < DELAY_TOLERANCE else 0.0)
    return Moving(
        run,
        fit,
        Delay(value, float(np.sqrt(max(fit.covariance[-1, -1], fit.covariance_robust[-1, -1])))),
        residuals,
        whitening,
    )


def _with_uncertain_motion(
    run: WristRun,
    fit: Fit,
    augmented: Array,
    basis: Array,
    w: Array,
    biases: Biases | None,
    delay: float,
    held: Delay | None,
) -> Fit:
    """The fit with the uncertainty of a held delay and of biases that were taken from the accelerometer."""
    count = len(run.model.names)
    columns = run.known_columns(delay, augmented[:, :, :count], fit.values[:count])
    covariance = np.zeros((4, 4))
    covariance[0, 0] = 0.0 if held is None else held.std**2
    if biases is not None:
        covariance[1:, 1:] = biases.require_accelerometer().covariance
    return widened(fit, basis @ gain(augmented @ basis, w, columns), covariance)


def _systematic(moving: Moving) -> list[str]:
    """Whether neighbouring residuals are more alike than the filter makes those of white noise."""
    left = moving.fit.residuals
    alike = np.sum(left[1:] * left[:-1], axis=0) / np.maximum(np.sum(left**2, axis=0), np.finfo(float).tiny)
    usual = moving.run.noise_correlation
    if len(left) < LEAST_SERIES or float(np.median(alike)) < usual + SYSTEMATIC:
        return []
    return [
        f"residuals follow each other (correlation {float(np.median(alike)):.2f}, of noise {usual:.2f}): a long "
        "contact, a model without what moves the forces, or coloured noise; look at plots/residuals.svg"
    ]


def _require_sense(model: Model, fit: Fit) -> None:
    """Raises IdentificationError where the mass is negative for certain."""
    if MASS not in model.blocks:
        return
    mass = model.names.index("m")
    value, std = float(fit.values[mass]), float(np.sqrt(fit.covariance[mass, mass]))
    if std > 0.0 and value < -3.0 * std:
        raise IdentificationError(
            f"the mass comes out as {value:.4g} +- {std:.2g} kg; check the sign of the forces, "
            "sensor_frame.transducer.sense and gravity_m_s2 of the case"
        )


def _require_wiring(regressors: Array, forces: Array, fit: Fit) -> None:
    """Raises IdentificationError where the forces fit far better in other places than in those they have."""
    wiring = other_wiring(regressors, forces, fit.weights)
    if wiring is not None:
        raise IdentificationError(wiring)


def doubts(fit: Fit, forces: Array) -> list[str]:
    """What an estimate itself says against its standard deviations, or against its model."""
    warnings = list(fit.doubts)
    white, robust = (np.diag(c) for c in (fit.covariance, fit.covariance_robust))
    ratio = float(np.sqrt(np.median(robust[white > 0.0] / white[white > 0.0])))
    if ratio > SUSPICIOUS_RATIO:
        warnings.append(
            f"robust standard deviations are {ratio:.1f} times those of (28): residuals are not white, the model or "
            "the evaluation leaves something systematic; trust the robust ones at most"
        )
    spread = np.sum(fit.weights * forces.var(axis=0))
    left = np.sum(fit.weights * np.mean(fit.residuals**2, axis=0))
    moves = bool(np.ptp(forces, axis=0).max() > 0.0) and len(fit.values) > forces.shape[1]
    if moves and len(forces) > len(fit.values) and left > (1.0 - LEAST_EXPLAINED) * spread:
        warnings.append(
            f"the model explains only {100 * max(0.0, 1.0 - left / spread):.0f} % of the forces' variance; check "
            "order, sign and unit of forces and struts"
        )
    return warnings
