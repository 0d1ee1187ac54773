"""Results in other frames: the same body and the same force, with deviations that count the sensor's place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cases.base.errors import CaseError, HexciteError
from cases.machine import Frame
from cases.schema import Case, load_case
from identification.machines.serial_chain import SerialChain
from identification.model.model import Model, identification_model
from identification.model.parameters import body_parameters, physical_form
from identification.results.frames import Body, Mounting, Place, moved_body, place_of

HEXAPOD, ARM = load_case("hexapod"), load_case("ur10_wrist")


def arm(**frames: Frame) -> Case:
    """The built-in arm with a sensor that is turned and away from the flange, and a tool."""
    assert ARM.machine is not None
    assert ARM.chain is not None
    own = {
        "sensor": Frame(origin_mm=(5.0, 0.0, 161.55), rpy_deg=(0.0, 10.0, 30.0)),
        "tcp": Frame(origin_mm=(0.0, 40.0, 250.0), rpy_deg=(0.0, 45.0, 0.0)),
    } | frames
    chain = ARM.chain.model_copy(update=own)
    return ARM.model_copy(update={"machine": ARM.machine.model_copy(update={"chain": chain})})


places = st.builds(
    lambda turn, origin: _place(Rotation.from_rotvec(turn).as_matrix(), origin),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.tuples(*[st.floats(-0.5, 0.5)] * 3),
)


def _place(turn: np.ndarray, origin: tuple[float, ...]) -> np.ndarray:
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turn, origin
    return place


def body_of(size: int, seed: int = 0) -> Body:
    """A body of the arm with a covariance, part of which tolerances make."""
    rng = np.random.default_rng(seed)
    model = identification_model(ARM, 6)
    assert ARM.nominal is not None
    values = np.array(list(body_parameters(ARM.nominal).values()))[:size]
    root = rng.normal(size=(size, size)) * 1e-3
    biases = {"sensor_deg": rng.normal(size=(size, 3)) * 1e-3, "gain_percent": rng.normal(size=(size, 6)) * 1e-3}
    robust = 2.0 * root @ root.T + sum(b @ b.T for b in biases.values())
    alone = Model(6, model.blocks[: 3 if size == 10 else 2], model.structure, model.gravity)
    return Body(place_of(ARM, "sensor"), alone, values, root @ root.T, robust, biases)


@given(places, st.sampled_from([4, 10]))
def test_there_and_back_changes_nothing(place: np.ndarray, size: int) -> None:
    body = body_of(size)
    there = body.seen_from(Place("tool", "another", place))
    back = there.seen_from(Place("sensor", "{P}", np.linalg.inv(place)))
    for own in ("values", "covariance", "covariance_robust"):
        before = getattr(body, own)
        np.testing.assert_allclose(getattr(back, own), before, atol=1e-9 * np.abs(before).max())
    for key, bias in body.biases.items():
        np.testing.assert_allclose(back.biases[key], bias, atol=1e-9)


@given(places)
def test_mass_and_principal_moments_depend_on_no_frame(place: np.ndarray) -> None:
    body = body_of(10)
    moments = []
    for seen in (body, body.seen_from(Place("tool", "another", place))):
        value = {name: v.value for name, v in seen.parameters.items()}
        xx, xy, xz, yy, yz, zz = (value[f"IC{k}"] for k in ("11", "12", "13", "22", "23", "33"))
        moments.append([value["m"], *np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])])
        np.testing.assert_allclose(seen.parameters["m"][:3], body.parameters["m"][:3], rtol=1e-9)
    np.testing.assert_allclose(moments[0], moments[1], rtol=1e-9, atol=1e-12)


@given(places)
def test_points_of_mass_are_where_they_are_in_every_frame(place: np.ndarray) -> None:
    """Independent of the map: a body of four points, whose sums are taken in the other frame."""
    rng = np.random.default_rng(1)
    points, masses = rng.normal(size=(4, 3)) * 0.2, np.array([0.5, 1.0, 0.3, 0.7])

    def sums(of: np.ndarray) -> np.ndarray:
        inertia = sum(m * ((p @ p) * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, of, strict=True))
        return np.r_[masses.sum(), masses @ of, np.asarray(inertia)[np.triu_indices(3)]]

    moved = points @ place[:3, :3].T + place[:3, 3]
    np.testing.assert_allclose(moved_body(place) @ sums(points), sums(moved), atol=1e-10)


@given(places)
def test_the_parts_of_a_budget_add_up_in_every_frame(place: np.ndarray) -> None:
    mounting = Mounting({"sensor_deg": np.vstack([np.zeros((3, 3)), 0.01 * np.eye(3)])})
    seen = body_of(10).seen_from(Place("flange", "another", place), mounting)
    for name, parts in seen.budget.items():
        assert np.sqrt(sum(v**2 for v in parts.values())) == pytest.approx(seen.parameters[name].reported, rel=1e-6)


@pytest.mark.first(1)
@pytest.mark.parametrize("size", [4, 10])
def test_deviations_count_where_the_sensor_may_sit(size: int) -> None:
    """By sampling: machines whose sensor sits elsewhere, read as if it sat where the case says."""
    rng = np.random.default_rng(2)
    body, flange = body_of(size), place_of(arm(), "flange")
    sizes = {"sensor_mm": np.eye(6)[:, :3] * 2e-4, "sensor_deg": np.eye(6)[:, 3:] * 2e-3}
    biases = {"sensor_mm": np.zeros((size, 3)), "sensor_deg": body.biases["sensor_deg"]}
    body = replace(
        body, biases=biases, covariance=0.0 * body.covariance, covariance_robust=sum(b @ b.T for b in biases.values())
    )
    seen = body.seen_from(flange, Mounting(sizes))
    errors = []
    for y in rng.normal(size=(4000, 6)):
        off = _place(Rotation.from_rotvec(2e-3 * y[3:]).as_matrix(), tuple(2e-4 * y[:3]))
        true = body.values  # in the frame of the sensor as it sits
        read = true + biases["sensor_deg"] @ y[3:]
        places = (flange.frame_from_sensor, flange.frame_from_sensor @ off)
        taken, actual = (moved_body(frame_from_sensor, size) for frame_from_sensor in places)
        errors.append(taken @ read - actual @ true)
    of_form = physical_form(seen.model).map(seen.values)[1].full()
    spread = np.std(np.array(errors) @ of_form.T, axis=0)
    promised = np.array([v.std_robust for v in seen.parameters.values()])
    large = promised > 1e-9
    np.testing.assert_allclose(spread[large], promised[large], rtol=0.06)


def test_a_wrench_has_the_same_power_in_every_frame() -> None:
    """Force and moment on a body that moves as a rigid one: power does not know frames."""
    case, rng = arm(), np.random.default_rng(3)
    wrench, motion = rng.normal(size=(5, 6)), rng.normal(size=(5, 6))  # velocity of the origin of {P}, turning
    for frame in ("flange", "tool"):
        place = place_of(case, frame)
        turn, origin = place.frame_from_sensor[:3, :3], place.frame_from_sensor[:3, 3]
        omega = motion[:, 3:] @ turn.T
        velocity = motion[:, :3] @ turn.T + np.cross(omega, -origin)
        power = np.sum((wrench @ place.map.T) * np.hstack([velocity, omega]), axis=1)
        np.testing.assert_allclose(power, np.sum(wrench * motion, axis=1), rtol=1e-12)


def test_base_axes_at_home_are_those_of_the_chain() -> None:
    case = arm()
    assert case.chain is not None
    still = np.zeros((1, 6))
    angles = SerialChain.of(case).kinematics(case.chain.home[None], still, still).pose[0, 3:]
    turn = place_of(case, "base").frame_from_sensor[:3, :3]
    np.testing.assert_allclose(turn, Rotation.from_euler("xyz", angles).as_matrix(), atol=1e-12)


def test_the_tool_lies_behind_the_flange() -> None:
    case = arm()
    assert case.tcp is not None
    there = case.tcp.parent_from_frame @ place_of(case, "tool").frame_from_sensor
    np.testing.assert_allclose(there, place_of(case, "flange").frame_from_sensor, atol=1e-12)


@pytest.mark.parametrize(
    ("case", "frame", "words"),
    [
        (HEXAPOD, "flange", "no robot"),
        (HEXAPOD, "tool", "no robot"),
        (ARM, "tool", "machine.chain.tcp"),
        (load_case("ft_wrist"), "base", "sensor, flange or tool"),
        (load_case("ft_wrist"), "flange", "sensor_frame.transducer.flange"),
        (load_case("five_axis_table"), "flange", "machine.chain.flange"),
    ],
)
def test_a_frame_that_a_case_does_not_have_is_refused(case: Case, frame: str, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        place_of(case, frame)


def test_an_unknown_frame_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(HexciteError, match="'tcp' is unknown"):
        place_of(ARM, "tcp")


def test_a_tool_without_a_flange_is_refused() -> None:
    with pytest.raises(ValueError, match="tcp lies in the flange"):
        type(ARM.chain)(**{**ARM.chain.model_dump(), "flange": None, "tcp": {"origin_mm": (0.0, 0.0, 1.0)}})


def test_stating_a_tool_leaves_plans_and_results_valid() -> None:
    from cases.basis import plan_basis, result_basis

    other = arm(sensor=ARM.chain.sensor)
    assert result_basis(other) == result_basis(ARM)
    assert plan_basis(other) == plan_basis(ARM)
