"""Damage in the middle of a moving run costs what the filter makes of it, and nothing else: sections stand alone."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.recording.recording import read, write_recording
from identification.results.estimate import Estimate, entries_of
from identification.results.force import force as over_recording
from identification.results.result import Result
from identification.samples.moving_window import moving_run
from identification.samples.sample_checks import missing_values, scan
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, few, refused_at, tells
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
MARGIN = 0.141  # [s] that the filter of this case reaches
Edit = Callable[[list[str]], None]


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """A run of 4 s at 1 kHz with the trigger on from 0.2 to 3.8 s, as text."""
    file = tmp_path_factory.mktemp("runs") / "recording.csv"
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=4.0))
    write_recording(file, simulate_recording(CASE, execution, np.array([[0.2, 3.8]]), 1), CASE)
    return file.read_text().splitlines()


def without(first: int, end: int) -> Edit:
    """Lines that are not there; line 1 is the header."""
    return lambda rows: rows.__delitem__(slice(first - 1, end - 1))


def emptied(first: int, end: int, column: int = 9, by: str = "") -> Edit:
    """Lines with a value that was not measured."""

    def edit(rows: list[str]) -> None:
        for k in range(first - 1, end - 1):
            fields = rows[k].split(",")
            fields[column] = by
            rows[k] = ",".join(fields)

    return edit


def later(line: int, seconds: float) -> Edit:
    """A recorder that goes on after a pause."""

    def edit(rows: list[str]) -> None:
        for k in range(line - 1, len(rows)):
            stamp, rest = rows[k].split(",", 1)
            rows[k] = f"{float(stamp) + seconds:.9f},{rest}"

    return edit


def damaged(lines: list[str], folder: Path, *edits: Edit) -> Path:
    rows = list(lines)
    for edit in edits:
        edit(rows)
    file = folder / "run.csv"
    file.write_text("\n".join(rows) + "\n")
    return file


def identified(file: Path) -> Estimate:
    return estimate_parameters(read(file, CASE), CASE)


@pytest.fixture(scope="module")
def sound(lines: list[str], tmp_path_factory: pytest.TempPathFactory) -> Estimate:
    """What the run without damage tells."""
    return identified(damaged(lines, tmp_path_factory.mktemp("sound")))


DAMAGES: dict[str, tuple[Edit, float, tuple[str, ...]]] = {  # edit, seconds that are lost, what is told
    "values of 80 rows": (emptied(1500, 1580), 0.080, ("lines 1500 to 1579: no measured value in f3_N; left out",)),
    "NaN in 80 rows": (emptied(1500, 1580, 2, "NaN"), 0.080, ("lines 1500 to 1579: no measured value in l2_mm",)),
    "80 rows": (without(1500, 1580), 0.080, ("behind line 1499: 80 samples are missing; no filter reaches across",)),
    "two gaps": (
        lambda rows: (without(2500, 2600)(rows), without(1500, 1580)(rows))[0],
        0.180 + 2 * MARGIN,
        ("behind lines 1499, 2419: 180 samples are missing",),
    ),
    "a pause of half a step less": (later(1500, 0.0804), 0.080, ("behind line 1499: 80 samples are missing",)),
}


@pytest.mark.first(1)
@pytest.mark.parametrize("damage", few(*DAMAGES, kept=4))
def test_damage_costs_itself_and_the_filters_reach(
    damage: str, lines: list[str], sound: Estimate, tmp_path: Path
) -> None:
    edit, lost, says = DAMAGES[damage]
    estimate = identified(damaged(lines, tmp_path, edit))
    expected = 3600 - (1e3 if "pause" not in damage else 0.0) * lost - 2e3 * MARGIN
    assert estimate.samples.recorded_count == pytest.approx(expected, abs=4)
    apart = np.abs(estimate.fit.values - sound.fit.values) / np.sqrt(np.diag(sound.fit.covariance))
    assert apart.max() < 3.0
    assert all(any(w.startswith(text) for w in estimate.warnings) for text in says)
    (share,) = [w for w in estimate.warnings if "of the motion is left out" in w]
    assert float(share.split(" %")[0]) == pytest.approx(100 * (lost + 2 * MARGIN) / 3.6, abs=0.6)
    assert tells(share, "0.141 s", "filter")


def test_values_beyond_the_filters_reach_are_those_of_the_sound_run(lines: list[str], tmp_path: Path) -> None:
    """Whatever stands in the damaged rows: forces and regressors of all others do not feel it, at any delay."""
    model = identification_model(CASE, 9)
    sound = read(damaged(lines, tmp_path), CASE)
    whole = moving_run(sound, CASE, model)
    whole = whole.at(np.arange(0, 3700, 5))
    for edit in (without(1500, 1580), emptied(1500, 1580, 3, "1e30"), emptied(1500, 1580, 10)):
        broken = read(damaged(lines, tmp_path, edit), CASE)
        run = moving_run(scan(broken, CASE).recording, CASE, model)
        assert run.spoilt is not None
        run = run.at(np.flatnonzero(~run.spoilt))
        every = np.flatnonzero(np.isin(whole.t.round(6), run.t.round(6)))
        same = np.flatnonzero(np.isin(run.t.round(6), whole.t.round(6)))
        assert len(same) == pytest.approx((3.7 - 0.08 - 2 * MARGIN) / 0.005, abs=4)
        for delay in (0.0, 0.04, -0.04):
            np.testing.assert_allclose(run.regressors(delay)[same], whole.regressors(delay)[every], atol=1e-8)
        np.testing.assert_allclose(run.forces[same], whole.forces[every], atol=1e-8)
        assert not np.any((run.t > 1.498 - MARGIN) & (run.t < 1.578 + MARGIN))


@pytest.mark.first(1)
@pytest.mark.parametrize(
    "edit", few(without(1500, 1503), emptied(1500, 1501, 1), without(1500, 1501), emptied(1500, 1503), kept=2)
)
def test_a_few_samples_are_bridged(edit: Edit, lines: list[str], sound: Estimate, tmp_path: Path) -> None:
    estimate = identified(damaged(lines, tmp_path, edit))
    assert estimate.samples.recorded_count == sound.samples.recorded_count
    assert len(estimate.warnings) == len(sound.warnings) + 1
    apart = np.abs(estimate.fit.values - sound.fit.values) / np.sqrt(np.diag(sound.fit.covariance))
    assert 0.0 < apart.max() < 1.0


@pytest.mark.parametrize("end", range(2000, 2008))
def test_places_of_samples_count_what_is_missing(end: int, lines: list[str], tmp_path: Path) -> None:
    """Noise with memory is correlated over the time that has passed, and a gap of any length leaves no place twice."""
    recording = read(damaged(lines, tmp_path, without(1500, end)), CASE)
    run = moving_run(recording, CASE, identification_model(CASE, 9))
    np.testing.assert_allclose(run.places * run.step, run.t - run.t[0], atol=0.51 * run.step)
    assert run.filter.stride == 8  # so that these are all places of a section among the evaluated samples
    assert np.all(np.diff(run.places) >= 1)


@pytest.mark.parametrize("edit", [without(600, 3500), emptied(1200, 2700), emptied(30, 1300, 5)])
def test_a_run_that_is_mostly_damage_is_refused_with_the_limit(edit: Edit, lines: list[str], tmp_path: Path) -> None:
    file = damaged(lines, tmp_path, edit)
    with refused_at(file, r"(at most|more than) (30|50) %"):
        identified(file)


@pytest.mark.repeats
def test_external_force_leaves_the_same_rows_out(lines: list[str], tmp_path: Path) -> None:
    sound = identified(damaged(lines, tmp_path))
    result = Result(CASE, entries_of(sound))
    before = over_recording(read(damaged(lines, tmp_path), CASE), result)
    force = over_recording(read(damaged(lines, tmp_path, without(1500, 1580)), CASE), result)
    assert not np.any((force.t > 1.498 - MARGIN) & (force.t < 1.578 + MARGIN))
    assert np.abs(force.wrench).max() <= np.abs(before.wrench).max() * (1.0 + 1e-6)
    assert any("80 samples are missing" in w for w in force.warnings)


def test_rows_that_a_part_of_a_run_no_longer_has_are_not_counted_in_it(lines: list[str], tmp_path: Path) -> None:
    recording = read(damaged(lines, tmp_path, without(1500, 1502)), CASE)
    (first, second) = recording.lines.inserted
    assert second == first + 1
    assert [f.sentence for f in missing_values(recording)] == [
        "behind line 1499: 2 samples are missing; bridged from their neighbours"
    ]
    cut = replace(recording, lines=replace(recording.lines, inserted=(first, second, recording.rows)))
    assert [f.sentence for f in missing_values(cut)] == [f.sentence for f in missing_values(recording)]
