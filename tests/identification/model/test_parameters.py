"""Linear and physical parameters are two views of one body."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.schema import load_case
from cases.sensors import Compensation, RigidBody, Truth
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from tests.helpers import seeds
from tests.identification.point_masses import PointMasses

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
FORM = physical_form(MODEL)
INERTIA = ("11", "12", "13", "22", "23", "33")
FACTORS = Compensation(k0_N_m=24.0, k1_Nm_m=-8.5, k2_N=37.0, k3_Nm=28.0)
OFFSETS = (-54.0, 41.0, 328.0, -137.0, -14.0, -20.0)


def physical(linear: np.ndarray) -> dict[str, float]:
    values = FORM.of(linear, np.eye(20))[0]
    return {p.name: v for p, v in zip(FORM.parameters, values, strict=True)}


def rigid_body(masses: PointMasses) -> RigidBody:
    """Mass, centre of gravity and inertia about it, from the masses as seen from their centre of gravity."""
    mass = masses.masses.sum()
    centre = masses.masses @ masses.points / mass
    about_centre = PointMasses(masses.masses, masses.points - centre).parameters
    inertia = tuple(float(about_centre[f"I{ij}"]) for ij in INERTIA)
    return RigidBody(mass_kg=float(mass), centre_of_gravity_mm=tuple(map(float, 1e3 * centre)), inertia_kg_m2=inertia)


@seeds(5)
def test_parallel_axis_theorem_holds_for_point_masses(seed: int) -> None:
    """From the origin of {P} to the centre of gravity and back, against the sums over the masses seen from either."""
    masses = PointMasses.drawn(seed)
    body = rigid_body(masses)
    truth = Truth(body=body, offsets_N=OFFSETS, compensation=FACTORS)
    linear = dict(zip(MODEL.names, linear_parameters(MODEL, truth), strict=True))
    for name, value in masses.parameters.items():
        assert linear[name] == pytest.approx(value, rel=1e-12, abs=1e-12)
    found = physical(np.array(list(linear.values())))
    for ij, value in zip(INERTIA, body.inertia_kg_m2, strict=True):
        assert found[f"IC{ij}"] == pytest.approx(value, abs=1e-12)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(4, 12))
def test_physical_parameters_survive_the_way_through_the_linear_ones(seed: int, count: int) -> None:
    body = rigid_body(PointMasses.drawn(seed, count))
    found = physical(linear_parameters(MODEL, Truth(body=body, offsets_N=OFFSETS, compensation=FACTORS)))
    expected = [body.mass_kg, *body.centre_of_gravity, *body.inertia_kg_m2, *OFFSETS, 24.0, -8.5, 37.0, 28.0]
    np.testing.assert_allclose(list(found.values()), expected, rtol=1e-10, atol=1e-10)


def test_covariance_is_propagated_as_a_cloud_of_estimates_spreads() -> None:
    """Monte Carlo with 4000 draws, whose standard deviations scatter by 1.1 % and correlations by 0.016."""
    draw = np.random.default_rng(0)
    linear = linear_parameters(MODEL, CASE.simulation.parameters)
    root = draw.normal(size=(20, 20)) * (1e-4 * np.maximum(np.abs(linear), 0.5))[:, None]
    cloud = linear + draw.normal(size=(4000, 20)) @ root.T
    spread = np.cov([FORM.of(u, np.eye(20))[0] for u in cloud], rowvar=False)
    covariance = FORM.of(linear, root @ root.T)[1]
    std, found = np.sqrt(np.diag(covariance)), np.sqrt(np.diag(spread))
    np.testing.assert_allclose(found, std, rtol=0.05)
    np.testing.assert_allclose(spread / np.outer(found, found), covariance / np.outer(std, std), atol=0.06)


@pytest.mark.parametrize("number", range(10))
def test_every_model_has_a_physical_form_that_starts_with_mass_and_centre_of_gravity(number: int) -> None:
    model = identification_model(CASE, number)
    form = physical_form(model)
    linear = np.random.default_rng(number).uniform(1.0, 2.0, len(model.names))
    names = [p.name for p in form.parameters]
    assert names[:4] == ["m", "xC", "yC", "zC"]
    assert [p.unit for p in form.parameters[:4]] == ["kg", "m", "m", "m"]
    values = form.of(linear, np.eye(len(linear)))[0]
    np.testing.assert_allclose(values[:4], np.r_[linear[0], linear[1:4] / linear[0]])
    unchanged = [n for n in names if n in model.names]
    assert len(names) == len(model.names)
    np.testing.assert_array_equal(
        [values[names.index(n)] for n in unchanged], [linear[model.names.index(n)] for n in unchanged]
    )


def test_factors_that_the_simulated_machine_has_no_values_for_are_refused() -> None:
    with pytest.raises(KeyError, match="K1_1x"):
        linear_parameters(identification_model(CASE, 1), CASE.simulation.parameters)
