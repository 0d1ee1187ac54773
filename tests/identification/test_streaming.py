"""A run evaluated in blocks is the same run: parameters, covariance and residuals of the one-shot evaluation."""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cases.errors import HexciteError
from cases.loading import load_case
from cases.schema import Case
from identification import blocks, contact_free, streaming, total
from identification.blocks import Blocks, fits_blocks
from identification.estimators import Method, method
from identification.executed import PoseExecution
from identification.formats import parquet, reading
from identification.frame import structure_matrix
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.long_feed import MOST_TOLD, LongFeed
from identification.model import identification_model
from identification.rates import on_one_clock
from identification.recording import Recording, read_recording, write_recording
from identification.result import Estimate
from identification.selection import symmetric_platform
from identification.signals import Filter
from identification.simulate import simulate_recording
from identification.streaming import identify_long
from tests.helpers import Harmonic, one_line
from tests.identification.leaping import moves_without_jerk_limit
from tests.planner.command_line import call

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
RUN = simulate_recording(
    CASE, PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=4.0)), np.array([[0.2, 1.7], [2.0, 3.8]]), 0
)


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lengths that let a short run go through many blocks."""
    monkeypatch.setattr(blocks, "HEAD", 2000)
    monkeypatch.setattr(blocks, "LEAST", 1)
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


def with_weights(weights: str) -> Case:
    return CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update={"weights": weights})})


def assert_same(blocks: Estimate, whole: Estimate, share: float = 1e-4) -> None:
    """Within a small share of the standard deviations."""
    std = np.sqrt(np.diag(whole.covariance))
    assert np.abs((blocks.values - whole.values) / std).max() < share
    np.testing.assert_allclose(np.diag(blocks.covariance), np.diag(whole.covariance), rtol=1e-3)
    assert blocks.samples == whole.samples


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


def with_columns(file: Path, columns: dict[str, np.ndarray], without: str) -> None:
    """Writes a file anew with other columns in the place of some."""
    table = pq.read_table(file)
    table = table.drop_columns([n for n in table.column_names if n.startswith(without)])
    for name, values in columns.items():
        table = table.append_column(name, pa.array(values))
    pq.write_table(table, file)


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


def pushed(starts: Sequence[float], duration: float = 0.2) -> Recording:
    """The run with 20 N on the platform, which sensors read by J^T (1)."""
    extra = np.linalg.solve(structure_matrix(CASE.sensor_frame), [12.0, 0.0, 16.0, 0.0, 0.0, 0.0])
    on = np.any([(RUN.t >= s) & (RUN.t < s + duration) for s in starts], axis=0)
    return replace(RUN, forces=RUN.forces - on[:, None] * extra)


def told(estimate: Estimate) -> list[tuple[float, ...]]:
    """First line, last line, begin, end and force of each contact that is told."""
    pattern = r"(\d+) to (\d+): external contact from ([\d.]+) to ([\d.]+) s, up to ([\d.]+) N"
    return [tuple(map(float, m.groups())) for w in estimate.warnings if (m := re.search(pattern, w))]


@pytest.mark.parametrize("batch", [1100, 1500])
def test_contacts_are_found_as_in_a_whole_run_also_across_blocks(
    batch: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet, "_BATCH", batch)
    starts = (1.0, 2.9)  # blocks of 1100 rows end in the first, of 1500 in the second
    file = written(tmp_path, pushed(starts))
    long, whole = identify_long(file, CASE).estimate, identify(read_recording(file, CASE), CASE)
    found = told(long)
    assert len(found) == len(starts)
    for start, (first, last, begin, end, newtons) in zip(starts, found, strict=True):
        assert abs(begin - start) < 0.05
        assert abs(end - start - 0.2) < 0.05
        assert abs(first - 1 - 1e3 * begin) < 2
        assert abs(last - 1 - 1e3 * end) < 2
        assert 17.0 < newtons < 25.0
    assert np.abs((long.values - whole.values) / np.sqrt(np.diag(whole.covariance))).max() < 0.5


def test_nothing_is_found_where_nothing_touches(tmp_path: Path) -> None:
    for seed in range(4):
        run = replace(RUN, forces=RUN.forces + np.random.default_rng(seed).normal(size=RUN.forces.shape))
        assert identify_long(written(tmp_path, run), CASE).estimate.warnings == ()


def test_a_run_in_contact_for_too_long_is_refused_with_the_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contact_free, "MOST_TOUCHED", 0.05)
    with pytest.raises(HexciteError, match=r"in contact \(rows \d+ to \d+: external contact from [01]\.") as caught:
        identify_long(written(tmp_path, pushed((1.0,))), CASE)
    one_line(caught.value)


def test_a_long_silence_of_a_sensor_is_left_out_with_the_length_of_the_filter(tmp_path: Path) -> None:
    forces = RUN.forces.copy()
    forces[1200:1230, 4] = 5000.0  # at the end of its range
    file = written(tmp_path, replace(RUN, forces=forces))
    assert_same(identify_long(file, CASE).estimate, identify(read_recording(file, CASE), CASE))


def test_long_files_are_evaluated_in_blocks_from_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path)
    words = ("identify", file, "--case", "hexapod", "--json")
    short = call(*words, "-o", tmp_path / "short").json()
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 1000)  # what reads it at once now fails
    long = call(*words, "-o", tmp_path / "long").json()
    assert long["linear"]["values"] == pytest.approx(short["linear"]["values"], rel=1e-5)
    assert long["warnings"] == short["warnings"] == []


@pytest.mark.parametrize(
    "wish", [("--fix", "m=31.9kg", "--drop", "k2", "--drop", "k3"), ("--symmetric", "--terms", "K2")]
)
def test_what_is_known_or_left_out_is_evaluated_in_blocks_from_the_command_line(
    wish: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("identify", written(tmp_path), "--case", "hexapod", *wish, "--json")
    short = call(*words, "-o", tmp_path / "short").json()
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 1000)
    long = call(*words, "-o", tmp_path / "long").json()
    assert long["linear"]["values"] == pytest.approx(short["linear"]["values"], rel=1e-5)
    assert (long["known"], long["dropped"], long["error_terms"]) == (
        short["known"], short["dropped"], short["error_terms"]
    )  # fmt: skip


def test_what_needs_the_whole_run_says_so_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 1000)
    words = ("identify", written(tmp_path), "--case", "hexapod", "--estimator", "robust", "-o", tmp_path / "r")
    failed = call(*words)
    assert "holds too much to be read at once" in failed.refusal()
    assert "--estimator gauss-markov, without --prior" in failed.refusal()


def test_several_files_of_one_run_that_are_too_long_together_are_refused_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blocks need struts and forces side by side; neither file alone is too long."""
    table = pq.read_table(written(tmp_path))
    struts, forces = tmp_path / "struts.parquet", tmp_path / "forces.parquet"
    pq.write_table(table.drop_columns([f"f{k}_N" for k in range(1, 7)]), struts)
    pq.write_table(table.select(["t_s", *(f"f{k}_N" for k in range(1, 7))]), forces)
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 35_000)
    refused = call("identify", struts, forces, "--case", "hexapod", "-o", tmp_path / "r").refusal()
    assert "forces.parquet and the files before it hold too much to be read at once" in refused
    assert "put time, struts and forces into one file, which may be of any length" in refused
    assert not (tmp_path / "r").exists()


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


def held(ratio: int, dropped: int = 2) -> Recording:
    """The run with struts that come every `ratio` rows and are held until then; the file begins within a sample."""
    rows = np.arange(len(RUN.forces)) // ratio * ratio
    assert RUN.struts is not None
    assert RUN.t is not None
    assert RUN.trigger is not None
    later = slice(dropped, None)
    return replace(
        RUN, t=RUN.t[later] - RUN.t[dropped], struts=RUN.struts[rows][later], forces=RUN.forces[later],
        trigger=RUN.trigger[later],
    )  # fmt: skip


@pytest.mark.parametrize(("batch", "trigger"), [(97, True), (700, True), (700, False), (100_000, True)])
def test_struts_that_are_held_are_taken_when_they_are_new_as_in_a_whole_run(
    batch: int, trigger: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet, "_BATCH", batch)
    file = written(tmp_path, held(4))
    if not trigger:
        pq.write_table(pq.read_table(file).drop_columns(["trigger"]), file)
    whole = identify(on_one_clock(read_recording(file, CASE), CASE), CASE)
    long = identify_long(file, CASE).estimate
    assert np.linalg.norm(long.values - whole.values) < 1e-9 * np.linalg.norm(whole.values)
    assert long.samples == whole.samples
    assert long.told["averaged"]["ratio"] == pytest.approx(4.0)
    assert long.told["averaged"].keys() == whole.told["averaged"].keys()
    assert any("4 samples averaged" in note for note in long.notes)


def test_rows_of_held_struts_are_named_as_they_stand_in_the_file(tmp_path: Path) -> None:
    recording = held(4)
    forces = recording.forces.copy()
    forces[1500:1560, 4] = 5000.0  # at the end of its range
    estimate = identify_long(written(tmp_path, replace(recording, forces=forces)), CASE).estimate
    (warning,) = [w for w in estimate.warnings if "end of its range" in w]
    first, last = map(int, re.findall(r"rows (\d+) to (\d+):", warning)[0])
    assert abs(first - 1501) <= 4
    assert abs(last - 1560) <= 4


def test_struts_that_lose_their_rhythm_are_refused_with_the_row(tmp_path: Path) -> None:
    recording = held(4)
    rows = np.arange(len(recording.forces))
    rows[2500:] = 2500 + (rows[2500:] - 2500) // 4 * 4 + 2
    assert recording.struts is not None
    struts = recording.struts[np.minimum(rows, len(rows) - 1)]
    with pytest.raises(HexciteError, match=r"row 2\d\d\d: the struts were held for 4 rows each, from here") as caught:
        identify_long(written(tmp_path, replace(recording, struts=struts)), CASE)
    one_line(caught.value)


@pytest.mark.parametrize("trigger", [True, False])
def test_a_recorded_override_is_told_as_in_a_whole_run(trigger: bool, tmp_path: Path) -> None:
    """Stretches within blocks, across their ends, next to each other, and outside the window."""
    override = np.ones(len(RUN.forces))
    override[650:1500], override[1500:1650], override[2900:3000], override[:100] = 0.7, 0.4, 1.2, 0.5
    file = written(tmp_path)
    table = pq.read_table(file).append_column("override_percent", pa.array(100.0 * override))
    pq.write_table(table if trigger else table.drop_columns(["trigger"]), file)
    whole, long = identify(read_recording(file, CASE), CASE), identify_long(file, CASE).estimate
    assert long.told["feed"] == whole.told["feed"]
    assert len(long.told["feed"]["stretches"]) == 3 + (not trigger)
    assert [w for w in long.warnings if "feed" in w] == [w for w in whole.warnings if "feed" in w]
    assert_same(long, whole)


def test_of_ever_changing_feed_the_first_stretches_are_told_and_the_others_counted() -> None:
    feed, rows = LongFeed(), np.arange(3000)
    override = np.where(rows % 2, 1.0, 0.5)
    for start in range(0, 3000, 700):
        part = slice(start, start + 700)
        block = Recording("run", rows[part] / 1e3, None, None, np.zeros((len(rows[part]), 6)), None)
        feed.add(replace(block, override=override[part]))
    (sentence,), told = feed.told()
    assert len(told["feed"]["stretches"]) == MOST_TOLD
    assert told["feed"]["more"] == 1500 - MOST_TOLD
    assert f"and {1500 - 3} more stretches" in sentence


def test_a_long_run_that_is_not_compared_with_its_program_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    written(tmp_path).rename(folder / "recording.parquet")
    (folder / "recording.json").write_text(json.dumps({"plan_hash": "0123456789abcdef", "case": "hexapod"}))
    words = ("identify", folder, "--case", "hexapod", "--json", "-o", tmp_path / "r")
    monkeypatch.setattr(streaming, "LONG", 1000)
    (note,) = [n for n in call(*words).json()["notes"] if "program" in n]
    assert "--plan compares a run that fits into memory" in note
