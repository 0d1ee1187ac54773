"""Runs simulated from Newton's law for point masses, fitted by least squares: spread and bias of each parameter."""

from dataclasses import dataclass

import numpy as np

from cases.schema import Case
from cases.sensors import RigidBody
from identification.evaluate import over_samples
from identification.model import identification_model
from identification.motion import Trajectory
from identification.parameters import physical_form
from identification.reference import reference_scaling
from planner.planning import predicted_std
from planner.problem import mean_information
from tests.identification.point_masses import PointMasses

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
    matrix = over_samples(model.coordinate_regressor, states.pose, states.rates, states.accelerations)[0]
    inverse = np.linalg.pinv(matrix.reshape(-1, 20))
    estimates = []
    for _ in range(runs):
        if acceleration_noise:
            noisy = states.accelerations + acceleration_noise * draw.normal(size=states.accelerations.shape)
            seen = over_samples(model.coordinate_regressor, states.pose, states.rates, noisy)[0]
            inverse = np.linalg.pinv(seen.reshape(-1, 20))
        measured = forces + force_noise * draw.normal(size=len(forces))
        estimates.append(form.of(inverse @ measured, np.zeros((20, 20)))[0])
    found = np.array(estimates)
    expected, _ = form.of(truth, np.zeros((20, 20)))
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, motion)
    predicted = predicted_std(case, model, scaling, information, len(inside) / RATE, force_noise)
    names = tuple(predicted)
    return Spread(names, np.array(list(predicted.values())), found.std(axis=0, ddof=1), found.mean(axis=0) - expected)
