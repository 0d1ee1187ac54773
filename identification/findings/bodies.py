"""What an estimate says of the body that it is of: its mass, where its centre of gravity is, how its mass spreads."""

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.findings import Finding, Kind, warning
from identification.model import Model
from identification.parameters import INERTIA, INERTIA_INDEX, MASS, physical_form

Array = NDArray[np.float64]

THOUSANDTH = (3e-4, 1e-2)  # of the nominal mass, with weights of up to some times it
GRAM = 1e-3  # [kg]
FAR = 5.0  # [m] from the origin of the platform
OTHER_MASS = 1.0 / 3.0  # of the nominal mass
CERTAIN = 4.0  # standard deviations by which a quantity is below zero for certain


def doubtful_body(model: Model, fit: Fit, case: Case) -> list[Finding]:
    """What to say of a body that is not the expected one, or that cannot be.

    Raises:
        IdentificationError: the mass is a thousandth or a thousand times the expected.
    """
    _require_scale(model, fit.values, case)
    return [*_other_mass(model, fit.values, case), *_far_off(model, fit.values, case), *_no_body(model, fit)]


def _require_scale(model: Model, values: Array, case: Case) -> None:
    """Raises IdentificationError where the mass in u, shape (u,), is a thousandth or a thousand times the expected."""
    if MASS not in model.blocks or case.nominal is None:
        return
    mass, expected = float(values[model.names.index("m")]), case.nominal.mass_kg
    low, high = THOUSANDTH
    if low < mass / expected < high or low < expected / max(mass, GRAM) < high:
        unit = "kN" if mass < expected else "mN"
        raise IdentificationError(
            f"the mass comes out as {mass:.4g} kg where nominal.mass_kg is {expected:g}: forces seem to be in {unit}; "
            f"set recording.units.forces = '{unit}' in the case"
        )


def _other_mass(model: Model, values: Array, case: Case) -> list[Finding]:
    """What to say where the mass in u, shape (u,), is far from nominal, with any number of the case's payloads."""
    if MASS not in model.blocks or case.nominal is None or case.setup == "1a":
        return []
    mass = float(values[model.names.index("m")])
    expected = min((body.mass_kg for body in case.bodies), key=lambda body_mass: abs(mass - body_mass))
    if abs(mass - expected) <= OTHER_MASS * expected:
        return []
    key = "nominal.mass_kg" if expected == case.nominal.mass_kg else "nominal.mass_kg with payloads"
    sentence = f"the mass comes out as {mass:.3g} kg where {key} is {expected:.3g} kg, more than a third off: correct "
    return [warning(Kind.CASE, f"{sentence}nominal, or check gravity, units and what is mounted")]


def _far_off(model: Model, values: Array, case: Case) -> list[Finding]:
    """What to say where u, shape (u,), has its centre of gravity further away than a machine is large."""
    if MASS not in model.blocks or not case.sensor_frame.has_moments:
        return []
    places = [model.names.index(f"m{axis}C") for axis in "xyz"]
    distance = float(np.linalg.norm(values[places]) / max(abs(values[model.names.index("m")]), GRAM))
    if distance < FAR:
        return []
    sentence = f"the centre of gravity comes out {distance:.3g} m from the origin of the platform: moments seem to be "
    return [warning(Kind.CASE, f"{sentence}in N mm; set recording.units.moments = 'Nmm' in the case")]


def _no_body(model: Model, fit: Fit) -> list[Finding]:
    """What to say of moments of inertia that no body has: along any line, mass spreads by zero or more.

    The second moments of a body's mass are 1/2 tr(I) 1 - I, positive semidefinite (Wensing, Kim and Slotine 2018).
    """
    if INERTIA not in model.blocks:
        return []
    form = physical_form(model)
    names = [parameter.name for parameter in form.parameters]
    places = [names.index(f"IC{i + 1}{j + 1}") for i, j in INERTIA_INDEX]
    values, white = form.of(fit.values, fit.covariance)
    robust = form.of(fit.values, fit.covariance_robust)[1]
    inertia = np.zeros((3, 3))
    for (i, j), value in zip(INERTIA_INDEX, values[places], strict=True):
        inertia[i, j] = inertia[j, i] = value
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
