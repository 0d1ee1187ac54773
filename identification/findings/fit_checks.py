"""Checks of every fit: findings from residuals, samples and recording, and from the estimated body.

A new check is one more function in `CHECKS` at the end. Impossible results are refused. Of the body, the mass,
the centre of gravity and the spread of the mass are checked. For offsets that drift, each channel gets a straight line
in time, which is judged by deviations that allow for noise with memory.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import block_diag
from scipy.special import stdtrit

from cases.errors import IdentificationError
from cases.schema import Case
from cases.units import Array, Indices
from identification.estimation.fit import Fit, Regression, inverse_root, joint_triangle
from identification.finding import Finding, Kind, note, warning
from identification.model import Model
from identification.parameters import INERTIA, INERTIA_INDEX, MASS, physical_form
from identification.recording import Recording
from identification.runs.sample_checks import cut_off, places
from identification.samples import Fitted
from identification.signals import fair_part

SUSPICIOUS_RATIO = 1.5  # of robust to white standard deviations: the residuals are far from white
SYSTEMATIC = 0.35  # lag-one autocorrelation of residuals beyond that of filtered white noise
LEAST_SERIES = 50  # samples from which on an autocorrelation is estimated
LEAST_EXPLAINED = 0.5  # of the forces' variance; a model that explains less does not belong to the run
SUSPICIOUS_DELAY = 0.02  # [s]; more than any filter of a force channel, and a sign of unrelated streams


def following(fitted: Fitted) -> float | None:
    """Correlation of neighbouring residuals, where they are more alike than the filter makes those of white noise."""
    residuals = fitted.fit.residuals
    squares = np.maximum(np.sum(residuals**2, axis=0), np.finfo(float).tiny)
    alike = float(np.median(np.sum(residuals[1:] * residuals[:-1], axis=0) / squares))
    return None if len(residuals) < LEAST_SERIES or alike < fitted.samples.noise_correlation + SYSTEMATIC else alike


def systematic(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Neighbouring residuals of a run that moves are too much alike."""
    alike = following(fitted) if fitted.samples.nuisances else None
    if alike is None:
        return []
    sentence = (
        f"residuals follow each other (correlation {alike:.2f}, of noise {fitted.samples.noise_correlation:.2f}): "
        "a long contact, a dimension in the case that is not the machine's, a model without what moves the forces, "
        "a compensated wrench, or coloured noise; look at their figure in the report"
    )
    return [warning(Kind.MODEL, sentence)]


def far_from_white(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Findings of an estimate against its own standard deviations."""
    white, robust = (np.diag(c) for c in (fitted.fit.covariance, fitted.fit.covariance_robust))
    ratio = float(np.sqrt(np.median(robust[white > 0.0] / white[white > 0.0])))
    if not ratio > SUSPICIOUS_RATIO:
        return []
    sentence = (
        f"robust standard deviations are {ratio:.1f} times those of (28): residuals are not white, the model or "
        "the evaluation leaves something systematic: report the robust ones, and take them for a lower bound"
    )
    return [warning(Kind.NOISE, sentence)]


def unexplained(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Findings of an estimate against its own model."""
    fit, forces = fitted.fit, fitted.regression.forces
    spread = np.sum(fit.weights * forces.var(axis=0))
    misfit = np.sum(fit.weights * np.mean(fit.residuals**2, axis=0))
    moves = bool(np.ptp(forces, axis=0).max() > 0.0) and len(fit.values) > forces.shape[1]
    if not (moves and len(forces) > len(fit.values) and misfit > (1.0 - LEAST_EXPLAINED) * spread):
        return []
    share = f"{100 * max(0.0, 1.0 - misfit / spread):.0f} % of the forces' variance"
    remedy = "check order, sign and unit of forces and struts"
    return [warning(Kind.MODEL, f"the model explains only {share}; {remedy}")]


def other_feed(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Rows that the recording's own column says went at another feed than 100 %."""
    if recording.override is None or not fitted.samples.nuisances:
        return []
    on = np.ones(len(recording.forces), dtype=bool) if recording.trigger is None else recording.trigger
    rows = on & (np.abs(recording.override - 1.0) > 1e-6)
    if not rows.any():
        return []
    low, high = float(recording.override[rows].min()), float(recording.override[rows].max())
    sentence = (
        f"the recorded override is {100 * low:.3g} to {100 * high:.3g} %: the parameters are valid, for they come from "
        "the measured motion; figures of the plan are not of this run: accelerations go with the square of the feed"
    )
    return [warning(Kind.FEED, sentence, places(recording.lines, rows), feed={"lowest": low, "highest": high})]


def late(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """A delay that no filter makes."""
    if abs(fitted.at) < SUSPICIOUS_DELAY:
        return []
    return [warning(Kind.CLOCK, f"delay of {fitted.at * 1e3:.1f} ms: do the streams match?")]


def averaged(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """How many samples of the forces were averaged for one of the motion."""
    if recording.averaged == 1.0:
        return []
    sentence = f"forces: {recording.averaged:.4g} samples averaged for each of the motion, centred: no group delay"
    return [note(Kind.CLOCK, sentence, averaged={"ratio": recording.averaged})]


def placed(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Errors that depend on the pose, in the keys by which a case states them."""
    field = fitted.fit.field
    if field is None:
        return []
    settings = ", ".join(f"{key} = {value:g}" for key, value in field.keys.items())
    sentence = f"[sensors] {settings}: with this in the case, plans count on the errors that depend on the pose"
    return [note(Kind.NOISE, "" if case.sensors.pose_error_N else sentence, pose_errors=field.keys)]


THOUSANDTH = (3e-4, 1e-2)  # of the nominal mass, with weights of up to some times it
GRAM = 1e-3  # [kg]
FAR = 5.0  # [m] from the origin of the platform
OTHER_MASS = 1.0 / 3.0  # of the nominal mass
CERTAIN = 4.0  # standard deviations by which a quantity is below zero for certain


def doubtful_body(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """What to say of a body that is not the expected one, or that cannot be.

    Raises:
        IdentificationError: the mass is a thousandth or a thousand times the expected.
    """
    model, fit = fitted.samples.model, fitted.fit
    if MASS not in model.blocks:
        return []
    mass, findings = float(fit.values[model.names.index("m")]), []
    if case.nominal is not None:
        findings += _other_mass(mass, case)
    moments = fit.values[[model.names.index(f"m{axis}C") for axis in "xyz"]]
    distance = float(np.linalg.norm(moments) / max(abs(mass), GRAM))
    if case.sensor_frame.has_moments and distance >= FAR:  # further away than a machine is large
        sentence = f"the centre of gravity comes out {distance:.3g} m from the origin of the platform: moments seem to "
        findings.append(warning(Kind.CASE, f"{sentence}be in N mm; set recording.units.moments = 'Nmm' in the case"))
    return [*findings, *_no_body(model, fit)]


def _other_mass(mass: float, case: Case) -> list[Finding]:
    """What to say of a mass [kg] that is far from nominal, with any number of the case's payloads."""
    low, high = THOUSANDTH  # sensors at the drive's end of the struts carry the whole rods, which are part of the mass
    struts = case.sensor_frame.struts
    rods = 6 * struts.rod_mass_kg if struts is not None and struts.at == "drive" else 0.0
    nominal, *_ = masses = [body.mass_kg + rods for body in case.bodies]
    if low < mass / nominal < high or low < nominal / max(mass, GRAM) < high:
        unit = "kN" if mass < nominal else "mN"
        raise IdentificationError(
            f"the mass comes out as {mass:.4g} kg where nominal.mass_kg makes {nominal:g}: forces seem to be "
            f"in {unit}; set recording.units.forces = '{unit}' in the case"
        )
    expected = min(masses, key=lambda body_mass: abs(mass - body_mass))
    if abs(mass - expected) <= OTHER_MASS * expected:
        return []
    sentence = (
        f"the mass comes out as {mass:.3g} kg where nominal.mass_kg, with payloads, makes {expected:.3g} kg: correct "
        "nominal, or check gravity, units, what is mounted, and that forces are recorded raw, not compensated"
    )
    return [warning(Kind.CASE, sentence)]


def _no_body(model: Model, fit: Fit) -> list[Finding]:
    """What to say of moments of inertia that no body has: 1/2 tr(I) 1 - I, how mass spreads, has no negative one."""
    if INERTIA not in model.blocks:
        return []
    form = physical_form(model)
    names = [parameter.name for parameter in form.parameters]
    places = [names.index(f"IC{i + 1}{j + 1}") for i, j in INERTIA_INDEX]
    own = slice(len(model.parameters))
    values, white = form.of(fit.values[own], fit.covariance[own, own])
    robust = form.of(fit.values[own], fit.covariance_robust[own, own])[1]
    inertia = np.zeros((3, 3))
    for (i, j), moment in zip(INERTIA_INDEX, values[places], strict=True):
        inertia[i, j] = inertia[j, i] = moment
    moments, lines = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    least, line = float(moments[0]), lines[:, 0]
    slopes = np.array([0.5 - line[i] ** 2 if i == j else -2.0 * line[i] * line[j] for i, j in INERTIA_INDEX])
    deviation = max(float(np.sqrt(slopes @ c[np.ix_(places, places)] @ slopes)) for c in (white, robust))
    if least >= -CERTAIN * deviation:
        return []
    along = ", ".join(f"{component + 0.0:.2f}" for component in line)
    sentence = f"no body has these moments of inertia: its mass would spread by {least:.2g} +- {deviation:.1g} kg m^2 "
    sentence += f"along ({along}) of the platform, and cannot by less than 0; check signs and order of force and "
    return [warning(Kind.MODEL, f"{sentence}moment channels, and the dimensions of the machine")]


WARM_UP = "let the sensor warm up, and run hexcite tare shortly before its readings count"
CHANCE = 1e-6  # probability of a false drift, in each channel
LEAST_FREEDOM = 4.0  # degrees of freedom of a channel, from which on a drift can be judged


def drifting(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """The channel whose offset changes most within a run, with the change over the run."""
    samples, method = fitted.samples, fitted.method
    freedom = len(fitted.fit.residuals) - len(fitted.regression.names) / 6 - 1
    if method.priors or freedom < LEAST_FREEDOM:
        return []
    span = float(np.ptp(samples.t))
    if span == 0.0:
        return []
    line = (samples.t - samples.t.mean()) / span * samples.scale
    part = fair_part(len(line))
    weights = fitted.fit.weights if fitted.whitening is None else np.ones(6)
    free = freedom * len(part) / len(line)
    change, white = _solved(_with_lines(fitted, line, part), weights, free)
    if not np.any(np.abs(change[-6:]) > -stdtrit(free, CHANCE / 2.0) * np.sqrt(white)):
        return []  # no more than white noise makes; noise with memory makes deviations larger, and takes time
    lines = _with_lines(fitted, line, np.arange(len(line)))
    change, white = _solved(lines, weights, freedom)
    robust = samples.robust_covariance(lines.regressors, lines.residuals(change), weights, fitted.whitening)
    spread = white if robust is None else np.maximum(white, np.diag(robust.covariance)[-6:])
    # noise with a long memory has so few independent samples that a straight line is likely
    most = -stdtrit(np.maximum(freedom * white / spread, 1.0), CHANCE / 2.0)
    sure = np.abs(change[-6:]) / np.sqrt(spread)
    if not np.any(sure > most):
        return []
    worst = int(np.argmax(sure / most))
    channel, unit = channel_words(case, worst)
    by = float(change[-6:][worst])
    over = f"these {round(span) + 1} standstills" if recording.t is None else f"the {span:.3g} s of this run"
    others = [channel_words(case, k)[0] for k in np.flatnonzero(sure > most).tolist() if k != worst]
    more = f"; {', '.join(others)} too" if others else ""
    sentence = (
        f"the offset of {channel} drifts by {by:+.2g} {unit} over {over} ({sure[worst]:.0f} standard "
        f"deviations){more}: the result has the mean; {WARM_UP}"
    )
    drift = {"channel": channel, "change": by, "standard_deviations": float(sure[worst]), "span": span, "unit": unit}
    return [warning(Kind.OFFSETS, sentence, offset_drift=drift)]


def channel_words(case: Case, k: int) -> tuple[str, str]:
    """Name of a channel in the file, and its unit."""
    name, _, unit = case.sensor_frame.channels[k].rpartition("_")
    return case.recording.file_name(f"{name}_{unit}"), {"Nm": "N m"}.get(unit, unit)


def _with_lines(fitted: Fitted, line: Array, rows: Indices) -> Regression:
    """Residuals of some samples by A with a line in each channel, as an estimator takes them."""
    basis = fitted.method.selection(fitted.samples.model).basis
    free = fitted.regression.regressors[rows] @ block_diag(basis, np.eye(fitted.regression.nuisance))
    columns = np.dstack([free, line[rows, None, None] * np.eye(6)])
    return Regression(columns, fitted.fit.residuals[rows], ()).whitened(fitted.whitening)


def _solved(lines: Regression, weights: Array, freedom: float) -> tuple[Array, Array]:
    """How far the values of a fit move with the lines, and the variance of these six by white noise."""
    top = joint_triangle(lines.regressors, lines.forces, np.sqrt(weights))
    half, change = inverse_root(top[:-1, :-1]), np.linalg.lstsq(top[:-1, :-1], top[:-1, -1], rcond=None)[0]
    covariance = half @ half.T * top[-1, -1] ** 2 / (6.0 * freedom)
    return np.asarray(change), np.diag(covariance)[-6:]


CHECKS: tuple[Callable[[Recording, Case, Fitted], list[Finding]], ...] = (
    placed, late, far_from_white, unexplained, systematic, other_feed, averaged, drifting, doubtful_body,
)  # fmt: skip
"""The checks of every fit, in the order of their findings."""


def fit_findings(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Findings of recorder, estimator and window, and of all checks."""
    cut = cut_off(recording) if fitted.samples.nuisances else []
    checked = [finding for check in CHECKS for finding in check(recording, case, fitted)]
    return [*cut, *fitted.fit.findings, *fitted.samples.window, *checked]
