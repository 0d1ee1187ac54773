"""The nearest body that can exist: one, and none that is nearer."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from cases.bounds import Bounds
from cases.schema import load_case
from cases.sensors import rigid_body
from identification.estimation.nearest_body import NearestBody, body_places, nearest_body, pseudo_inertia
from identification.identify import estimate_parameters, identify
from identification.model.model import Model, identification_model
from identification.model.parameters import nominal_parameters
from identification.recording.recording import read, write_recording
from tests.helpers import examples
from tests.mistaken.machines import run

SEEDS = st.integers(0, 2**31)
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@cache
def model(number: int = 6) -> Model:
    return identification_model(load_case("hexapod"), number)


def estimate(seed: int, number: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """An estimate whose inertia is often that of no body, and its covariance, full of correlations."""
    rng = np.random.default_rng(seed)
    size = len(model(number).names)
    u = nominal_parameters(model(number), load_case("hexapod").nominal)
    std = np.full(size, 0.3)
    std[:4] = 0.1, 0.02, 0.02, 0.02
    spread = rng.normal(size=(size, size)) / np.sqrt(size) * std[:, None]
    return u + 3.0 * spread @ rng.normal(size=size), spread @ spread.T


def principal(body: NearestBody) -> np.ndarray:
    """Principal moments of inertia about the centre of gravity."""
    inertia = np.zeros((3, 3))
    for i, j in PAIRS:
        inertia[i, j] = inertia[j, i] = body.parameters[f"IC{i + 1}{j + 1}"]
    return np.linalg.eigvalsh(inertia)


def eigenvalues(u: np.ndarray) -> np.ndarray:
    return np.linalg.eigvalsh(pseudo_inertia(u[body_places(model())]))


@settings(max_examples=examples(30))
@given(SEEDS)
def test_it_has_mass_and_keeps_the_triangle_inequalities(seed: int) -> None:
    u, covariance = estimate(seed)
    body = nearest_body(model(), u, covariance, covariance)
    small, middle, large = principal(body)
    assert body.parameters["m"] > 0.0
    assert small > 0.0
    assert small + middle >= large
    if eigenvalues(u)[0] >= 0.0:
        assert body.linear == tuple(u)
        assert (body.distance, body.p_at_most) == (0.0, 1.0)
    else:
        assert body.broken[0] == "inertia"
        off = np.array(body.linear) - u
        assert body.distance == pytest.approx(np.sqrt(off @ np.linalg.solve(covariance, off)), rel=1e-6)


def test_no_search_finds_a_nearer_one() -> None:
    """Against scipy, which minimises over bodies as J = L L^T."""
    found = 0
    for seed in range(12):
        u, covariance = estimate(seed)
        body = nearest_body(model(), u, covariance, covariance)
        if not body.moved:
            continue
        places = body_places(model())
        inverse = np.linalg.inv(covariance[np.ix_(places, places)])

        def far(entries: np.ndarray, at: np.ndarray = u[places], inverse: np.ndarray = inverse) -> float:
            root = np.zeros((4, 4))
            root[np.tril_indices(4)] = entries
            j = root @ root.T
            inertia = np.trace(j[:3, :3]) * np.eye(3) - j[:3, :3]
            off = np.r_[j[3, 3], j[:3, 3], [inertia[p] for p in PAIRS]] - at
            return float(off @ inverse @ off)

        start = np.linalg.cholesky(pseudo_inertia(np.array(body.linear)[places]) + 1e-3 * np.eye(4))
        least = minimize(far, start[np.tril_indices(4)], method="BFGS", options={"maxiter": 2000}).fun
        assert body.distance**2 <= least * (1.0 + 1e-3)
        assert body.distance**2 >= least * (1.0 - 2e-2)
        found += 1
    assert found >= 3


@settings(max_examples=examples(10))
@given(SEEDS)
def test_it_is_the_same_body_in_other_axes(seed: int) -> None:
    u, covariance = estimate(seed)
    places = body_places(model())
    turn = Rotation.random(random_state=seed).as_matrix()
    step = np.eye(len(u))
    for column, unit in zip(places, np.eye(10), strict=True):
        j = pseudo_inertia(unit)
        around = np.block([[turn, np.full((3, 1), 0.1)], [np.zeros((1, 3)), np.ones((1, 1))]])
        moved = around @ j @ around.T
        inertia = np.trace(moved[:3, :3]) * np.eye(3) - moved[:3, :3]
        step[places, column] = np.r_[moved[3, 3], moved[:3, 3], [inertia[p] for p in PAIRS]]
    here = nearest_body(model(), u, covariance, covariance)
    there = nearest_body(model(), step @ u, step @ covariance @ step.T, step @ covariance @ step.T)
    assert there.distance == pytest.approx(here.distance, rel=1e-4, abs=1e-4)
    scale = np.sqrt(np.diag(step @ covariance @ step.T))
    assert np.all(np.abs(step @ here.linear - there.linear) < 1e-3 * scale)


def test_half_of_flat_bodies_are_moved_and_the_chance_is_right() -> None:
    """A plate is on the boundary: of its estimates half are bodies, and p is uniform where it is not 1."""
    plate = rigid_body(30.0, np.array([0.01, 0.0, 0.05]), np.diag([0.6, 0.9, 1.5]))
    u = nominal_parameters(model(), plate)
    rng, size = np.random.default_rng(1), len(u)
    spread = rng.normal(size=(size, size)) * 1e-3
    covariance = spread @ spread.T
    chances = [
        nearest_body(model(), u + spread @ rng.normal(size=size), covariance, covariance).p_at_most for _ in range(400)
    ]
    assert np.mean(np.array(chances) == 1.0) == pytest.approx(0.5, abs=0.08)
    assert np.mean(np.array(chances) < 0.1) == pytest.approx(0.1, abs=0.05)


def test_bounds_hold_the_body_and_move_what_is_correlated() -> None:
    u, covariance = estimate(3, 0)
    mass = float(u[0])
    bounds = Bounds.model_validate({"mass_kg": (mass + 0.1, mass + 1.0)})
    body = nearest_body(model(0), u, covariance, covariance, bounds)
    expected = covariance[:, 0] / covariance[0, 0] * 0.1  # of a normal distribution, where its mass is 0.1 kg more
    assert body.broken == ("bounds.mass_kg",)
    assert body.distance == pytest.approx(0.1 / np.sqrt(covariance[0, 0]), rel=1e-4)
    assert np.allclose(np.array(body.linear) - u, expected, rtol=1e-3, atol=1e-5)


def test_a_body_lies_in_its_box() -> None:
    u, covariance = estimate(2)
    places = body_places(model())
    box = {"x_mm": (-150.0, 150.0), "y_mm": (-100.0, 100.0), "z_mm": (-50.0, 100.0)}
    body = nearest_body(model(), u, covariance, covariance, Bounds.model_validate({"body_mm": box}))
    j = pseudo_inertia(np.array(body.linear)[places])
    assert "bounds.body_mm" in body.broken
    for k, (low, high) in enumerate(np.array(list(box.values())) / 1e3):
        assert low < j[k, 3] / j[3, 3] < high
        assert (low + high) * j[k, 3] - j[k, k] - low * high * j[3, 3] > 0.0


def test_what_was_given_stays_and_can_leave_no_body() -> None:
    u, covariance = estimate(5)
    place = model().names.index("I11")
    u[place] = -1.0
    covariance[place], covariance[:, place] = 0.0, 0.0
    assert nearest_body(model(), u, covariance, covariance) is None
    u[place] = 3.0
    body = nearest_body(model(), u, covariance, covariance)
    assert body is not None
    assert body.linear[place] == pytest.approx(3.0, rel=1e-12)


def test_an_inertia_that_no_body_has_is_said_once_with_the_nearest_one(tmp_path: Path) -> None:
    """An inertia about z that is larger than those about x and y together, many deviations off."""
    sound = run("ur10_wrist", 0)
    motion, file = sound.motion, tmp_path / "run.csv"
    assert motion is not None
    omega, alpha = (np.einsum("nji,nj->ni", motion.turn, values) for values in (motion.omega, motion.alpha))
    more = np.diag([0.0, 0.0, 0.3])
    forces = sound.recording.forces.copy()
    forces[:, 3:] += alpha @ more + np.cross(omega, omega @ more)
    write_recording(file, replace(sound.recording, forces=forces), sound.case)
    result = identify(read(file, sound.case), sound.case)
    (said,) = (finding for finding in result.findings if "no body" in finding.sentence)
    assert said.severity == "warning"
    assert result.physical is not None
    assert f"{result.physical.distance:.2g} deviations off" in said.sentence
    assert "exports of the load take that one" in said.sentence
    assert "check signs" in said.sentence
    estimate = estimate_parameters(read(file, sound.case), sound.case)
    assert [warning for warning in estimate.warnings if "no body" in warning] != []
