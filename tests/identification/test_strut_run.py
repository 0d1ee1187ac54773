"""Runs of a machine with sensors in its struts, simulated and identified; a weight on the platform is a force."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from cases.schema import Case, load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model, regressors
from identification.model.parameters import linear_parameters
from identification.simulate import loaded_truth, simulate_recording
from tests.helpers import HOME, Harmonic, seeds, tells
from tests.simulated_machine import PoseExecution, kinematics_of_coordinates
from tests.strut_plant import StrutPlant, Struts

CASE = load_case("strut_sensors")
MACHINE = Hexapod.of(CASE)


def of_kind(**changes: object) -> Case:
    """The case with other sensors in its struts."""
    assert CASE.sensor_frame.struts is not None
    struts = CASE.sensor_frame.struts.model_copy(update=changes)
    return CASE.model_copy(update={"sensor_frame": CASE.sensor_frame.model_copy(update={"struts": struts})})


KINDS = (
    {},
    {"at": "platform"},
    {"each": True},
    {"viscous_friction_Nms": (0.8, 0.5)},
)


@pytest.mark.first(1)
@pytest.mark.parametrize("changes", KINDS, ids=("drive", "platform", "each", "friction"))
@seeds(2, first=1)
def test_parameters_are_found_within_their_deviations(changes: dict[str, object], seed: int) -> None:
    case = of_kind(**changes)
    assert case.simulation is not None
    motion = Harmonic(seed=3, duration=6.0, size=0.8)
    recording = simulate_recording(case, PoseExecution(MACHINE, motion), np.array([[0.3, 5.7]]), seed)
    found = estimate_parameters(recording, case, 6)
    model = identification_model(case, 6)
    truth = linear_parameters(model, case.simulation.parameters)
    deviation = np.sqrt(np.maximum(np.diag(found.fit.covariance), np.diag(found.fit.covariance_robust)))
    assert np.abs((found.fit.values - truth) / deviation).max() < 4.0
    assert {"h", "k", "d"} <= {name.split("_")[0] for name in model.names}


@pytest.mark.repeats
def test_rods_that_the_sensors_carry_are_part_of_the_expected_mass() -> None:
    """Six rods of 6 kg weigh more than the platform, which is all that `nominal` describes."""
    case = CASE.model_copy(update={"payloads": None})
    motion = Harmonic(seed=3, duration=6.0, size=0.8)
    recording = simulate_recording(case, PoseExecution(MACHINE, motion), np.array([[0.3, 5.7]]), 1)
    assert not any("the mass comes out" in w for w in estimate_parameters(recording, case, 6).warnings)
    assert case.nominal is not None
    light = case.model_copy(update={"nominal": case.nominal.model_copy(update={"mass_kg": 10.0})})
    warnings = estimate_parameters(recording, light, 6).warnings
    assert any(tells(w, "nominal.mass_kg", "46 kg") for w in warnings), warnings


@pytest.mark.parametrize("at", ["drive", "platform"])
def test_mujoco_finds_the_same_forces_in_its_closed_loop(at: str) -> None:
    """Platform, tubes and rods connected by constraints: 1e-6 of the forces, in which the struts have their share."""
    case = of_kind(at=at).model_copy(update={"gravity_m_s2": (0.3, -0.2, -9.8)})
    sensors, simulation = case.sensor_frame.struts, case.simulation
    assert sensors is not None
    assert simulation is not None
    rod, tube = 0.55 * sensors.inertia_kg_m2, 0.45 * sensors.inertia_kg_m2  # of the two only the sum counts
    struts = Struts(sensors.rod_mass_kg, sensors.rod_first_moment_kg_m, rod, 9.0, sensors.tube_first_moment_kg_m, tube)
    plant = StrutPlant(MACHINE.base, MACHINE.platform, simulation.parameters.body, struts, at == "drive", case.gravity)
    motion = Harmonic(seed=6, size=0.8).at(np.linspace(0.0, 3.0, 60))
    model = identification_model(case, 6)
    moving = kinematics_of_coordinates(motion.coordinates, motion.rates, motion.accelerations)
    truth = simulation.parameters.model_copy(update={"offsets_N": (0.0,) * 6})
    expected = regressors(model, moving) @ linear_parameters(model, truth)
    for pose, rates, accelerations, forces in zip(
        motion.coordinates, motion.rates, motion.accelerations, expected, strict=True
    ):
        found, opened = plant.forces(pose, rates, accelerations)
        assert opened < 1e-12
        np.testing.assert_allclose(forces, found, rtol=0.0, atol=1e-6 * np.abs(found).max())


def test_a_weight_that_is_put_on_a_standing_platform_is_a_force_in_the_platform() -> None:
    """A body that a model does not know pushes with its weight, wherever and however the platform stands."""
    assert CASE.simulation is not None
    assert CASE.payloads is not None
    weight = CASE.payloads.weights[0]
    poses = HOME + np.random.default_rng(2).uniform(-1.0, 1.0, (10, 6)) * np.r_[[0.1] * 3, [0.2] * 3]
    still = np.zeros_like(poses)
    motion = MACHINE.kinematics(MACHINE.strut_lengths(poses), still, still)
    model = identification_model(CASE, 6)
    truth = CASE.simulation.parameters
    without, loaded = (linear_parameters(model, t) for t in (truth, loaded_truth(truth, (weight,))))
    left = regressors(model, motion) @ (loaded - without)
    wrench = -model.wrenches(left, poses)
    for pose, found in zip(poses, wrench, strict=True):
        force = weight.mass_kg * Rotation.from_euler("xyz", pose[3:]).as_matrix().T @ CASE.gravity
        expected = np.r_[force, np.cross(weight.centre_of_gravity, force)]
        np.testing.assert_allclose(found, expected, atol=1e-9 * weight.mass_kg * 9.81)


def test_a_standstill_tells_of_a_strut_only_the_difference_of_its_first_moments() -> None:
    names = identification_model(CASE, 0).names
    assert "d" in names
    assert not {"h", "k"} & set(names)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"setup": "1b"}, ("setup", "2x", "sensor_frame.struts")),
        (
            {"sensors": {"weights": "equal", "force_noise_N": 1.0, "acceleration_noise_m_s2": 0.1}},
            ("accelerations", "remove"),
        ),
        ({"machine": None, "limits": None, "workspace": None}, ("setup", "2x", "hexapod")),
    ],
)
def test_what_does_not_go_with_sensors_in_struts_is_named(table: dict[str, object], words: tuple[str, ...]) -> None:
    content = CASE.model_dump(mode="json", exclude_none=True) | table
    with pytest.raises(ValidationError) as error:
        Case.model_validate({key: value for key, value in content.items() if value is not None})
    assert all(word in str(error.value) for word in words)


def test_error_terms_of_a_platform_with_bars_are_refused() -> None:
    with pytest.raises(IdentificationError, match=r"model 9.*6"):
        identification_model(CASE, 9)


def test_forces_in_struts_are_a_wrench_at_a_known_pose_only() -> None:
    with pytest.raises(ValueError, match="poses"):
        identification_model(CASE, 6).wrenches(np.ones((2, 6)), None)
