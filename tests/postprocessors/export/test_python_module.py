"""The exported Python says what (1)-(15) say, as the exported C does, and refuses what is no number."""

from pathlib import Path

import numpy as np
import pytest

from cases.schema import load_case
from tests.postprocessors.export.calibrations import calibration, with_drives
from tests.postprocessors.export.physics import external, states
from tests.postprocessors.export.test_joints import module_of

ROUNDING = 1e-11


@pytest.mark.parametrize("number", [0, 4, 9])
def test_the_model_is_the_papers_from_struts_and_from_poses(number: int, tmp_path: Path) -> None:
    case, made = load_case("hexapod"), calibration(tmp_path, "hexapod", number)
    u = dict(zip(made.model.names, made.values, strict=True))
    module, s = module_of(made, tmp_path), states(case, 20, number)
    for k in range(len(s.pose)):
        expected = external(case, u, s.pose[k], s.twist[k], s.twist_rate[k], s.forces[k])
        scale = max(np.abs(expected).max(), np.abs(s.forces[k]).max())
        model = module.Model()
        posed = model.from_pose(s.pose[k], s.rates[k], s.accelerations[k], s.forces[k])
        assert np.abs(posed - expected).max() <= ROUNDING * scale
        model = module.Model()  # from home
        strutted = model.from_struts(s.lengths[k], s.velocities[k], s.strut_accelerations[k], s.forces[k])
        assert np.abs(strutted - expected).max() <= ROUNDING * scale
        np.testing.assert_allclose(model.pose, s.pose[k], atol=1e-9)


def test_a_tare_moves_the_offsets_by_the_mean_residual(tmp_path: Path) -> None:
    made = calibration(tmp_path, "ft_wrist", 6)
    model = module_of(made, tmp_path).Model()
    pose, still, drift = np.zeros(6), np.zeros(6), np.array([1.0, -2.0, 3.0, 0.1, 0.2, -0.3])
    at_rest = np.zeros(6)
    model.from_pose(pose, still, still, at_rest)
    fitting = at_rest - model.residuals  # what the sensor reads without contact
    model.from_pose(pose, still, still, fitting + drift)
    np.testing.assert_allclose(model.residuals, drift, atol=1e-9)
    model.tare([model.residuals, model.residuals])
    np.testing.assert_allclose(model.from_pose(pose, still, still, fitting + drift), 0.0, atol=1e-9)


def test_struts_follow_from_drives_as_the_case_states(tmp_path: Path) -> None:
    module = module_of(with_drives(calibration(tmp_path, "hexapod", 9)), tmp_path)
    expected = [2.0 + 0.5, -1.0 + 0.51, 3.0 + 0.52, 6.0 + 0.53, -5.0 + 0.54, -4.0 + 0.55]
    np.testing.assert_allclose(module.struts_of_drives(np.arange(1.0, 7.0)), expected, rtol=1e-15)
    np.testing.assert_array_equal(module.struts_of_drives(np.arange(1.0, 7.0), 1), [2.0, -1.0, 3.0, 6.0, -5.0, -4.0])


@pytest.mark.parametrize("bad", [[0.0] * 5, [0.0] * 5 + [np.nan], [0.0] * 7, [np.inf] + [0.0] * 5])
def test_what_is_no_number_is_refused(bad: list[float], tmp_path: Path) -> None:
    module = module_of(calibration(tmp_path, "hexapod", 9), tmp_path)
    with pytest.raises(ValueError, match="expected 6 finite numbers"):
        module.Model().from_pose(bad, [0.0] * 6, [0.0] * 6, [0.0] * 6)
    with pytest.raises(ValueError, match="no pose has these strut lengths"):
        module.Model().from_struts([0.001] * 6, [0.0] * 6, [0.0] * 6, [0.0] * 6)
    signals = module.Signals(0.001, 0.01, 0.0)
    for _ in range(30):
        signals.push([0.0] * 6, [0.0] * 6)
    with pytest.raises(ValueError, match="finite numbers"):
        signals.push([np.nan] * 6, [0.0] * 6)
    assert signals.push([0.0] * 6, [0.0] * 6) is None  # what follows does not join on to what was
    with pytest.raises(ValueError, match="step must be positive"):
        module.Signals(0.0)
