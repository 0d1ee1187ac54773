"""Units that labels and rows of units state: read in, or refused where they are not known; never the usual ones."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import HexciteError, RecordingError
from cases.base.unit_names import FORCES, LENGTHS, MOMENTS, QUANTITIES, TIMES
from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import Case, load_case
from identification.identify import identify
from identification.recording.formats.names.labels import stated_unit
from identification.recording.recording import Recording, read
from tests.helpers import examples, one_line
from tests.identification.recording.formats.loaded_hexapod import CENTRE, MASS, run
from tests.identification.recording.formats.runs import Truth, case_with, csv, written

RUN = Truth()
LABELS = [f"Kraft {k}" for k in range(1, 7)]
WEIGHED = run(np.arange(1001) * 0.004)


def mapped(labels: list[str], names: tuple[str, ...] = BAR_FORCES, **recording: object) -> Case:
    return case_with(columns=dict(zip(names, labels, strict=True)), **recording)


def with_forces(folder: Path, labels: list[str], forces: np.ndarray, row: str = "") -> Path:
    """A file whose forces have other labels, and perhaps a row of units below the names."""
    text = csv(np.column_stack([RUN.t, RUN.struts * 1e3, forces]), ["t_s", *STRUTS, *labels])
    names, _, rows = text.partition("\n")
    return written(folder, f"{names}\n{row}\n{rows}" if row else text)


def warnings(recording: Recording) -> list[str]:
    return [f.sentence for f in recording.findings if f.severity == "warning"]


@settings(max_examples=examples(40), deadline=None)
@given(
    force=st.sampled_from(list(FORCES)),
    length=st.sampled_from(list(LENGTHS)),
    time=st.sampled_from([unit for unit in TIMES if unit != "filetime"]),
    form=st.sampled_from(["{} [{}]", "{} ({})", "{} / {}", "{}_{}"]),
)
def test_labels_are_read_in_the_units_that_they_state(
    force: str, length: str, time: str, form: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    if form in ("{} / {}", "{}_{}") and {force, length, time} & {"in", "ft", "h", "d"}:
        return  # without brackets they may belong to the name
    labels = [form.format(name, force) for name in LABELS]
    struts = [form.format(f"Strebe {k}", length) for k in range(1, 7)]
    clock = form.format("Zeit", time)
    numbers = np.column_stack([RUN.t / TIMES[time], RUN.struts / LENGTHS[length], RUN.forces / FORCES[force]])
    file = tmp_path_factory.mktemp("labels") / "run.csv"
    text = [",".join([clock, *struts, *labels]), *(",".join(f"{v:.17g}" for v in row) for row in numbers)]
    file.write_text("\n".join(text))
    columns = dict(zip(("t_s", *STRUTS, *BAR_FORCES), (clock, *struts, *labels), strict=True))
    recording = read(file, case_with(columns=columns))
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-12)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-12)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-12)
    said = " ".join(f.sentence for f in recording.findings)
    others = {force, length, time} - {"N", "mm", "s"}
    assert not warnings(recording)
    assert all(unit in said for unit in others)


def test_forces_in_pounds_weigh_the_right_mass(tmp_path: Path) -> None:
    labels = [f"Force {k} [lbf]" for k in range(1, 7)]
    numbers = np.column_stack([WEIGHED.t, WEIGHED.struts * 1e3, WEIGHED.forces / FORCES["lbf"]])
    file = written(tmp_path, csv(numbers, ["t_s", *STRUTS, *labels]))
    result = identify(read(file, mapped(labels)), mapped(labels))
    assert abs(result["m"].value - MASS) < 4.0 * result["m"].reported
    assert any("lbf" in note and "Force 1 [lbf]" in note for note in result.notes)


@pytest.mark.repeats
def test_counts_weigh_the_right_mass_by_the_factor_of_each_channel(tmp_path: Path) -> None:
    labels = [f"LC{k}_raw" for k in range(1, 7)]
    scale = np.array([0.1526, 0.1531, 0.1519, 0.1528, 0.1524, -0.1530])
    file = written(
        tmp_path,
        csv(
            np.column_stack([WEIGHED.t, WEIGHED.struts * 1e3, np.rint(WEIGHED.forces / scale)]),
            ["t_s", *STRUTS, *labels],
        ),
    )
    with pytest.raises(RecordingError, match=r"run\.csv, LC1_raw: holds counts .*5 more.*recording\.scale") as caught:
        read(file, mapped(labels))
    one_line(caught.value)
    case = mapped(labels, scale=dict(zip(BAR_FORCES, scale.tolist(), strict=True)))
    result = identify(read(file, case), case)
    for name, truth in zip(("m", "xC", "yC", "zC"), (MASS, *CENTRE), strict=True):
        assert abs(result[name].value - truth) < 4.0 * result[name].reported


@pytest.mark.parametrize("label", ["Force {} [%FS]", "Force {} (% of full scale)", "Force {} % FS", "Force {} [FS]"])
@pytest.mark.parametrize("stated", [True, False])
def test_shares_of_a_range_weigh_the_right_mass_by_the_remedy(stated: bool, label: str, tmp_path: Path) -> None:
    """The range of the case scales them, where it states one; the keys that the message names are those that work."""
    full = 800.0
    labels = [label.format(k) for k in range(1, 7)]
    file = written(
        tmp_path, csv(np.column_stack([RUN.t, RUN.struts * 1e3, RUN.forces / full * 100.0]), ["t_s", *STRUTS, *labels])
    )
    case = mapped(labels)
    sensors = case.sensors.model_copy(update={"range_N": full if stated else None})
    case = case.model_copy(update={"sensors": sensors})
    with pytest.raises(RecordingError, match=r"run\.csv, Force 1.*: holds shares of a range .*5 more") as caught:
        read(file, case)
    said = re.search(r"recording\.scale = \{ (.*?) \}", one_line(caught.value))
    assert said is not None
    keys = dict(entry.split(" = ") for entry in said[1].split(", "))
    assert set(keys) == set(BAR_FORCES)
    assert set(keys.values()) == ({"8"} if stated else {".."})
    scale = dict.fromkeys(BAR_FORCES, full / 100.0)
    assert np.allclose(read(file, mapped(labels, scale=scale)).forces, RUN.forces)


@pytest.mark.parametrize(
    "unit",
    ["counts", "V", "mV/V", "digits", "bar", "Pfund", "mm", "Nm", "?", "µε", "με", "µ∊", "‰", "N²", "Inkr.", "#", "тс"],
)
def test_a_unit_that_forces_cannot_have_is_refused_with_label_and_remedy(unit: str, tmp_path: Path) -> None:
    labels = [f"{name} [{unit}]" for name in LABELS]
    with pytest.raises(RecordingError, match=r"Kraft 1 \[.*5 more.*recording\.(units|scale)") as caught:
        read(with_forces(tmp_path, labels, RUN.forces), mapped(labels))
    assert unit in one_line(caught.value)


@pytest.mark.parametrize("unit", ["µV", "με", "dN"])
def test_a_unit_behind_a_name_that_forces_cannot_have_is_refused(unit: str, tmp_path: Path) -> None:
    labels = [f"{name} {unit}" for name in LABELS]
    with pytest.raises(RecordingError, match=f"'{unit}' is not a known unit of forces"):
        read(with_forces(tmp_path, labels, RUN.forces), mapped(labels))


@pytest.mark.parametrize(("unit", "factor"), [("Н", 1.0), ("кН", 1e3), ("кгс", 9.80665)])
def test_cyrillic_units_are_read(unit: str, factor: float, tmp_path: Path) -> None:
    labels = [f"{name} [{unit}]" for name in LABELS]
    recording = read(with_forces(tmp_path, labels, RUN.forces / factor), mapped(labels))
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-7)
    assert not warnings(recording)


def test_the_remedies_of_the_refusal_work(tmp_path: Path) -> None:
    labels = [f"{name} [Pfund]" for name in LABELS]
    file = with_forces(tmp_path, labels, RUN.forces)
    stated = read(file, mapped(labels, units={"forces": "lbf"}))
    np.testing.assert_allclose(stated.forces, RUN.forces * 4.4482216152605, rtol=1e-12)
    scaled = read(file, mapped(labels, scale=dict.fromkeys(BAR_FORCES, 4.903325)))
    np.testing.assert_allclose(scaled.forces, RUN.forces * 4.903325, rtol=1e-12)
    assert warnings(stated) == warnings(scaled) == []


@pytest.mark.parametrize(
    ("row", "unit", "factor"),
    [("s{}", "kN", 1e3), ("-{}", "daN", 10.0), ("Einheit{}", "kp", 9.80665)],
)
def test_a_row_of_units_counts(row: str, unit: str, factor: float, tmp_path: Path) -> None:
    cells = ",mm" * 6 + f",{unit}" * 6
    file = with_forces(tmp_path, LABELS, RUN.forces / factor, row.format(cells))
    recording = read(file, mapped(LABELS, header_rows=2, names_row=1))
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-7)


def test_a_unit_in_a_row_that_is_not_known_is_refused(tmp_path: Path) -> None:
    file = with_forces(tmp_path, LABELS, RUN.forces, "s" + ",mm" * 6 + ",LSB" * 6)
    with pytest.raises(RecordingError, match=r"Kraft 1: holds counts \(LSB\)"):
        read(file, mapped(LABELS, header_rows=2, names_row=1))


def test_label_and_row_that_contradict_are_refused(tmp_path: Path) -> None:
    labels = [f"{name} [kN]" for name in LABELS]
    file = with_forces(tmp_path, labels, RUN.forces, "s" + ",mm" * 6 + ",N" * 6)
    with pytest.raises(RecordingError, match="units that differ, kN and N"):
        read(file, mapped(labels, header_rows=2, names_row=1))


def test_our_names_state_a_unit_that_a_row_may_contradict(tmp_path: Path) -> None:
    row = "s" + ",mm" * 6 + ",{}" * 6
    agrees = with_forces(tmp_path, [*BAR_FORCES], RUN.forces, row.format(*["N"] * 6))
    assert read(agrees, case_with(header_rows=2, names_row=1)).findings == ()
    differs = with_forces(tmp_path, [*BAR_FORCES], RUN.forces / 1e3, row.format(*["kN"] * 6))
    with pytest.raises(
        RecordingError, match=r"f1_N: has units that differ, N and kN .*5 more.*recording\.units\.forces"
    ):
        read(differs, case_with(header_rows=2, names_row=1))
    stated = read(differs, case_with(header_rows=2, names_row=1, units={"forces": "kN"}))
    np.testing.assert_allclose(stated.forces, RUN.forces, rtol=1e-7)
    assert stated.findings == ()


def test_what_the_case_states_wins_over_a_label_and_is_a_warning(tmp_path: Path) -> None:
    labels = [f"{name} [kN]" for name in LABELS]
    recording = read(with_forces(tmp_path, labels, RUN.forces), mapped(labels, units={"forces": "N"}))
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    (said,) = warnings(recording)
    assert "Kraft 1 [kN]" in said
    assert "recording.units.forces" in said


def test_units_of_single_channels_may_differ(tmp_path: Path) -> None:
    labels = [f"{LABELS[0]} [kN]", *(f"{name} [N]" for name in LABELS[1:])]
    file = with_forces(tmp_path, labels, RUN.forces * [1e-3, 1.0, 1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(read(file, mapped(labels)).forces, RUN.forces, rtol=1e-7)


@pytest.mark.parametrize(
    ("units", "silent", "unit"), [("kN,-,-,-,-,-", 5, "kN"), ("-,-,-,-,-,lbf", 5, "lbf"), ("daN,daN,N,N,N,-", 1, "daN")]
)
def test_columns_without_a_unit_beside_one_in_another_are_refused(
    units: str, silent: int, unit: str, tmp_path: Path
) -> None:
    """Nobody knows whether they are in newtons or in the unit of their neighbours; both remedies read what they say."""
    stated = units.split(",")
    labels = [name if says == "-" else f"{name} [{says}]" for name, says in zip(LABELS, stated, strict=True)]
    file = with_forces(tmp_path, labels, RUN.forces)
    others = rf".*{silent - 1} more" if silent > 1 else ""
    first = labels[stated.index("-")]
    with pytest.raises(RecordingError, match=rf"run\.csv, {first}: states no unit{others}.*{unit}") as caught:
        read(file, mapped(labels))
    said = re.search(r"recording\.scale = \{ (.*?) \}", one_line(caught.value))
    assert said is not None
    scale = {entry.split(" = ")[0]: float(entry.split(" = ")[1]) for entry in said[1].split(", ")}
    factors = np.array([1.0 if says == "-" else FORCES[says] for says in stated])
    np.testing.assert_allclose(read(file, mapped(labels, scale=scale)).forces, RUN.forces * factors)
    assert f"recording.units.forces = '{unit}'" in one_line(caught.value)
    whole = read(file, mapped(labels, units={"forces": unit}))
    np.testing.assert_allclose(whole.forces, RUN.forces * FORCES[unit])


def test_moments_without_a_unit_beside_forces_in_another_are_refused(tmp_path: Path) -> None:
    wrist = load_case("ft_wrist")
    names = (*(f"F{axis} [lbf]" for axis in "xyz"), *(f"T{axis}" for axis in "xyz"))
    turns = np.tile(np.eye(3).ravel(), (12, 1))
    numbers = np.column_stack([turns, np.random.default_rng(1).normal(size=(12, 6))])
    file = written(tmp_path, csv(numbers, [*(f"r{i}{j}" for i in "123" for j in "123"), *names]))
    columns = dict(zip(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"), names, strict=True))
    with pytest.raises(RecordingError, match=r"Tx: states no unit.*lbf.*recording\.units\.moments = 'Nm'"):
        read(file, case_with(wrist, columns=columns))
    stated = read(file, case_with(wrist, columns=columns, units={"moments": "lbf-in"}))
    np.testing.assert_allclose(stated.forces[:, 3:], numbers[:, 12:] * MOMENTS["lbf-in"], rtol=1e-7)


def test_stamps_whose_label_is_wrong_are_read_as_the_case_states_and_it_is_said(tmp_path: Path) -> None:
    numbers = np.column_stack([RUN.t * 1e3, RUN.struts * 1e3, RUN.forces])
    file = written(tmp_path, csv(numbers, ["Time [s]", *STRUTS, *BAR_FORCES]))
    recording = read(file, case_with(columns={"t_s": "Time [s]"}, clock={"unit": "ms"}))
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    assert "recording.clock.unit" in warnings(recording)[0]


def test_a_clock_that_counts_has_its_period_as_scale(tmp_path: Path) -> None:
    numbers = np.column_stack([np.arange(RUN.count), RUN.struts * 1e3, RUN.forces])
    file = written(tmp_path, csv(numbers, ["Sample [ticks]", *STRUTS, *BAR_FORCES]))
    with pytest.raises(
        RecordingError, match=r"Sample \[ticks\]: 'ticks' is not a unit of time.*recording\.clock\.unit"
    ):
        read(file, case_with(columns={"t_s": "Sample [ticks]"}))
    recording = read(file, case_with(columns={"t_s": "Sample [ticks]"}, scale={"t_s": RUN.step}))
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)


def test_whole_numbers_whose_unit_nobody_states_are_doubted(tmp_path: Path) -> None:
    file = with_forces(tmp_path, LABELS, np.rint(RUN.forces))
    (said,) = warnings(read(file, mapped(LABELS)))
    assert "Kraft 1" in said
    assert "recording.scale" in said
    assert not warnings(read(file, mapped(LABELS, units={"forces": "N"})))
    assert not warnings(read(with_forces(tmp_path, list(BAR_FORCES), np.rint(RUN.forces)), case_with()))


@pytest.mark.parametrize(
    "label", ["wrench[{}]", "Force {} (left)", "F{} (AI0)", "raw_{}", "Kraft {} (Istwert)", "f{}.x"]
)
def test_brackets_and_words_that_are_not_units_hinder_nothing(label: str, tmp_path: Path) -> None:
    labels = [label.format(k) for k in range(1, 7)]
    recording = read(with_forces(tmp_path, labels, RUN.forces), mapped(labels))
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    assert recording.findings == ()


def test_moments_have_units_of_their_own(tmp_path: Path) -> None:
    wrist = load_case("ft_wrist")
    names = (*(f"F{axis} [lbf]" for axis in "xyz"), *(f"T{axis} [lbf-in]" for axis in "xyz"))
    draw = np.random.default_rng(1)
    wrench = draw.normal(size=(12, 6))
    turns = np.tile(np.eye(3).ravel(), (12, 1))
    file = written(
        tmp_path, csv(np.column_stack([turns, wrench]), [*(f"r{i}{j}" for i in "123" for j in "123"), *names])
    )
    columns = dict(zip(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"), names, strict=True))
    factors = [FORCES["lbf"]] * 3 + [MOMENTS["lbf-in"]] * 3
    np.testing.assert_allclose(read(file, case_with(wrist, columns=columns)).forces, wrench * factors, rtol=1e-7)


def test_scale_and_offset_of_struts_and_joints_are_in_the_unit_of_the_name(tmp_path: Path) -> None:
    counts = (RUN.struts * 1e3 - 700.0) / 0.005
    file = written(tmp_path, csv(np.column_stack([RUN.t, counts, RUN.forces]), ["t_s", *STRUTS, *BAR_FORCES]))
    case = case_with(scale=dict.fromkeys(STRUTS, 0.005), offset=dict.fromkeys(STRUTS, 700.0))
    np.testing.assert_allclose(read(file, case).drives, RUN.struts, rtol=1e-7)
    robot = load_case("ur10_wrist")
    q = np.random.default_rng(2).uniform(-1.0, 1.0, (RUN.count, 6))
    names = [f"q{k}_deg" for k in range(1, 7)]
    wrench = ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]
    numbers = np.column_stack([RUN.t, (np.degrees(q) - 90.0) / -0.01, RUN.forces])
    file = written(tmp_path, csv(numbers, ["t_s", *names, *wrench]), "robot.csv")
    case = case_with(robot, scale=dict.fromkeys(names, -0.01), offset=dict.fromkeys(names, 90.0))
    np.testing.assert_allclose(read(file, case).drives, q, atol=1e-7)


ATI = """Start Time: 11/26/26 3:12 PM
RDT Sample Rate: 1000
"PLEASE NOTE: The sample rate is read when the program starts."
Force Units: lbf
Counts per Unit Force: 10000.0
Torque Units: lbf-in
Counts per Unit Torque: 50000.0
Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time
"""
"""The header that the demonstration of a force/torque sensor's maker writes (ATI Net F/T, manual, chapter 5)."""


@pytest.mark.parametrize("stated", [{}, {"units": {"forces": "lbf", "moments": "lbf-in"}}])
def test_lines_of_a_header_state_units_and_counts(stated: dict[str, object], tmp_path: Path) -> None:
    wrist = load_case("ft_wrist")
    wrench = np.random.default_rng(8).normal(size=(30, 6))
    counts = np.rint(wrench / ([FORCES["lbf"] / 1e4] * 3 + [MOMENTS["lbf-in"] / 5e4] * 3)).astype(int)
    rows = [f"00000000, {k}, {k}, {', '.join(map(str, row))}, 3:12:07 PM" for k, row in enumerate(counts.tolist(), 1)]
    forces = written(tmp_path, ATI + "\n".join(rows) + "\n", "forces.csv")
    turns = written(
        tmp_path, csv(np.tile(np.eye(3).ravel(), (30, 1)), [f"r{i}{j}" for i in "123" for j in "123"]), "r.csv"
    )
    columns = dict(
        zip(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"), ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"], strict=True)
    )
    case = case_with(wrist, columns={}, files=[{"match": "forces*", "header_rows": 8, "columns": columns, **stated}])
    recording = read([forces, turns], case)
    np.testing.assert_allclose(recording.forces, wrench, atol=3e-4)
    assert not warnings(recording)


@pytest.mark.parametrize("unit", ["N/1000", "10 N", "0.1 N", "N x 10", "N*10", "1e-3 N"])
def test_a_unit_with_a_factor_is_not_taken_for_the_unit(unit: str, tmp_path: Path) -> None:
    labels = [f"{name} [{unit}]" for name in LABELS]
    with pytest.raises(RecordingError, match="not a known unit of forces"):
        read(with_forces(tmp_path, labels, RUN.forces), mapped(labels))


@pytest.mark.parametrize("unit", ["kN, filtered", "measured kN"])
def test_words_beside_a_unit_do_not_hide_it(unit: str, tmp_path: Path) -> None:
    labels = [f"{name} [{unit}]".replace(",", ";") for name in LABELS]
    np.testing.assert_allclose(read(with_forces(tmp_path, labels, RUN.forces / 1e3), mapped(labels)).forces, RUN.forces)


@pytest.mark.parametrize("name", ["actual_TCP_force_{}", "O_F_ext_hat_K[{}]", "wrench_compensated_{}"])
def test_signals_that_are_no_readings_are_named(name: str, tmp_path: Path) -> None:
    labels = [name.format(k) for k in range(6)]
    (said,) = warnings(read(with_forces(tmp_path, labels, RUN.forces), mapped(labels)))
    assert labels[0] in said
    assert "not a reading of the sensor" in said


def test_what_the_reader_doubts_stands_beside_what_the_estimate_refuses(tmp_path: Path) -> None:
    labels = [f"actual_TCP_force_{k}" for k in range(6)]
    file = with_forces(tmp_path, labels, np.zeros((RUN.count, 6)) + np.arange(6.0))
    case = mapped(labels)
    with pytest.raises(HexciteError, match=r"also: .*actual_TCP_force_0 is not a reading of the sensor") as caught:
        identify(read(file, case), case)
    one_line(caught.value)


@given(label=st.text(max_size=30), cell=st.text(max_size=10), header=st.lists(st.text(max_size=40), max_size=3))
def test_any_label_states_a_unit_of_its_quantity_or_one_that_is_refused(
    label: str, cell: str, header: list[str]
) -> None:
    for units in QUANTITIES:
        stated = stated_unit(label, cell, units, header)
        assert stated is None or stated.symbol is None or stated.symbol in units
