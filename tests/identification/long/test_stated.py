"""What is known, left out or stated of a run gives in blocks what it gives of the whole run."""

from pathlib import Path

import numpy as np
import pytest

from cases.errors import HexciteError
from identification.estimation.estimators import Method, method
from identification.estimation.selection import symmetric_platform
from identification.identify import identify
from identification.long import total
from identification.long.streaming import identify_long
from identification.recording import read_recording
from tests.helpers import one_line
from tests.identification.long.long_runs import CASE, MODEL, written

STATED = CASE.model_copy(
    update={
        "sensors": CASE.sensors.model_copy(
            update={"force_noise_N": 1.0, "acceleration_noise_m_s2": 0.02, "angular_acceleration_noise_rad_s2": 0.1}
        )
    }
)


@pytest.mark.parametrize(
    ("how", "terms"),
    [
        (method(known={"m": 31.9, "xC": 0.0}), ()),
        (method(dropped=("k2", "k3", "I12")), ()),
        (method(known=symmetric_platform(MODEL), weights="per_channel"), ()),
        (method(weights="stated"), ()),
        (method(weights="stated", dropped=("k0", "k1")), ()),
        (method(), ("K2",)),
    ],
    ids=["fix", "drop", "symmetric, per_channel", "stated", "stated, drop", "terms"],
)
def test_what_is_known_left_out_or_stated_gives_what_the_whole_run_gives(
    how: Method, terms: tuple[str, ...], tmp_path: Path
) -> None:
    """Values and covariance, also of what follows from what was estimated; stated weights settle to 1e-4."""
    file = written(tmp_path)
    whole = identify(read_recording(file, STATED), STATED, 9, how, terms)
    long = identify_long(file, STATED, 9, how, terms).estimate
    std = np.sqrt(np.diag(whole.covariance))
    free = std > 0.0
    assert 6 < free.sum() <= len(std)
    assert np.abs((long.values - whole.values)[free] / std[free]).max() < 5e-3
    np.testing.assert_allclose(long.values[~free], whole.values[~free], rtol=1e-12)
    np.testing.assert_allclose(long.covariance, whole.covariance, rtol=1e-3, atol=1e-3 * np.outer(std, std).max())
    np.testing.assert_allclose(np.sqrt(np.diag(long.covariance))[free], std[free], rtol=1e-3)
    assert np.all(np.diag(long.covariance_robust)[~free] == 0.0)
    assert long.s0 == pytest.approx(whole.s0, rel=1e-3)
    assert (long.rank, long.freedom) == (whole.rank, pytest.approx(whole.freedom))
    assert long.condition == pytest.approx(whole.condition, rel=1e-2)
    assert long.physical.keys() == whole.physical.keys()
    np.testing.assert_allclose(long.w, whole.w, rtol=1e-3)


@pytest.mark.parametrize(("sampled", "share"), [(10_000, 1e-6), (30, 0.05)])
@pytest.mark.parametrize("weights", ["equal", "stated"])
def test_what_s0_consists_of_is_that_of_the_whole_run(
    weights: str, sampled: int, share: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of all samples to rounding, of some of each block to a few percent of itself."""
    monkeypatch.setattr(total, "SAMPLED", sampled)
    file = written(tmp_path)
    case = STATED.model_copy(update={"sensors": STATED.sensors.model_copy(update={"strut_noise_um": 0.2})})
    how = method(weights=weights)
    whole = identify(read_recording(file, case), case, 9, how)
    long = identify_long(file, case, 9, how).estimate
    assert whole.noise_sources is not None
    assert long.noise_sources is not None
    assert long.noise_sources.force_sensors == pytest.approx(whole.noise_sources.force_sensors, rel=1e-4)
    assert long.noise_sources.accelerations == pytest.approx(whole.noise_sources.accelerations, rel=1e-4 + share)
    assert long.noise_sources.acceleration_std == pytest.approx(whole.noise_sources.acceleration_std)
    assert whole.attenuation is not None
    assert long.attenuation is not None
    for name, expected in whole.attenuation.items():
        assert long.attenuation[name].bias == pytest.approx(
            expected.bias, rel=0.01 + 3 * share, abs=(1e-3 + share) * np.abs(expected.bias / expected.of_std)
        )
    assert [w for w in long.warnings if "noise" in w] == [w for w in whole.warnings if "noise" in w]
    for key, value in whole.told["noise_components"].items():
        assert long.told["noise_components"][key] == pytest.approx(value, rel=1e-3, abs=1e-6)


def test_a_known_value_that_the_model_does_not_have_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(HexciteError, match="'mass' is no parameter here; choose from m, ") as caught:
        identify_long(written(tmp_path), CASE, 9, method(known={"mass": 1.0}))
    assert "run.parquet" in one_line(caught.value)
