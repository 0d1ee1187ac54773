"""The JSON export: described, versioned, and enough to compute external forces from nothing else."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.schema import load_case
from identification.model.model import identification_model
from postprocessors.export import calibration as module
from postprocessors.export.calibration import json_document
from tests.postprocessors.export.calibrations import calibration, with_drives
from tests.postprocessors.export.physics import external, states

SCHEMA = json.loads(Path(module.__file__).with_name("calibration.schema.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("name", "number"), [("hexapod", 9), ("hexapod", 4), ("ft_wrist", 6)])
def test_external_forces_follow_from_the_file_alone(name: str, number: int, tmp_path: Path) -> None:
    data = json.loads(json_document(calibration(tmp_path, name, number)))
    case = load_case(name)
    s = states(case, 20, 1)
    rotations = Rotation.from_euler("xyz", s.pose[:, 3:]).as_matrix()
    matrices = identification_model(case, data["model"]).matrices(s.pose[:, :3], rotations, s.twist, s.twist_rate)
    u = [p["value"] for p in data["linear"]]
    found = -(s.forces - matrices @ u) @ np.array(data["structure"]).T
    values = {p["name"]: p["value"] for p in data["linear"]}
    expected = [external(case, values, *state) for state in zip(s.pose, s.twist, s.twist_rate, s.forces, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_struts_follow_from_the_file_alone(tmp_path: Path) -> None:
    data = json.loads(json_document(calibration(tmp_path, "hexapod", 9)))["kinematics"]
    s = states(load_case("hexapod"), 5, 2)
    for pose, lengths in zip(s.pose, s.lengths, strict=True):
        turn = Rotation.from_euler("xyz", pose[3:]).as_matrix()
        ends = pose[:3] + np.array(data["platform_m"]) @ turn.T
        np.testing.assert_allclose(np.linalg.norm(ends - data["base_m"], axis=1), lengths, rtol=1e-14)


@pytest.mark.parametrize(("name", "number"), [("hexapod", 9), ("ft_wrist", 6), ("strut_sensors", 6), ("ur10_wrist", 6)])
def test_what_is_written_is_what_the_schema_beside_the_code_says(name: str, number: int, tmp_path: Path) -> None:
    data = json.loads(json_document(with_drives(calibration(tmp_path, name, number))))
    jsonschema.validate(data, SCHEMA)
    assert set(data) == set(SCHEMA["properties"])
    for damage in ({"schema_version": 2}, {"model": 11}, {"gravity_m_s2": [1.0]}, {"more": 1}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(data | damage, SCHEMA)


def test_the_load_stands_in_the_frame_of_the_flange_too(tmp_path: Path) -> None:
    data = json.loads(json_document(calibration(tmp_path, "ur10_wrist", 6)))
    physical = {p["name"]: p["value"] for p in data["physical"]}
    load = data["flange"]["load"]
    assert load["mass_kg"] == physical["m"]
    assert load["centre_of_gravity_m"] == pytest.approx([physical[f"{c}C"] for c in "xyz"])
    assert data["flange"]["sensor"]["axes"] == np.eye(3).tolist()
    assert json.loads(json_document(calibration(tmp_path / "h", "hexapod", 9)))["flange"] is None


def test_physical_values_are_those_of_the_linear_ones(tmp_path: Path) -> None:
    data = json.loads(json_document(calibration(tmp_path, "hexapod", 9)))
    linear = {p["name"]: p["value"] for p in data["linear"]}
    physical = {p["name"]: p["value"] for p in data["physical"]}
    assert physical["zC"] == pytest.approx(linear["mzC"] / linear["m"], rel=1e-14)
    steiner = linear["m"] * (physical["yC"] ** 2 + physical["zC"] ** 2)
    assert physical["IC11"] == pytest.approx(linear["I11"] - steiner, rel=1e-9)


def test_the_structure_of_sensors_in_struts_follows_from_the_file_by_virtual_work(tmp_path: Path) -> None:
    """J^-T, transposed, turns the platform's twist in its own axes into strut velocities."""
    data = json.loads(json_document(calibration(tmp_path, "strut_sensors", 6)))
    assert (data["structure"], data["struts"]) == (None, {"at": "drive"})
    assert {"h", "k", "d"} <= {p["name"] for p in data["linear"]}
    base, platform = (np.array(data["kinematics"][name]) for name in ("base_m", "platform_m"))
    s = states(load_case("strut_sensors"), 10, 3)
    for pose, twist, velocities in zip(s.pose, s.twist, s.velocities, strict=True):
        turn = Rotation.from_euler("xyz", pose[3:]).as_matrix()
        struts = pose[:3] + platform @ turn.T - base
        along = struts / np.linalg.norm(struts, axis=1)[:, None] @ turn
        structure = np.vstack([along.T, np.cross(platform, along).T])
        np.testing.assert_allclose(structure.T @ np.r_[turn.T @ twist[:3], turn.T @ twist[3:]], velocities, rtol=1e-12)
