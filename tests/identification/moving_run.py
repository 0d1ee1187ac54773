"""A short moving run of the paper's machine as stacked data: regressors of model 9 and forces with white noise."""

from collections.abc import Callable

import numpy as np
from scipy import stats

from cases.schema import load_case
from cases.sensors import RigidBody, Truth
from identification.estimation.fit import Fit
from identification.model.model import identification_model, regressors
from identification.model.parameters import linear_parameters, physical_form
from tests.helpers import Harmonic
from tests.simulated_machine import kinematics_of_coordinates

Array = np.ndarray

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
FORM = physical_form(MODEL)
NAMES = MODEL.names
PHYSICAL = [p.name for p in FORM.parameters]
SAMPLES = 200
_MOTION = Harmonic(seed=1, duration=2.0).at(np.linspace(0.0, 2.0, SAMPLES, endpoint=False))
A = regressors(MODEL, kinematics_of_coordinates(_MOTION.coordinates, _MOTION.rates, _MOTION.accelerations))
U = linear_parameters(MODEL, CASE.simulation.parameters)
ONES = np.ones(6)


def truth_with(**body: object) -> Array:
    """U of (17) with another body than the case's."""
    truth = CASE.simulation.parameters
    changed = RigidBody.model_validate(truth.body.model_dump() | body)
    return linear_parameters(MODEL, Truth(body=changed, offsets_N=truth.offsets_N, compensation=truth.compensation))


def forces(seed: int, u: Array = U, std: float | Array = 1.0) -> Array:
    return A @ u + std * np.random.default_rng(seed).normal(size=(SAMPLES, 6))


def physical(fit: Fit) -> tuple[Array, Array]:
    """Physical values and their standard deviations."""
    values, covariance = FORM.of(fit.values, fit.covariance)
    return values, np.sqrt(np.diag(covariance))


def coverage(fits: Callable[[int], Fit], truth: Array, seeds: int = 100, robust: bool = False) -> float:
    """Share of the 95 % intervals, over seeds and parameters with a variance, that hold the truth."""
    inside = []
    for seed in range(seeds):
        fit = fits(seed)
        std = np.sqrt(np.diag(fit.covariance_robust if robust else fit.covariance))
        half = stats.t.ppf(0.975, fit.freedom) * std
        inside.append((np.abs(fit.values - truth) <= half)[std > 0.0])
    return float(np.mean(inside))
