"""A run evaluated in blocks is the same run: parameters, covariance and residuals of the one-shot evaluation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.errors import HexciteError
from cases.loading import load_case
from identification import streaming
from identification.executed import PoseExecution
from identification.formats import parquet
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.recording import Recording, read_recording, write_recording
from identification.simulate import simulate_recording
from identification.streaming import identify_long
from tests.helpers import Harmonic, one_line
from tests.planner.command_line import call

CASE = load_case("hexapod")
RUN = simulate_recording(
    CASE, PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=4.0)), np.array([[0.2, 1.7], [2.0, 3.8]]), 0
)


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lengths that let a short run go through many blocks."""
    monkeypatch.setattr(streaming, "HEAD", 1000)
    monkeypatch.setattr(parquet, "_BATCH", 700)


def written(folder: Path, recording: Recording = RUN) -> Path:
    file = folder / "run.parquet"
    write_recording(file, recording, CASE)
    return file


@pytest.mark.parametrize("batch", [97, 700, 100_000])
def test_the_result_is_that_of_the_whole_run_at_once(
    batch: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a window in two parts, so that blocks, strides and gaps do not fit each other."""
    monkeypatch.setattr(parquet, "_BATCH", batch)
    file = written(tmp_path)
    whole, blocks = identify(read_recording(file, CASE), CASE), identify_long(file, CASE).estimate
    scale = np.linalg.norm(whole.values)
    assert np.linalg.norm(blocks.values - whole.values) < 1e-9 * scale
    np.testing.assert_allclose(blocks.covariance, whole.covariance, rtol=1e-6, atol=1e-9 * whole.covariance.max())
    assert blocks.s0 == pytest.approx(whole.s0, rel=1e-9)
    assert blocks.s0_N == pytest.approx(whole.s0_N, rel=1e-6)
    np.testing.assert_allclose(blocks.residual_rms, whole.residual_rms, rtol=1e-6)
    assert blocks.delay.value == pytest.approx(whole.delay.value, abs=1e-8)
    assert (blocks.samples, blocks.rank, blocks.freedom) == (whole.samples, whole.rank, pytest.approx(whole.freedom))


def test_robust_deviations_are_of_the_right_size(tmp_path: Path) -> None:
    estimate = identify_long(written(tmp_path), CASE).estimate
    ratio = np.sqrt(np.diag(estimate.covariance_robust) / np.diag(estimate.covariance))
    assert 0.5 < np.median(ratio) < 1.5  # white noise


def test_damage_is_named_with_its_rows_and_left_out(tmp_path: Path) -> None:
    forces = RUN.forces.copy()
    forces[1500, 2] = 3000.0
    estimate = identify_long(written(tmp_path, replace(RUN, forces=forces)), CASE).estimate
    assert any("row 1501: channel 3 jumps" in w for w in estimate.warnings)
    clean = identify_long(written(tmp_path), CASE).estimate
    assert np.abs((estimate.values - clean.values) / np.sqrt(np.diag(clean.covariance))).max() < 1.0


def gap(recording: Recording) -> Recording:
    t = recording.t.copy()
    t[2100:] += 0.005
    return replace(recording, t=t)


def jammed(recording: Recording) -> Recording:
    struts = recording.struts.copy()
    struts[2500:] = [0.3, 1.5, 0.3, 1.5, 0.3, 1.5]
    return replace(recording, struts=struts)


@pytest.mark.parametrize(
    ("recording", "says"),
    [
        (gap(RUN), r"row 2101, t_s: step of 6 ms"),
        (jammed(RUN), r"row 2[45]\d\d: no pose has the strut lengths"),
        (replace(RUN, trigger=np.zeros(len(RUN.t), dtype=bool)), "trigger: is never 1|independent|record"),
    ],
    ids=["gap", "struts", "trigger"],
)
def test_what_stops_a_run_is_named_with_its_row(recording: Recording, says: str, tmp_path: Path) -> None:
    with pytest.raises(HexciteError, match=says) as caught:
        identify_long(written(tmp_path, recording), CASE)
    assert "run.parquet" in one_line(caught.value)


def test_a_run_without_trigger_or_with_channel_weights_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    write_recording(file, RUN, CASE)
    file.write_text("\n".join(line.rsplit(",", 1)[0] for line in file.read_text().splitlines()))
    with pytest.raises(HexciteError, match=r"needs t_s, struts, forces and trigger in one file"):
        identify_long(file, CASE)
    weighted = CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update={"weights": "per_channel"})})
    with pytest.raises(HexciteError, match="channel weights need that"):
        identify_long(file, weighted)


def test_long_files_are_evaluated_in_blocks_from_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path)
    words = ("identify", file, "--case", "hexapod", "--json")
    short = call(*words, "-o", tmp_path / "short").json()
    monkeypatch.setattr(streaming, "LONG", 1000)
    long = call(*words, "-o", tmp_path / "long").json()
    assert long["linear"]["values"] == pytest.approx(short["linear"]["values"], rel=1e-5)
    assert any("evaluated in blocks" in w for w in long["warnings"])
