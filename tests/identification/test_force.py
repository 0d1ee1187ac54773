"""The calibrated model in use: no contact reads zero, contact reads itself, a tare moves offsets and nothing else."""

import json
from dataclasses import replace
from functools import reduce
from operator import getitem
from pathlib import Path

import numpy as np
import pytest

from cases.errors import FileProblem, HexciteError, IdentificationError
from cases.files import json_text
from cases.loading import load_case
from identification.external import external_force, payload_between, require_two, tare
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.motion import Standstill
from identification.recording import Recording
from identification.runs.preparation import moving_run
from identification.saved_result import SavedResult, load_result, with_tare
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, one_line
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)


def recorded(seed: int = 0, motion_seed: int = 0) -> Recording:
    execution = PoseExecution(HEXAPOD, Harmonic(seed=motion_seed, duration=4.0))
    return simulate_recording(CASE, execution, np.array([[0.3, 3.7]]), seed, "run.csv")


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> SavedResult:
    file = tmp_path_factory.mktemp("result") / "result.json"
    file.write_text(json_text(identify(recorded(), CASE).to_json()))
    return load_result(file)


def standing(samples: int = 400, shift: float = 0.0) -> Recording:
    execution = PoseExecution(HEXAPOD, Standstill(np.add(HOME, [0.05, 0.1, 0.0, 0.1, -0.1, 0.05]), 1.0))
    run = simulate_recording(CASE, execution, np.zeros((0, 2)), 3, "still.csv")
    return replace(
        run, forces=run.forces[:samples] + shift, t=run.t[:samples], struts=run.struts[:samples], trigger=None
    )


def test_without_contact_the_external_force_of_another_motion_is_noise(saved: SavedResult) -> None:
    found = external_force(recorded(9, 5), CASE, saved, whole=False)
    run = moving_run(recorded(9, 5), CASE, saved.model_of(CASE))
    noise = np.sqrt(run.filter.noise_gain) * np.linalg.norm(CASE.sensor_frame.structure, axis=1)  # of 1 N a sensor
    assert np.all(found.rms < 1.3 * noise)
    assert np.all(found.rms > 0.7 * noise)


@pytest.mark.parametrize("axis", range(6))
def test_a_force_that_acts_on_the_platform_is_read_with_its_sign(axis: int, saved: SavedResult) -> None:
    """A load w on the platform is carried by the bars: J^-T times what they read more is -w (quasi-static, g = 0)."""
    wrench = 20.0 * np.eye(6)[axis]
    touched = recorded(2)
    touched = replace(touched, forces=touched.forces - np.linalg.solve(CASE.sensor_frame.structure, wrench))
    found = external_force(touched, CASE, saved, whole=False)
    np.testing.assert_allclose(found.wrench.mean(axis=0), wrench, atol=0.15)


def test_weight_is_an_external_force_downwards(saved: SavedResult) -> None:
    """A body of 1 kg more than the parameters know pulls with 9.81 N along gravity."""
    heavier = replace(saved, values=saved.values - np.eye(20)[0])  # the parameters know 1 kg less
    still = standing()
    found = external_force(replace(still, t=None), CASE, heavier)
    run = HEXAPOD.poses(still.struts[:1])[0]
    from scipy.spatial.transform import Rotation

    expected = Rotation.from_euler("xyz", run[3:]).as_matrix().T @ [0.0, 0.0, -9.81]
    np.testing.assert_allclose(found.wrench[:, :3].mean(axis=0), expected, atol=0.3)


def test_a_tare_moves_the_offsets_by_the_drift_and_nothing_else(saved: SavedResult) -> None:
    base, drifted = (tare(standing(shift=s), CASE, saved) for s in (0.0, 2.5))
    names = saved.model_of(CASE).names
    moved = np.array([n.startswith("f_q0") for n in names])
    np.testing.assert_allclose((drifted.values - base.values)[moved], 2.5, atol=1e-9)
    np.testing.assert_array_equal(drifted.values[~moved], saved.values[~moved])
    np.testing.assert_allclose(drifted.std, 1.0 / np.sqrt(400), rtol=0.2)  # white noise of 1 N


def test_a_tared_result_is_a_result(saved: SavedResult, tmp_path: Path) -> None:
    found = tare(standing(shift=2.5), CASE, saved)
    content = with_tare(saved, CASE, found.values, found.covariance, "still.csv")
    (tmp_path / "result.json").write_text(json_text(content))
    again = load_result(tmp_path)
    np.testing.assert_allclose(again.values, found.values)
    assert content["parameters"]["f_q0_1"]["value"] == pytest.approx(
        found.values[again.model_of(CASE).names.index("f_q0_1")]
    )


def test_a_tare_in_motion_is_refused(saved: SavedResult) -> None:
    with pytest.raises(IdentificationError, match=r"run.csv: struts move by .* mm, at most 0.1 mm"):
        tare(recorded(), CASE, saved)


def added(saved: SavedResult, body: np.ndarray) -> SavedResult:
    return replace(saved, values=saved.values + np.r_[body, np.zeros(10)], source="after")


def test_the_payload_is_the_body_that_was_added(saved: SavedResult) -> None:
    """20 kg at (10, 20, 180) mm, with its inertia carried to the origin by Steiner."""
    m, c, inertia = 20.0, np.array([0.01, 0.02, 0.18]), np.diag([0.2, 0.25, 0.15])
    about_origin = inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
    body = np.r_[m, m * c, about_origin[np.triu_indices(3)]]
    model = saved.model_of(CASE)
    found, _ = payload_between(saved, added(saved, body), model, model)
    got = [found[n].value for n in ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")]
    np.testing.assert_allclose(got, [20.0, 0.01, 0.02, 0.18, 0.2, 0.25, 0.15], rtol=1e-9)
    assert found["m"].std == pytest.approx(np.sqrt(2 * saved.covariance[0, 0]))


def test_one_recording_is_not_taken_for_two(saved: SavedResult) -> None:
    with pytest.raises(IdentificationError, match="is named twice; name the result without") as caught:
        require_two(saved, saved)
    one_line(caught.value)
    copied = replace(saved, source="copy/result.json", recordings=frozenset({"5e6f"}))
    with pytest.raises(IdentificationError, match="is of the same recording as") as caught:
        require_two(replace(saved, recordings=frozenset({"5e6f"})), copied)
    one_line(caught.value)
    require_two(saved, replace(saved, source="after", recordings=frozenset({"7a8b"})))


def test_no_payload_is_no_payload(saved: SavedResult) -> None:
    model = saved.model_of(CASE)
    with pytest.raises(IdentificationError, match="not by a payload"):
        payload_between(saved, replace(saved, source="after"), model, model)


def test_results_of_different_models_are_compared_with_a_warning(saved: SavedResult) -> None:
    from identification.model import identification_model

    body = added(saved, np.r_[5.0, np.zeros(9)])
    static = replace(saved, model=7, values=saved.values[:18], covariance=saved.covariance[:18, :18])
    _, warnings = payload_between(static, body, identification_model(CASE, 7), body.model_of(CASE))
    assert any("models 7 and 9 differ" in w for w in warnings)


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        ({"schema_version": 99}, "schema_version 99"),
        ({"linear": {}}, "'values' is missing"),
        ({"covariance": [[1.0]]}, "do not belong together"),
        ({"delay_s": "late"}, "missing or damaged"),
    ],
)
def test_a_damaged_result_is_named(damage: dict[str, object], says: str, saved: SavedResult, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    file.write_text(json.dumps(json.loads(Path(saved.source).read_text()) | damage))
    with pytest.raises(FileProblem, match=says) as caught:
        load_result(file)
    assert "\n" not in str(caught.value)


def test_parameters_of_another_case_are_refused(saved: SavedResult) -> None:
    with pytest.raises(HexciteError, match="parameters of case hexapod, not ft_wrist"):
        saved.model_of(load_case("ft_wrist"))


@pytest.mark.parametrize(
    ("place", "name"),
    [(("parameters", "m", "value"), "m"), (("parameters", "IC11", "std"), "IC11"), (("linear", "values", 0), "m"),
     (("covariance", 0, 0), "m")],
)  # fmt: skip
def test_a_number_changed_by_hand_is_noticed(place: tuple, name: str, saved: SavedResult, tmp_path: Path) -> None:
    data = json.loads(Path(saved.source).read_text())
    *above, last = place
    entry = reduce(getitem, above, data)
    entry[last] *= 1.001
    file = tmp_path / "result.json"
    file.write_text(json.dumps(data))
    with pytest.raises(FileProblem, match=rf"result.json: (value|std) of {name} is .* by the linear .*identify again"):
        load_result(file).require_own_parameters(CASE)
