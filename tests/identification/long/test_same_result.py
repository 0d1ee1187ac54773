"""A run evaluated in blocks is the same run: parameters, covariance and residuals of the one-shot evaluation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from cases.errors import HexciteError
from cases.schema import Case
from identification.formats import parquet
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.long import blocks
from identification.long.blocks import Blocks, fits_blocks
from identification.long.streaming import identify_long
from identification.recording import read_recording
from identification.runs.rates import on_one_clock
from identification.signals import Filter
from identification.simulate import simulate_recording
from tests.identification.leaping import moves_without_jerk_limit
from tests.identification.long.long_runs import CASE, MODEL, RUN, assert_same, with_columns, written


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


def with_weights(weights: str) -> Case:
    return CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update={"weights": weights})})


@pytest.mark.parametrize("weights", ["per_channel", "per_unit"])
def test_weights_are_those_of_the_whole_run(weights: str, tmp_path: Path) -> None:
    loud = replace(RUN, forces=RUN.forces + 3.0 * np.random.default_rng(1).normal(size=(len(RUN.t), 1)) * np.eye(6)[1])
    file, case = written(tmp_path, loud), with_weights(weights)
    whole, long = identify(read_recording(file, case), case), identify_long(file, case).estimate
    np.testing.assert_allclose(long.w, whole.w, rtol=2e-4)
    assert long.s0 == pytest.approx(1.0, abs=1e-3)
    assert_same(long, whole, share=1e-3)


def without_trigger(folder: Path) -> Path:
    file = written(folder)
    pq.write_table(pq.read_table(file).drop_columns(["trigger"]), file)
    return file


def test_without_a_trigger_the_window_is_the_motion_as_in_a_whole_run(tmp_path: Path) -> None:
    file = without_trigger(tmp_path)
    assert_same(identify_long(file, CASE).estimate, identify(read_recording(file, CASE), CASE))


def test_poses_stand_for_struts_as_in_a_whole_run(tmp_path: Path) -> None:
    file, hexapod = written(tmp_path), Hexapod.of(CASE)
    poses = hexapod.poses(RUN.struts)
    columns = dict(zip(("x_mm", "y_mm", "z_mm"), 1e3 * poses[:, :3].T, strict=True))
    columns |= dict(zip(("a_deg", "b_deg", "c_deg"), np.degrees(poses[:, 3:]).T, strict=True))
    with_columns(file, columns, "l")
    whole = identify(on_one_clock(read_recording(file, CASE), CASE), CASE)
    long = identify_long(file, CASE).estimate
    assert fits_blocks(file, CASE)
    assert np.linalg.norm(long.values - whole.values) < 1e-9 * np.linalg.norm(whole.values)


def test_missing_channels_are_refused(tmp_path: Path) -> None:
    file = written(tmp_path)
    turns = np.tile(np.eye(3).ravel(), (len(RUN.forces), 1)).T
    with_columns(file, {f"r{k // 3 + 1}{k % 3 + 1}": column for k, column in enumerate(turns)}, "l")
    assert not fits_blocks(file, CASE)  # the command line reads it at once
    with pytest.raises(HexciteError, match="needs t_s, struts or poses, and forces in one file"):
        identify_long(file, CASE)


def test_small_pieces_of_a_file_are_put_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of tables with hundreds of columns, of which a batch holds few rows."""
    monkeypatch.setattr(parquet, "_BATCH", 97)
    monkeypatch.setattr(blocks, "LEAST", 1000)
    file = written(tmp_path)
    sizes = [len(run.recording.forces) for run in Blocks(file, CASE).runs(MODEL, Filter(40.0, 1e-3))]
    assert max(sizes) < 2000
    assert len(sizes) == -(-len(RUN.forces) // (11 * 97))
    whole, long = identify(read_recording(file, CASE), CASE), identify_long(file, CASE).estimate
    assert np.linalg.norm(long.values - whole.values) < 1e-9 * np.linalg.norm(whole.values)


def test_the_smoothing_of_forces_that_leap_is_that_of_the_whole_run(tmp_path: Path) -> None:
    """Columns of delay and smoothing belong to slightly other parameters: equal to a thousandth, not to rounding."""
    execution = moves_without_jerk_limit(0)
    window = np.array([[0.25, execution.duration - 0.25]])
    quiet = CASE.model_copy(update={"simulation": CASE.simulation.model_copy(update={"force_noise_N": 0.2})})
    file = written(tmp_path, simulate_recording(quiet, execution, window, 0))
    whole, long = identify(read_recording(file, CASE), CASE), identify_long(file, CASE).estimate
    assert long.told["smoothing_s2"]["value"] == pytest.approx(whole.told["smoothing_s2"]["value"], rel=1e-3)
    assert long.delay.value == pytest.approx(whole.delay.value, abs=1e-9)
    assert_same(long, whole, share=5e-3)
