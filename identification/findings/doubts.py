"""What an estimate says against itself: refusals of what cannot be, warnings of what is hardly so."""

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.schema import Case
from identification.estimation.fit import Fit
from identification.finding import Finding, Kind, warning
from identification.model import Model
from identification.regressor_blocks import MASS

Array = NDArray[np.float64]

SUSPICIOUS_RATIO = 1.5  # of robust to white standard deviations: the residuals are far from white
SYSTEMATIC = 0.35  # lag-one autocorrelation of residuals beyond that of filtered white noise
LEAST_SERIES = 50  # samples that tell an autocorrelation
THOUSANDTH = (3e-4, 1e-2)  # of the nominal mass, with weights of up to some times it
GRAM = 1e-3  # [kg]
OTHER_MASS = 1.0 / 3.0  # of the nominal mass
LEAST_EXPLAINED = 0.5  # of the forces' variance; a model that leaves more does not belong to the run


def systematic(fit: Fit, usual: float) -> list[Finding]:
    """Whether neighbouring residuals are more alike than the filter makes those of white noise."""
    left = fit.residuals
    alike = np.sum(left[1:] * left[:-1], axis=0) / np.maximum(np.sum(left**2, axis=0), np.finfo(float).tiny)
    if len(left) < LEAST_SERIES or float(np.median(alike)) < usual + SYSTEMATIC:
        return []
    told = f"residuals follow each other (correlation {float(np.median(alike)):.2f}, of noise {usual:.2f}): a long "
    told += "contact, a model without what moves the forces, or coloured noise; look at plots/residuals.svg"
    return [warning(Kind.MODEL, told)]


def require_sense(model: Model, fit: Fit) -> None:
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


def require_scale(model: Model, values: Array, case: Case) -> None:
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


def other_mass(model: Model, values: Array, case: Case) -> list[Finding]:
    """What to say where the mass in u, shape (u,), is far from nominal, with any number of the case's payloads."""
    if MASS not in model.blocks or case.nominal is None or case.setup == "1a":
        return []
    mass = float(values[model.names.index("m")])
    expected = min((body.mass_kg for body in case.bodies), key=lambda known: abs(mass - known))
    if abs(mass - expected) <= OTHER_MASS * expected:
        return []
    what = "nominal.mass_kg" if expected == case.nominal.mass_kg else "nominal.mass_kg with payloads"
    told = f"the mass comes out as {mass:.3g} kg where {what} is {expected:.3g} kg, more than a third off: correct "
    return [warning(Kind.CASE, f"{told}nominal, or check gravity, units and what is mounted")]


def unlikely(fit: Fit, forces: Array) -> list[Finding]:
    """What an estimate of forces, shape (n, 6), itself says against its standard deviations, or against its model."""
    found = []
    white, robust = (np.diag(c) for c in (fit.covariance, fit.covariance_robust))
    ratio = float(np.sqrt(np.median(robust[white > 0.0] / white[white > 0.0])))
    if ratio > SUSPICIOUS_RATIO:
        told = f"robust standard deviations are {ratio:.1f} times those of (28): residuals are not white, the model or "
        told += "the evaluation leaves something systematic; trust the robust ones at most"
        found.append(warning(Kind.NOISE, told))
    spread = np.sum(fit.weights * forces.var(axis=0))
    left = np.sum(fit.weights * np.mean(fit.residuals**2, axis=0))
    moves = bool(np.ptp(forces, axis=0).max() > 0.0) and len(fit.values) > forces.shape[1]
    if moves and len(forces) > len(fit.values) and left > (1.0 - LEAST_EXPLAINED) * spread:
        told = f"the model explains only {100 * max(0.0, 1.0 - left / spread):.0f} % of the forces' variance; check "
        found.append(warning(Kind.MODEL, f"{told}order, sign and unit of forces and struts"))
    return found
