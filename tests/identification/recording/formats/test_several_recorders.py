"""A run by several recorders: a table for each file, clocks joined by the edges of a trigger that all of them have."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import CaseError, HexciteError, RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import Case, load_case
from identification.identify import identify
from identification.recording.formats.joining import on_one_axis
from identification.recording.formats.table import Stream
from identification.recording.recording import read
from tests.helpers import examples, one_line
from tests.identification.recording.formats.loaded_hexapod import CENTRE, MASS, run
from tests.identification.recording.formats.runs import case_with, csv, written

SAMPLER = {"format": "halsampler", "column_names": ["trigger", *STRUTS], "clock": {"period_ms": 4.0}}
GERMAN = [f"Kraft {k} [daN]" for k in range(1, 7)]
AMPLIFIER = {
    "delimiter": ";", "decimal": ",",
    "columns": dict(zip(("t_s", *BAR_FORCES, "trigger"), ("Zeit [ms]", *GERMAN, "Trigger"), strict=True)),
}  # fmt: skip
EDGES = (0.5, 3.7)  # when the trigger switches [s]


def switched(t: np.ndarray, edges: Sequence[float] = EDGES) -> np.ndarray:
    return np.searchsorted(edges, t, side="right") % 2


def sampled(folder: Path, step: float = 0.004, end: float = 4.2, edges: Sequence[float] = EDGES) -> Path:
    """Struts and trigger as halsampler writes them, from -0.1 s on."""
    t = np.arange(-0.1, end, step)
    rows = np.column_stack([switched(t, edges), run(t).struts * 1e3])
    return written(folder, "".join("".join(f"{v:f} " for v in row) + "\n" for row in rows), "struts.txt")


def amplified(folder: Path, late: float, ppm: float = 0.0, end: float = 4.2, edges: Sequence[float] = EDGES) -> Path:
    """Forces and trigger of an amplifier of 300 Hz that starts later, and whose clock is fast."""
    t = np.arange(-0.1 + late, end, 1.0 / 300.0)
    stamps = (t - t[0]) * (1.0 + 1e-6 * ppm) * 1e3
    rows = np.column_stack([stamps, run(t, seed=4).forces / 10.0, switched(t, edges)])
    return written(folder, csv(rows, ["Zeit [ms]", *GERMAN, "Trigger"], ";", ","), "forces.csv")


def case_of(*tables: dict[str, object]) -> Case:
    return case_with(files=tables)


@pytest.mark.first(1)
@pytest.mark.parametrize("by_name", [True, False])
def test_each_file_is_read_by_its_table_and_clocks_are_joined(by_name: bool, tmp_path: Path) -> None:
    patterns: Any = ({"match": "struts*"}, {"match": "*.csv"}) if by_name else ({}, {})
    case = case_of(SAMPLER | patterns[0], AMPLIFIER | patterns[1])
    files = [amplified(tmp_path, late=0.2731), sampled(tmp_path)]
    for paths in (files, files[::-1]):
        recording = read(paths, case)
        result = identify(recording, case)
        for name, truth in zip(("m", "xC", "yC", "zC"), (MASS, *CENTRE), strict=True):
            assert abs(result[name].value - truth) < 4.0 * result[name].reported
        assert abs(result.delay) < 0.0037  # half the steps of both recorders
        (said,) = (f for f in recording.findings if f.kind == "clock")
        assert abs(said.quantity["clock_offset_s"] - 0.2731) < 0.0037
        assert "2 edges" in said.sentence
        assert "ppm" in said.sentence
        assert said.sentence in result.notes


def test_two_channels_of_a_sampler_have_a_list_of_names_each(tmp_path: Path) -> None:
    """Both count samples: seven fields a line in the one, eight in the other, which alone tells them apart."""
    t = np.arange(0.0, 4.0, 0.004)
    truth = run(t)

    def tagged(numbers: np.ndarray) -> str:
        return "".join(f"{k} " + "".join(f"{v:f} " for v in row) + "\n" for k, row in enumerate(numbers))

    files = [
        written(tmp_path, tagged(np.column_stack([switched(t), truth.struts * 1e3])), "c0.txt"),
        written(tmp_path, tagged(truth.forces), "c1.txt"),
    ]
    recording = read(files, case_of(SAMPLER, SAMPLER | {"column_names": [*BAR_FORCES]}))
    np.testing.assert_allclose(recording.drives, truth.struts, atol=1e-8)
    np.testing.assert_allclose(recording.forces, truth.forces, atol=1e-5)
    assert recording.others == ()


def test_a_file_that_fits_no_table_is_named_with_what_is_wrong_with_each(tmp_path: Path) -> None:
    file = written(tmp_path, "a;b\n1;2\n", "other.csv")
    with pytest.raises(
        RecordingError, match=r"other\.csv: fits none of the 3 tables.*1: .*2: .*3: .*match = "
    ) as caught:
        read([file], case_of(SAMPLER, AMPLIFIER))
    one_line(caught.value)


def test_a_pattern_leaves_no_other_table(tmp_path: Path) -> None:
    file = written(tmp_path, "a;b\n1;2\n", "forces_2.csv")
    with pytest.raises(RecordingError, match=r"none of the columns .*; it has a, b"):
        read([file], case_of(SAMPLER, AMPLIFIER | {"match": "forces*"}))


def test_a_name_that_no_pattern_fits_is_named_with_the_patterns(tmp_path: Path) -> None:
    file = amplified(tmp_path, 0.0)
    with pytest.raises(RecordingError, match=r"fits no match of \[\[recording\.files\]\]: struts\*, kraft\*") as caught:
        read([file], case_of(SAMPLER | {"match": "struts*"}, AMPLIFIER | {"match": "kraft*"}))
    one_line(caught.value)


@pytest.mark.parametrize("unit", ["Pfund", "counts"])
def test_a_refusal_of_a_file_names_the_table_whose_key_mends_it(unit: str, tmp_path: Path) -> None:
    labels = [f"Kraft {k} [{unit}]" for k in range(1, 7)]
    columns: Any = AMPLIFIER["columns"]
    named = {"columns": columns | dict(zip(BAR_FORCES, labels, strict=True)), "match": "forces*"}
    text = amplified(tmp_path, 0.0).read_text()
    files = [written(tmp_path, text.replace("[daN]", f"[{unit}]"), "forces.csv"), sampled(tmp_path)]
    table: dict[str, Any] = AMPLIFIER | named
    with pytest.raises(RecordingError, match=r"recording\.units\.forces.*stand in recording\.files\[2\]") as caught:
        read(files, case_of(SAMPLER | {"match": "struts*"}, table))
    one_line(caught.value)
    mended = read(files, case_of(SAMPLER | {"match": "struts*"}, table | {"units": {"forces": "daN"}}))
    assert abs(mended.forces.mean(axis=0) - run(np.arange(0.0, 4.2, 0.01)).forces.mean(axis=0)).max() < 20.0


@pytest.mark.parametrize("by_name", [True, pytest.param(False, marks=pytest.mark.slow)])
@pytest.mark.parametrize("which", ["forces", pytest.param("struts", marks=pytest.mark.slow)])
def test_keys_of_a_cause_stand_in_the_table_that_reads_the_columns_and_mend_the_run(
    which: str, by_name: bool, tmp_path: Path
) -> None:
    names = ["trigger", "l2_mm", "l1_mm", *STRUTS[2:]] if which == "struts" else ["trigger", *STRUTS]
    columns: Any = AMPLIFIER["columns"]
    if which == "forces":
        columns = columns | {"f1_N": GERMAN[1], "f2_N": GERMAN[0]}
    patterns: Any = ({"match": "struts*"}, {"match": "*.csv"}) if by_name else ({}, {})
    case = case_of(SAMPLER | {"column_names": names} | patterns[0], AMPLIFIER | {"columns": columns} | patterns[1])
    files = [amplified(tmp_path, late=0.2731), sampled(tmp_path)]
    with pytest.raises(HexciteError, match="exchanged") as caught:
        identify(read(files, case), case)
    ((words, keys, *_),) = [(each.words, each.keys) for each in caught.value.remedies]
    assert f"recording.files[{2 if which == 'forces' else 1}].columns" in one_line(caught.value)
    tables: dict[str, Any] = case.model_dump(mode="json", exclude_none=True)
    for key in keys:
        table: Any = tables
        for part in key.place[:-1]:
            table = table[part]
        table[key.place[-1]] = key.value
    mended = case_with(case, files=tables["recording"]["files"])
    assert abs(identify(read(files, mended), mended)["m"].value - MASS) < 0.1, words


def test_what_belongs_to_the_machine_is_stated_once(tmp_path: Path) -> None:
    text = (Path(load_case.__globals__["__file__"]).parent / "hexapod" / "case.toml").read_text()
    drives = "drives = { sign = [1, 1, 1, 1, 1, 1], offset_mm = [0, 0, 0, 0, 0, 0] }"
    (tmp_path / "case.toml").write_text(f"{text}\n[[recording.files]]\n{drives}\n")
    with pytest.raises(CaseError, match=r"recording\.files.*drives belongs to the machine.*recording\.drives"):
        load_case(str(tmp_path / "case.toml"))
    case = case_with(
        files=[SAMPLER | {"column_names": ["trigger", *(f"q{k}_mm" for k in range(1, 7))]}, AMPLIFIER],
        drives={"order": (1, 2, 3, 4, 5, 6), "sign": [-1.0] * 6, "offset_mm": [1500.0] * 6},
    )
    recording = read([sampled(tmp_path), amplified(tmp_path, 0.0)], case)
    motion = recording.stream_with("drives")
    np.testing.assert_allclose(motion.drives, 1.5 - run(motion.t - 0.1).struts, atol=1e-8)


def stream(t: np.ndarray, edges: Sequence[float], late: float = 0.0, rate: float = 0.0, **channels: object) -> Stream:
    """A trigger sampled at instants of one clock, and stamped by a clock that is `late` and fast by `rate`."""
    values = {"drives": None, "rotations": None, "forces": None} | channels
    return Stream(f"{next(iter(channels))}.csv", late + t * (1.0 + rate), trigger=switched(t, edges) == 1, **values)


def pair(
    edges: Sequence[float], late: float, rate: float, lead: float, end: float
) -> tuple[Stream, Stream, np.ndarray]:
    """Motion at 250 Hz from -1 s on, forces at 400 Hz from `lead` on, and the true instants of these."""
    motion, forces = np.arange(-1.0, end, 0.004), np.arange(lead, end, 0.0025)
    struts, zeros = np.zeros((len(motion), 6)), np.zeros((len(forces), 6))
    return stream(motion, edges, drives=struts), stream(forces, edges, late, rate, forces=zeros), forces


@settings(max_examples=examples(60), deadline=None)
@given(
    gaps=st.lists(st.floats(0.05, 3.0), min_size=1, max_size=6),
    late=st.one_of(st.floats(-1e4, 1e4), st.just(1.7e9)),
    ppm=st.floats(-200.0, 200.0),
    lead=st.floats(-0.5, -0.01),
)
def test_a_clock_is_known_to_the_samples_around_an_edge(
    gaps: list[float], late: float, ppm: float, lead: float
) -> None:
    edges = np.cumsum(gaps)
    motion, forces, truth = pair(edges, late, 1e-6 * ppm, lead, float(edges[-1]) + 1.0)
    (_, joined), (said,) = on_one_axis([motion, forces], [False, False])
    off = np.abs(joined.t - truth)
    span = edges[-1] + 2.0
    near = np.abs(truth[:, None] - edges).min(axis=1) < 0.01
    assert off[near].max() < 0.00325 + 2e-4 * span  # half the steps of both, and a rate that few edges do not show
    assert abs(said.quantity["clock_offset_s"] + late) < 0.004 + 2e-4 * (span + abs(lead))
    assert joined.trigger is None
    assert joined.channels.keys() == {"forces"}


@pytest.mark.parametrize("ppm", [-150.0, 80.0])
def test_a_long_run_shows_the_rate_of_the_clocks(ppm: float) -> None:
    edges = np.sort(np.random.default_rng(5).uniform(0.0, 200.0, 20))
    motion, forces, truth = pair(edges, 3.0, 1e-6 * ppm, -0.2, 201.0)
    (_, joined), (said,) = on_one_axis([motion, forces], [False, False])
    assert said.quantity["clock_rate_ppm"] == pytest.approx(-ppm, abs=12.0)
    assert np.abs(joined.t - truth).max() < 0.002


def test_clocks_that_agree_are_left_alone() -> None:
    motion, forces, _ = pair((0.5, 2.0), 0.0, 0.0, -0.3, 3.0)
    (_, joined), (said,) = on_one_axis([motion, forces], [False, False])
    np.testing.assert_array_equal(joined.t, forces.t)
    assert "one clock" in said.sentence


def test_a_recorder_that_started_late_or_stopped_early_has_fewer_edges() -> None:
    edges = (0.5, 2.0, 2.7, 4.1)
    motion, _, _ = pair(edges, 0.0, 0.0, -0.3, 5.0)
    for lead, end, count in ((1.0, 5.0, 3), (-0.5, 3.0, 3), (1.0, 3.0, 2)):
        _, forces, truth = pair(edges, 7.0, 0.0, lead, end)
        (_, joined), (said,) = on_one_axis([motion, forces], [False, False])
        assert np.abs(joined.t - truth).max() < 0.00325
        assert f"{count} edges" in said.sentence


def test_triggers_of_two_runs_are_refused_with_their_intervals() -> None:
    motion, _, _ = pair((0.5, 2.0), 0.0, 0.0, -0.3, 3.0)
    _, forces, _ = pair((0.5, 2.3), 0.0, 0.0, -0.3, 3.0)
    with pytest.raises(
        RecordingError, match=r"do not fit.*2 edges.*1\.8 s and 1\.5 s apart.*clock\.period_ms"
    ) as caught:
        on_one_axis([motion, forces], [False, False])
    one_line(caught.value)


def test_equal_pulses_that_fit_in_several_ways_are_refused() -> None:
    edges = (0.5, 1.0, 1.5, 2.0)
    motion, _, _ = pair(edges, 0.0, 0.0, -0.3, 3.0)
    _, forces, _ = pair(edges, 100.0, 0.0, 0.4, 1.1)  # the first pulse, or the second
    with pytest.raises(RecordingError, match="fit each other in 2 ways"):
        on_one_axis([motion, forces], [False, False])
    _, forces, _ = pair(edges, 100.0, 0.0, 0.4, 1.6)
    _, (said,) = on_one_axis([motion, forces], [False, False])
    assert said.quantity["clock_offset_s"] == pytest.approx(-100.0, abs=0.004)


def test_a_trigger_that_never_switches_hinders_nothing() -> None:
    motion, forces, _ = pair((0.5, 2.0), 0.0, 0.0, -0.3, 3.0)
    silent = replace(forces, trigger=np.zeros(len(forces.t), dtype=bool))
    (first, joined), found = on_one_axis([motion, silent], [False, False])
    assert found == ()
    assert joined.trigger is None
    assert first.trigger is not None


@pytest.mark.parametrize(("late", "severity"), [(0.0, "note"), (0.5, "warning")])
def test_an_offset_that_the_case_states_counts_and_is_compared(late: float, severity: str) -> None:
    motion, forces, _ = pair((0.5, 2.0), late, 0.0, -0.3, 3.0)
    (_, joined), (said,) = on_one_axis([motion, forces], [False, True])
    np.testing.assert_array_equal(joined.t, forces.t)
    assert said.severity == severity
    assert "recording.clock.offset_s" in said.sentence
