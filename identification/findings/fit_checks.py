"""Checks of every fit: findings from residuals, samples and recording, and from the estimated body.

A new check is one more function in `CHECKS` at the end. Impossible results are refused. Of the body, the mass,
the centre of gravity and the spread of the mass are checked. For offsets that drift, each channel gets a straight line
in time, which is judged by deviations that allow for noise with memory.
"""

from collections.abc import Callable

import numpy as np

from cases.base.errors import Code, IdentificationError, Remedy, Write
from cases.base.phrases import phrase, said
from cases.recording_format import ROLE_UNITS, Role
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.estimation.nearest_body import nearest_body
from identification.finding import Finding, Kind, note, warning
from identification.model.blocks import MASS
from identification.model.model import Model
from identification.recording.recording import Recording
from identification.samples.sample_checks import cut_off, places
from identification.samples.samples import Fitted
from identification.texts import two_digits

REMEMBERED = 1.5  # of robust to white standard deviations, from which noise with memory is worth a note
LEAST_EXPLAINED = 0.5  # of the forces' variance; a model that explains less does not belong to the run
SUSPICIOUS_DELAY = 0.02  # [s]; more than any filter of a force channel, and a sign of unrelated streams


def note_memory(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """How much wider deviations are for noise that remembers: the parameter of which they are widest."""
    white, robust = (
        np.diag(c)[: len(fitted.samples.model.names)] for c in (fitted.fit.covariance, fitted.fit.covariance_robust)
    )
    free = white > 0.0
    ratio = np.sqrt(np.where(free, robust, 0.0) / np.where(free, white, 1.0))
    worst = int(np.argmax(ratio))
    if not ratio[worst] > REMEMBERED:
        return []
    sentence = phrase(
        "noise_memory",
        "noise is not white: the deviation of {name} is {times} times that of white noise; +- counts it",
        name=fitted.samples.model.names[worst],
        times=two_digits(ratio[worst]),
    )
    return [note(Kind.NOISE, sentence, noise_memory=float(ratio[worst]))]


def check_model(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Findings of an estimate against its own model."""
    fit, forces = fitted.fit, fitted.regression.forces
    spread = np.sum(fit.weights * forces.var(axis=0))
    misfit = np.sum(fit.weights * np.mean(fit.residuals**2, axis=0))
    moves = bool(np.ptp(forces, axis=0).max() > 0.0) and len(fit.values) > forces.shape[1]
    if not (moves and len(forces) > len(fit.values) and misfit > (1.0 - LEAST_EXPLAINED) * spread):
        return []
    sentence = phrase(
        "explains_little",
        "the model explains only {share} % of the forces' variance; check order, sign and unit of forces and {drives}",
        share=f"{100 * max(0.0, 1.0 - misfit / spread):.0f}",
        drives=phrase(case.drive_words[0], case.drive_words[0]),
    )
    return [warning(Kind.MODEL, sentence)]


def check_feed(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Rows that the recording's own column says went at another feed than 100 %."""
    if recording.override is None or not fitted.samples.nuisances:
        return []
    on = np.ones(len(recording.forces), dtype=bool) if recording.trigger is None else recording.trigger
    rows = on & (np.abs(recording.override - 1.0) > 1e-6)
    if not rows.any():
        return []
    low, high = float(recording.override[rows].min()), float(recording.override[rows].max())
    sentence = phrase(
        "other_feed",
        "the recorded override is {low} to {high} %: the parameters are valid, for they come from the measured motion; "
        "figures of the plan are not of this run: accelerations go with the square of the feed",
        low=f"{100 * low:.3g}",
        high=f"{100 * high:.3g}",
    )
    return [warning(Kind.FEED, sentence, places(recording.lines, rows), feed={"lowest": low, "highest": high})]


def check_delay(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """A delay that no filter makes."""
    if abs(fitted.at) < SUSPICIOUS_DELAY:
        return []
    delay = f"{fitted.at * 1e3:.1f}"
    return [warning(Kind.CLOCK, phrase("large_delay", "delay of {delay} ms: do the streams match?", delay=delay))]


def note_averaging(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """How many samples of the forces were averaged for one of the motion."""
    if recording.averaged == 1.0:
        return []
    sentence = phrase(
        "averaged",
        "forces: {count} samples averaged for each of the motion, centred: no group delay",
        count=f"{recording.averaged:.4g}",
    )
    return [note(Kind.CLOCK, sentence, averaged={"ratio": recording.averaged})]


def note_pose_errors(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Errors that depend on the pose, in the keys by which a case states them."""
    field = fitted.fit.field
    if field is None:
        return []
    settings = ", ".join(f"{key} = {value:g}" for key, value in field.keys.items())
    sentence = phrase(
        "pose_errors",
        "[sensors] {settings}: with this in the case, plans count on the errors that depend on the pose",
        settings=settings,
    )
    return [note(Kind.NOISE, "" if case.sensors.pose_error_N else sentence, pose_errors=field.keys)]


THOUSANDTH = (3e-4, 1e-2)  # of the nominal mass, with weights of up to some times it
GRAM = 1e-3  # [kg]
FAR = 5.0  # [m] from the origin of the platform
OTHER_MASS = 1.0 / 3.0  # of the nominal mass


def check_body(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
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
        sentence = phrase(
            "moments_in_mm",
            "the centre of gravity comes out {distance} m from the origin of the platform: moments seem to be in N mm; "
            "set recording.units.moments = 'Nmm' in the case",
            distance=f"{distance:.3g}",
        )
        findings.append(warning(Kind.CASE, sentence))
    return [*findings, *_no_body(model, fit)]


def _other_mass(mass: float, case: Case) -> list[Finding]:
    """What to say of a mass [kg] that is far from nominal, with any number of the case's payloads."""
    low, high = THOUSANDTH  # sensors at the drive's end of the struts carry the whole rods, which are part of the mass
    struts = case.sensor_frame.struts
    rods = 0.0 if struts is None else struts.carried_kg
    nominal, *_ = masses = [body.mass_kg + rods for body in case.bodies]
    if low < mass / nominal < high or low < nominal / max(mass, GRAM) < high:
        units, form = ROLE_UNITS[Role.FORCES], case.recording
        kept = form.units.get(Role.FORCES)
        now = units[units.symbol(kept or units.usual) or units.usual]
        wanted = now * (1e3 if mass < nominal else 1e-3)
        unit = next((name for name, value in units.items() if np.isclose(value, wanted)), None)
        unit = unit or ("kN" if mass < nominal else "mN")
        error = IdentificationError(
            problem=phrase(
                "forces_in_unit",
                "the mass comes out as {mass} kg where nominal.mass_kg makes {nominal}: forces seem to be in {unit}",
                mass=f"{mass:.4g}",
                nominal=f"{nominal:g}",
                unit=unit,
            ),
            remedy=phrase(
                "set_forces_unit",
                "set {key} = '{unit}' in the case",
                unit=unit,
                key=form.place("units.forces", case.sensor_frame.channels[0]),
            ),
            code=Code.UNIT,
        )
        # Forces and mass are proportional: tried, the key makes this mass that of a body that is expected.
        then = mass * units[unit] / now
        if kept is not None and min(abs(then - one) / one for one in masses) <= OTHER_MASS and not form.files:
            words = phrase("mass_of_forces_unit", "forces are in {unit}", unit=unit)
            error.remedies = (Remedy(words, (Write(("recording", "units", "forces"), unit),)),)
        raise error
    expected = min(masses, key=lambda body_mass: abs(mass - body_mass))
    if abs(mass - expected) <= OTHER_MASS * expected:
        return []
    sentence = phrase(
        "other_mass",
        "the mass comes out as {mass} kg where nominal.mass_kg, with payloads, makes {expected} kg: correct nominal, "
        "or check gravity, units, what is mounted, and that forces are recorded raw, not compensated",
        mass=f"{mass:.3g}",
        expected=f"{expected:.3g}",
    )
    # what is mounted beside the nominal body makes it heavier; a wrench that is compensated, or read too small, lighter
    return [warning(Kind.CASE, sentence, counted=mass > expected)]


def _no_body(model: Model, fit: Fit) -> list[Finding]:
    """What to say of an inertia that no body has, however noise moved it."""
    parameters = slice(len(model.names))
    nearest = nearest_body(
        model,
        fit.values[parameters],
        fit.covariance[parameters, parameters],
        fit.covariance_robust[parameters, parameters],
    )
    return [impossible(nearest.words)] if nearest is not None and nearest.impossible else []


def impossible(words: str) -> Finding:
    """The finding about an estimate that no body is, in words."""
    sentence = phrase(
        "impossible_body",
        "{words}; check signs and order of force and moment channels, and the dimensions of the machine",
        words=said(words),
    )
    return warning(Kind.MODEL, sentence, impossible_body=True)


def is_impossible(finding: Finding) -> bool:
    """Whether a finding is that one."""
    return bool(finding.quantity.get("impossible_body"))


CHECKS: tuple[Callable[[Recording, Case, Fitted], list[Finding]], ...] = (
    check_model, note_pose_errors, check_delay, note_memory, check_feed, note_averaging, check_body,
)  # fmt: skip
"""The checks of every fit, in the order of their findings."""


def fit_findings(recording: Recording, case: Case, fitted: Fitted) -> list[Finding]:
    """Findings of recorder, estimator and window, and of all checks."""
    cut = cut_off(recording) if fitted.samples.nuisances else []
    checked = [finding for check in CHECKS for finding in check(recording, case, fitted)]
    return [*cut, *fitted.fit.findings, *fitted.samples.window, *checked]
