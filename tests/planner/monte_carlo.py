"""Runs simulated from Newton's law for point masses, fitted by least squares: spread and bias of each parameter."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.schema import Case
from cases.sensors import RigidBody
from identification.estimation.criteria import reference_scaling
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.motion.motion import Trajectory
from planner.noise import expected_noise, mean_information
from planner.plans.figures import noise_covariance, prediction_of
from planner.plans.prediction import Prediction
from tests.identification.point_masses import PointMasses, wrench_of_bars

RATE = 1000.0  # [1/s]


@dataclass(frozen=True)
class Spread:
    """Of each physical parameter: predicted and found standard deviation, and bias, all in its unit."""

    names: tuple[str, ...]
    predicted: np.ndarray
    found: np.ndarray
    bias: np.ndarray


def body_of(masses: PointMasses) -> RigidBody:
    """The rigid body that point masses make."""
    total = masses.masses.sum()
    centre = masses.masses @ masses.points / total
    arms = masses.points - centre
    inertia = sum(m * (a @ a * np.eye(3) - np.outer(a, a)) for m, a in zip(masses.masses, arms, strict=True))
    six = tuple(float(inertia[i, j]) for i in range(3) for j in range(i, 3))
    return RigidBody(mass_kg=float(total), centre_of_gravity_mm=tuple(centre * 1e3), inertia_kg_m2=six)


def vibrating(case: Case, force_noise: float, acceleration: float, angular: float, weights: str) -> Case:
    """The case with its noise stated."""
    noise: dict[str, Any] = {"acceleration_noise_m_s2": acceleration, "angular_acceleration_noise_rad_s2": angular}
    noise |= {"force_noise_N": force_noise, "weights": weights}
    return case.model_copy(update={"sensors": case.sensors.model_copy(update=noise)})


def shaken_forces(case: Case, masses: PointMasses, accelerations: np.ndarray) -> np.ndarray:
    """What bars carry of accelerations of the platform, shape (n, 6) [m/s^2, rad/s^2], by Newton for each mass."""
    linear, angular = accelerations[:, None, :3], accelerations[:, None, 3:]
    pulls = masses.masses[:, None] * (linear + np.cross(angular, masses.points))
    wrenches = np.hstack([pulls.sum(axis=1), np.cross(masses.points, pulls).sum(axis=1)])
    bars = np.array([wrench_of_bars(case.sensor_frame.bars, unit) for unit in np.eye(6)]).T
    return np.linalg.solve(bars, wrenches.T).T


def vibrating_runs(case: Case, motion: Trajectory, runs: int) -> Spread:
    """Runs of a machine that vibrates as its case states, fitted with the weights of the case.

    Args:
        case: with noise of forces and accelerations; its nominal body is replaced by the point masses.
        motion: at least three times differentiable.
        runs: how many.
    """
    masses = PointMasses.drawn(5)
    case = case.model_copy(update={"nominal": body_of(masses)})
    case.__dict__.pop("bodies", None)  # kept from before the copy
    model, scaling = identification_model(case, 9), reference_scaling(case, identification_model(case, 9))
    noise = expected_noise(case, model)
    states = motion.at((np.arange(int(motion.duration * RATE)) + 0.5) / RATE)
    matrices = over_samples(model.coordinate_regressor, states.coordinates, states.rates, states.accelerations)[0]
    root = np.eye(6) if noise.whitening is None else noise.whitening
    inverse = np.linalg.pinv((root @ matrices).reshape(-1, 20))
    truth = np.array([masses.parameters.get(name, 0.0) for name in model.names])
    form, draw, estimates = physical_form(model), np.random.default_rng(0), []
    for _ in range(runs):
        shaken = shaken_forces(case, masses, case.sensors.acceleration_noise * draw.normal(size=(len(states.t), 6)))
        forces = matrices @ truth + shaken + case.sensors.force_noise * draw.normal(size=shaken.shape)
        estimates.append(form.of(inverse @ (forces @ root.T).ravel(), np.zeros((20, 20)))[0])
    predicted = prediction_of(case, model, scaling, motion, noise, 0).std
    found, expected = np.array(estimates), form.of(truth, np.zeros((20, 20)))[0]
    bias = found.mean(axis=0) - expected
    return Spread(tuple(predicted), np.array(list(predicted.values())), found.std(axis=0, ddof=1), bias)


def monte_carlo(case: Case, motion: Trajectory, runs: int, force_noise: float, acceleration_noise: float) -> Spread:
    """Simulates and fits runs of a smooth motion with model 9; offsets and compensation are truly zero.

    Args:
        case: frame and gravity; its nominal body is replaced by the point masses.
        motion: at least three times differentiable.
        runs: how many.
        force_noise: white, in each sensor [N].
        acceleration_noise: white, in the accelerations that the fit is given [m/s^2, rad/s^2].
    """
    masses = PointMasses.drawn(5)
    body = body_of(masses)
    case = case.model_copy(update={"nominal": body})
    case.__dict__.pop("bodies", None)  # kept from before the copy
    model = identification_model(case, 9)
    t = (np.arange(int(motion.duration * RATE)) + 0.5) / RATE
    inside = t[(t > 0.02) & (t < motion.duration - 0.02)]  # the differences look 15 ms to both sides
    wrenches = np.array([masses.wrench(motion, at, case.gravity) for at in inside])
    forces = np.linalg.solve(model.structure, wrenches.T).T.ravel()
    states = motion.at(inside)
    truth = np.array([masses.parameters.get(name, 0.0) for name in model.names])
    form, draw = physical_form(model), np.random.default_rng(0)
    matrix = over_samples(model.coordinate_regressor, states.coordinates, states.rates, states.accelerations)[0]
    inverse = np.linalg.pinv(matrix.reshape(-1, 20))
    estimates = []
    for _ in range(runs):
        if acceleration_noise:
            noisy = states.accelerations + acceleration_noise * draw.normal(size=states.accelerations.shape)
            seen = over_samples(model.coordinate_regressor, states.coordinates, states.rates, noisy)[0]
            inverse = np.linalg.pinv(seen.reshape(-1, 20))
        measured = forces + force_noise * draw.normal(size=len(forces))
        estimates.append(form.of(inverse @ measured, np.zeros((20, 20)))[0])
    found = np.array(estimates)
    expected, _ = form.of(truth, np.zeros((20, 20)))
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, motion)
    covariance = noise_covariance(case, scaling, information, len(inside) / RATE, force_noise)
    predicted = Prediction(model, truth, covariance).std
    names = tuple(predicted)
    return Spread(names, np.array(list(predicted.values())), found.std(axis=0, ddof=1), found.mean(axis=0) - expected)
