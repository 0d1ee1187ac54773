"""A look at files of unknown format: whatever names and units a recorder uses, the proposal reads the same run."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import RecordingFormat
from cases.schema import Case, load_case
from identification.looks.looking import look
from identification.machines.hexapod import Hexapod
from identification.recording.recording import read
from identification.samples.moving_window import checked_filter
from tests.bench.reliability.recordings import file_of, simulated

ROWS = 1200
KEYS = ("t", *(f"l{k}" for k in range(1, 7)), *(f"f{k}" for k in range(1, 7)), "trigger")


def run(case: Case) -> np.ndarray:
    """A smooth run at 1 kHz: time [s], strut lengths [mm], forces [N], trigger; shape (n, 14)."""
    t = np.arange(ROWS) * 1e-3
    phases = np.arange(6)
    assert case.machine is not None
    poses = case.machine.home.vector + 0.05 * np.sin(2 * np.pi * t[:, None] + phases)
    forces = 100.0 * np.sin(2 * np.pi * t[:, None] + phases) + 20.0 * phases
    trigger = (t > 0.2) & (t < 1.0)
    return np.column_stack([t, Hexapod.of(case).strut_lengths(poses) * 1e3, forces, trigger])


@dataclass(frozen=True)
class Written:
    """How a recorder writes a run: header lines, factors of time, lengths and forces, separator, decimal sign."""

    name: str
    head: Sequence[str]
    time: float = 1.0
    length: float = 1.0
    force: float = 1.0
    separator: str = ","
    decimal: str = "."
    encoding: str = "utf-8"
    end: str = ""
    tail: str = ""
    columns: Sequence[str] = field(default=KEYS)

    def write(self, table: np.ndarray, folder: Path) -> Path:
        scale = np.r_[self.time, np.full(6, self.length), np.full(6, self.force), 1.0]
        chosen = [KEYS.index(key) for key in self.columns]
        lines = [*self.head]
        for row in (table * scale)[:, chosen]:
            text = self.separator.join(f"{v:.9g}" for v in row) + self.end
            lines.append(text.replace(".", self.decimal) if self.decimal != "." else text)
        file = folder / self.name
        file.write_bytes(("\n".join(lines) + "\n" + self.tail).encode(self.encoding))
        return file


def _named(time: str, strut: str, force: str, trigger: str, separator: str = ",", first: int = 1) -> str:
    numbers = range(first, first + 6)
    names = [time, *(strut.replace("#", str(k)) for k in numbers), *(force.replace("#", str(k)) for k in numbers)]
    return separator.join([*names, trigger])


RECORDERS = [
    Written("ours.csv", [_named("t_s", "l#_mm", "f#_N", "trigger")]),
    Written(
        "german.csv", [_named("Zeit [ms]", "Strebe # [m]", "Kraft # [kN]", "Trigger", ";")],
        time=1e3, length=1e-3, force=1e-3, separator=";", decimal=",",
    ),
    Written(
        "units.txt",
        ["Recorder 2.1", _named("time", "Leg#", "F#", "gate", "\t"), "\t".join(["µs", *["mm"] * 6, *["N"] * 6, "-"])],
        time=1e6, separator="\t", encoding="cp1252",
    ),
    Written("ticks.csv", [_named("stamp", "joint.#.pos-fb", "loadcell-#", "motion.digital-out-00", first=0)], time=1e3),
    Written("volts.csv", [_named("t_s", "l#_mm", "f#_N", "trigger")]),
]  # fmt: skip


@pytest.mark.parametrize("recorder", RECORDERS, ids=lambda recorder: recorder.name)
def test_the_proposal_reads_the_run_that_was_recorded(recorder: Written, hexapod_case: Case, tmp_path: Path) -> None:
    table = run(hexapod_case)
    if recorder.name == "volts.csv":
        table[:, -1] *= 5.0
    file = recorder.write(table, tmp_path)
    found = look(file, hexapod_case)
    assert found.reads, found.odd
    settings = tomllib.loads(found.toml)["recording"]  # what a user pastes
    form = RecordingFormat.model_validate(settings)
    recording = read([file], hexapod_case.model_copy(update={"recording": form}))
    assert recording.t is not None
    assert recording.drives is not None
    assert recording.trigger is not None
    assert np.allclose(recording.t - recording.t[0], np.arange(ROWS) * 1e-3, atol=1e-6)
    assert np.allclose(recording.drives, table[:, 1:7] * 1e-3, atol=1e-7)
    assert np.allclose(recording.forces, table[:, 7:13], atol=1e-5)
    assert np.array_equal(recording.trigger, table[:, -1] > 0.5)
    assert found.rate == pytest.approx(1000.0, rel=1e-3)


def test_a_case_of_nothing_but_joints_and_bars_tells_struts(hexapod_case: Case, tmp_path: Path) -> None:
    bare = hexapod_case.model_copy(update={"workspace": None, "limits": None, "nominal": None, "controller": None})
    drives = Written("drives.csv", [_named("t_s", "enc_#", "f#_N", "trigger")], length=1e3)
    found = look(drives.write(run(hexapod_case), tmp_path), bare)
    assert found.reads, found.odd
    assert found.settings["units"] == {"struts": "um"}
    assert {c.ours for c in found.columns if c.guessed} == {f"l{k}_mm" for k in range(1, 7)}
    assert any("guessed" in sentence for sentence in found.odd)


def test_a_file_without_names_or_with_unknown_ones_is_to_be_completed(hexapod_case: Case, tmp_path: Path) -> None:
    table = run(hexapod_case)
    unknown = look(Written("unknown.csv", [_named("t", "a#", "ai#", "di1")]).write(table, tmp_path), hexapod_case)
    assert not unknown.reads
    assert any("l1_mm" in sentence for sentence in unknown.odd)
    sampler = Written("sampler.txt", [], separator=" ", end=" ", columns=KEYS[1:])
    settings = look(sampler.write(table, tmp_path), hexapod_case).settings
    assert settings["format"] == "halsampler"
    assert settings["column_names"] == [f"column {k}" for k in range(1, 14)]


def test_twincat_scope_is_known_by_its_header(hexapod_case: Case, tmp_path: Path) -> None:
    table = run(hexapod_case)
    names = [*(f"Strut{k}.ActPos" for k in range(1, 7)), *(f"Force{k}" for k in range(1, 7)), "Trigger"]
    lines = ["Name\tScope", "", "\t".join(["Name", *names]), "\t".join(["Offset", *["0"] * 13])]
    lines += ["\t".join(f"{v:.9g}".replace(".", ",") for v in row * np.r_[1e3, np.ones(13)]) for row in table]
    file = tmp_path / "scope.csv"
    file.write_text("\n".join([*lines, "EOF"]) + "\n")
    found = look(file, hexapod_case)
    assert found.reads, found.odd
    assert found.settings["format"] == "twincat-scope"
    assert found.settings["decimal"] == ","
    assert found.rate == pytest.approx(1000.0, rel=1e-3)


def test_a_clock_that_goes_back_is_noticed(hexapod_case: Case, tmp_path: Path) -> None:
    table = run(hexapod_case)
    table[600, 0] = table[598, 0]
    found = look(RECORDERS[0].write(table, tmp_path), hexapod_case)
    assert not found.reads
    assert any("time must increase" in sentence for sentence in found.odd)


def test_standstills_have_no_clock_and_need_none(wrist_case: Case, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    turns = np.linalg.qr(rng.normal(size=(12, 3, 3)))[0]
    turns *= np.sign(np.linalg.det(turns))[:, None, None]
    names = ["fx", "fy", "fz", "tx", "ty", "tz", *(f"r{i}{j}" for i in "123" for j in "123")]
    rows = np.column_stack([rng.normal(size=(12, 6)), turns.reshape(12, 9)])
    file = tmp_path / "standstills.csv"
    file.write_text("\n".join([",".join(names), *(",".join(f"{v:.8f}" for v in row) for row in rows)]) + "\n")
    found = look(file, wrist_case)
    assert found.reads, found.odd
    assert found.settings["columns"]["mx_Nm"] == "tx"
    assert found.rate is None


@pytest.mark.parametrize(
    ("head", "tick", "separator"),
    [
        (["timestamp", *(f"actual_q_{k}" for k in range(6)), *(f"ft_{c}{axis}" for c in "FT" for axis in "xyz")],
         1.0, " "),
        (["time_ns", *(f"{name}_joint" for name in ("base", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3")),
          *(f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz")], 1e9, ","),
    ],
    ids=["robot", "ros"],
)  # fmt: skip
def test_joints_of_a_robot_are_known_by_number_and_by_name(
    head: list[str], tick: float, separator: str, tmp_path: Path
) -> None:
    case = load_case("ur10_wrist")
    assert case.chain is not None
    t = np.arange(900) * 0.002
    joints = case.chain.home + 0.2 * np.sin(2.0 * np.pi * t[:, None] + np.arange(6))
    forces = 5.0 * np.sin(t[:, None] + np.arange(6))
    rows = np.column_stack([np.round(t * tick) if tick > 1.0 else t, joints, forces])
    file = tmp_path / "robot.csv"
    file.write_text(
        "\n".join([separator.join(head), *(separator.join(f"{v:.10g}" for v in row) for row in rows)]) + "\n"
    )
    found = look(file, case)
    assert found.reads, found.odd
    settings = tomllib.loads(found.toml)["recording"]
    assert settings["units"] == {"joints": "rad"}
    recording = read([file], case.model_copy(update={"recording": RecordingFormat.model_validate(settings)}))
    assert np.allclose(recording.forces, forces, atol=1e-8)


@pytest.mark.parametrize(
    ("content", "fact"),
    [
        (b"this is\nno recording, at all\n", "no table of numbers"),
        (b"\xff\xfe" + b"\x00\xd8" * 40, "damaged text in UTF-16"),
        (bytes(range(256)) * 20, "not text"),
        (b"", "empty"),
        (b"t,f1,f2\n" + b"0,5,1,5,2,5\n" * 9, "rows of 6 fields below 3 names: commas"),
    ],
    ids=["prose", "utf-16", "binary", "empty", "commas"],
)
def test_what_is_not_a_table_is_refused_in_a_line(content: bytes, fact: str, tmp_path: Path) -> None:
    file = tmp_path / "file.csv"
    file.write_bytes(content)
    with pytest.raises(RecordingError, match=fact) as error:
        look(file)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_of_another_machine_is_looked_at(wrist_case: Case, tmp_path: Path) -> None:
    """Bars of a hexapod may be a wrist's channels; joints in degrees are no drives in mm; a time in minutes is none."""
    rows = "\n".join(f"{k / 1000:.3f}" + ",1" * 12 for k in range(400))
    names = [*(f"q{k}_deg" for k in range(1, 7)), *(f"f{k}_N" for k in range(1, 7))]
    file = tmp_path / "file.csv"
    file.write_text(f"t_s,{','.join(names)}\n{rows}\n")
    assert set(look(file, wrist_case).settings["columns"].values()) == {f"f{k}_N" for k in range(1, 7)}
    assert "columns" not in look(file).settings
    file.write_text(f"time [m],{','.join(names)}\n{rows}\n")
    assert look(file).rate == pytest.approx(1000.0)


def test_an_empty_parquet_file_is_not_read(hexapod_case: Case, tmp_path: Path) -> None:
    pq.write_table(pa.table({f"l{k}_mm": np.zeros(0) for k in range(1, 7)}), tmp_path / "file.parquet")
    assert not look(tmp_path / "file.parquet", hexapod_case).reads


def test_a_slow_recording_gets_a_low_pass_that_its_rate_carries(hexapod_case: Case, tmp_path: Path) -> None:
    """At most a fifth of 50 Hz; the case has 40 Hz. At 50 Hz nobody takes seconds for milliseconds."""
    file = RECORDERS[0].write(run(hexapod_case)[::20], tmp_path)
    recording = read(file, hexapod_case)
    with pytest.raises(RecordingError, match=r"too high .*\b50 samples.*at most 10$"):
        checked_filter(recording, hexapod_case)
    form = RecordingFormat(filter_cutoff_Hz=look(file, hexapod_case).settings["filter_cutoff_Hz"])
    assert checked_filter(recording, hexapod_case.model_copy(update={"recording": form})).cutoff > 5.0


def test_what_a_case_states_of_a_trace_stays_valid(hexapod_case: Case, tmp_path: Path) -> None:
    """A format that needs the unit of the clock keeps it, though it is the usual one."""
    names = ["time", *(f"/Nck/!SD/nckServoDataActPos1stEnc64 [u1, {k}]" for k in range(1, 7))]
    names += [*(f"/Channel/!RP/rpa [u1, {k}]" for k in range(1, 7)), "/Nck/!S/anAOut [u1, 1]"]
    file = Written("trace.csv", [",".join(f'"{name}"' for name in names)]).write(run(hexapod_case), tmp_path)
    says = {"format": "sinumerik-trace", "delimiter": ",", "decimal": ".", "header_rows": 1, "clock": {"unit": "s"}}
    columns = dict(zip([f"l{k}_mm" for k in range(1, 7)] + [f"f{k}_N" for k in range(1, 7)], names[1:13], strict=True))
    form = RecordingFormat.model_validate(says | {"columns": columns | {"t_s": "time"}, "filter_cutoff_Hz": 40.0})
    found = look(file, hexapod_case.model_copy(update={"recording": form}))
    assert found.reads, found.odd
    assert found.settings["clock"] == {"unit": "s"}


def test_a_case_that_reads_an_export_as_plain_text_is_left_alone(hexapod_case: Case, tmp_path: Path) -> None:
    """The Scope's header is known, and what the case says of it by hand stays right."""
    table = run(hexapod_case)
    lines = ["Name\tScope", "", "\t".join(["Name", *(f"ch{k}" for k in range(13))])]
    lines += ["\t".join(f"{v:.9g}".replace(".", ",") for v in row * np.r_[1e3, np.ones(13)]) for row in table]
    file = tmp_path / "scope.csv"
    file.write_text("\n".join(lines) + "\n")
    names = ["t_s", *(f"l{k}_mm" for k in range(1, 7)), *(f"f{k}_N" for k in range(1, 7)), "trigger"]
    says = {"delimiter": "\t", "decimal": ",", "header_rows": 3, "column_names": names, "clock": {"unit": "ms"}}
    form = RecordingFormat.model_validate(says | {"filter_cutoff_Hz": 40.0})
    found = look(file, hexapod_case.model_copy(update={"recording": form}))
    assert found.reads, found.odd
    assert found.unchanged


def test_a_run_in_two_files_of_two_recorders_gets_a_table_for_each(hexapod_case: Case, tmp_path: Path) -> None:
    """Struts of LinuxCNC without names, forces of an amplifier with commas; alone, either is half a run."""
    table = run(hexapod_case)
    names = ("trigger", *(f"l{k}_mm" for k in range(1, 7)))
    case = hexapod_case.model_copy(
        update={"recording": RecordingFormat.model_validate(
            {"filter_cutoff_Hz": 40.0, "format": "halsampler", "column_names": names, "clock": {"period_ms": 1.0}}
        )}
    )  # fmt: skip
    struts = tmp_path / "struts_c0.txt"
    rows = np.column_stack([np.arange(ROWS), table[:, -1], table[:, 1:7]])
    struts.write_text("".join(" ".join(f"{v:.9g}" for v in row) + " \n" for row in rows))
    forces = Written(
        "forces_1.csv", [";".join(["Zeit [ms]", *(f"Kraft {k} [N]" for k in range(1, 7)), "Trigger"])],
        time=1e3, separator=";", decimal=",", columns=("t", *KEYS[7:13], "trigger"),
    ).write(table, tmp_path)  # fmt: skip
    found = look([struts, forces], case)
    assert found.reads, found.odd
    assert {c.name: c.ours for c in found.columns if c.name in names} == {name: name for name in names}
    settings = tomllib.loads(found.toml)["recording"]
    assert [file["match"] for file in settings["files"]] == ["struts_c*.txt", "forces_*.csv"]
    assert "period_ms" not in settings["files"][1]["clock"]  # it has stamps of its own
    read_with = RecordingFormat.model_validate(settings)
    recording = read([struts, forces], case.model_copy(update={"recording": read_with}))
    assert np.allclose(recording.forces, table[:, 7:13], atol=1e-5)
    again = look([forces, struts], case.model_copy(update={"recording": read_with}))
    assert again.reads
    assert again.unchanged
    for half in (struts, forces):
        alone = look(half, case)
        assert not alone.reads
        assert any("OTHER" in sentence for sentence in alone.odd)


@pytest.mark.parametrize(
    ("head", "limits", "unit"),
    [("A,C", 60.0, None), ("A,C", 1.0, "rad"), ("A [deg],C [deg]", 1.0, "doubt")],
    ids=["degrees beyond any radians", "radians within the ends", "degrees that are radians"],
)
def test_the_unit_of_joints_is_that_in_which_the_machine_can_be_there(
    head: str, limits: float, unit: str | None, tmp_path: Path
) -> None:
    """Ends and home of the machine decide, not the size of the numbers alone."""
    data = load_case("five_axis_table").model_dump(exclude_none=True)
    joints = [dict(joint) for joint in data["machine"]["chain"]["joints"]]
    joints[3] |= {"position_deg": (-90.0, 90.0), "home_deg": 45.0}
    data["machine"]["chain"]["joints"] = joints
    case = Case.model_validate({k: data[k] for k in ("schema_version", "name", "title", "setup", "gravity_m_s2",
                                                     "sensor_frame", "sensors", "machine", "recording")})  # fmt: skip
    t = np.arange(600) / 500.0
    turning = np.column_stack([0.8 + 0.2 * np.sin(t), 0.2 * np.sin(t)]) * limits
    rows = np.column_stack([t, np.tile(50.0 * np.sin(t)[:, None], 3), turning, np.ones((600, 6)) * np.sin(t)[:, None]])
    file = tmp_path / "run.csv"
    names = f"Time,X,Y,Z,{head},Fx,Fy,Fz,Mx,My,Mz"
    file.write_text("\n".join([names, *(",".join(f"{v:.8g}" for v in row) for row in rows)]) + "\n")
    found = look(file, case)
    assert found.reads, found.odd
    assert found.settings.get("units", {}).get("joints") == (unit if unit != "doubt" else None)
    assert any("recording.units.joints = 'rad'" in sentence for sentence in found.odd) == (unit == "doubt")


@pytest.mark.parametrize("kind", ["date", "time of day"])
def test_dates_and_times_of_day_are_a_clock(kind: str, hexapod_case: Case, tmp_path: Path) -> None:
    """They need no unit, and go on after midnight."""
    table = run(hexapod_case)
    begin = np.datetime64("2026-03-05T23:59:59.500")
    stamps = [str(begin + np.timedelta64(k, "ms")).replace("T", " ") for k in range(ROWS)]
    stamps = [stamp.split()[1] for stamp in stamps] if kind == "time of day" else stamps
    rows = [f"{stamp},{','.join(f'{v:.9g}' for v in row[1:])}" for stamp, row in zip(stamps, table, strict=True)]
    file = tmp_path / "run.csv"
    file.write_text("\n".join([_named("Timestamp", "Strut # [mm]", "Force # [N]", "Trigger"), *rows]) + "\n")
    found = look(file, hexapod_case)
    assert found.reads, found.odd
    assert found.settings["columns"]["t_s"] == "Timestamp"
    assert "clock" not in found.settings
    assert found.rate == pytest.approx(1000.0, rel=1e-6)


def test_a_bit_that_alone_changes_is_the_trigger(hexapod_case: Case, tmp_path: Path) -> None:
    """A gripper holds output 8 on all along, the program switches output 2."""
    table = run(hexapod_case)
    table[:, -1] = 256.0 + 4.0 * table[:, -1]
    file = Written("run.csv", [_named("t_s", "l#_mm", "f#_N", "actual_digital_output_bits")]).write(table, tmp_path)
    found = look(file, hexapod_case)
    assert found.reads, found.odd
    assert found.settings["trigger"] == {"column": "actual_digital_output_bits", "bit": 2}
    assert "trigger" not in found.settings.get("columns", {})
    form = RecordingFormat.model_validate(tomllib.loads(found.toml)["recording"])
    recording = read([file], hexapod_case.model_copy(update={"recording": form}))
    assert np.array_equal(recording.trigger, table[:, -1] > 256.0)
    assert look(file, hexapod_case.model_copy(update={"recording": form})).unchanged


def test_a_run_that_identify_refuses_is_said_to_be(hexapod_case: Case, tmp_path: Path) -> None:
    """A standstill is read, for tare and force; a run that moves is not doubted."""
    moving = tmp_path / "moving.csv"
    moving.write_bytes(file_of(simulated().rows))
    assert not any("identify refuses" in odd for odd in look(moving, hexapod_case).odd)
    table = run(hexapod_case)
    table[:, 1:7] = table[0, 1:7]
    found = look(RECORDERS[0].write(table, tmp_path), hexapod_case)
    assert found.reads, found.odd
    assert any("identify refuses" in odd and "constant" in odd for odd in found.odd)


def test_time_stamps_that_are_infinite_are_one_line(hexapod_case: Case, tmp_path: Path) -> None:
    table = run(hexapod_case)
    table[0, 0] = np.inf
    found = look(RECORDERS[0].write(table, tmp_path), hexapod_case)
    assert not found.reads
    assert "inf" in str(found.problem)


def test_units_that_the_case_states_stay_where_labels_say_others(hexapod_case: Case, tmp_path: Path) -> None:
    """Also usual ones: the labels would be refused without them."""
    file = tmp_path / "run.csv"
    head = ",".join(["t_s", *(f"l{k} [a.u.]" for k in range(1, 7)), *(f"f{k}_N" for k in range(1, 7)), "trigger"])
    rows = file_of(simulated().rows).decode().split("\n", 1)[1]
    file.write_text(f"{head}\n{rows}")
    form = RecordingFormat.model_validate(
        {
            "columns": {f"l{k}_mm": f"l{k} [a.u.]" for k in range(1, 7)},
            "units": {"struts": "mm"},
            "filter_cutoff_Hz": 40.0,
        }
    )
    found = look(file, hexapod_case.model_copy(update={"recording": form}))
    assert found.reads, found.odd
    assert found.unchanged


def test_a_unit_that_is_proposed_is_not_called_the_case_s(hexapod_case: Case, tmp_path: Path) -> None:
    """Labels say s, the steps of the stamps can only be ms: the proposal says so, until the case does."""
    head = "Time [s]," + ",".join([*(f"l{k}_mm" for k in range(1, 7)), *(f"f{k}_N" for k in range(1, 7)), "trigger"])
    file = Written("run.csv", [head], time=2e3).write(run(hexapod_case), tmp_path)
    found = look(file, hexapod_case)
    assert found.settings["clock"]["unit"] == "ms", found.odd
    (said,) = [line for line in found.odd if "recording.clock.unit" in line and "which is used" in line]
    assert "proposed here" in said
    assert not any("of the case says" in line for line in (said, *found.repairs))
    form = RecordingFormat.model_validate(dict(found.settings))
    (said,) = [
        line for line in look(file, hexapod_case.model_copy(update={"recording": form})).odd if "is used" in line
    ]
    assert "recording.clock.unit of the case says ms" in said


def test_columns_without_names_are_told_by_their_values_and_not_proposed(hexapod_case: Case, tmp_path: Path) -> None:
    rows = np.column_stack([simulated().rows, np.full(len(simulated().rows), 7.0)])
    file = tmp_path / "headless.csv"
    file.write_text("\n".join(",".join(f"{v:.9g}" for v in row) for row in rows) + "\n")
    found = look(file, hexapod_case)
    assert not found.reads
    told = {odd.split(" has no name: ")[0]: odd for odd in found.odd if " has no name: " in odd}
    assert "rises by 0.001" in told["column 1"]
    assert all("smooth" in told[f"column {k}"] for k in range(2, 8))
    assert all("noise" in told[f"column {k}"] for k in range(8, 14))
    assert "switch" in told["column 14"]
    assert "7 all along" in told["column 15"]
    assert not any(column.ours for column in found.columns)


def test_each_guess_has_its_reason(hexapod_case: Case, tmp_path: Path) -> None:
    head = _named("stamp", "enc_#", "loadcell-#", "out", ";")
    recorder = Written("guess.csv", ["", head], time=1e3, length=1e-3, separator=";", decimal=",")
    found = look(recorder.write(run(hexapod_case), tmp_path), hexapod_case)
    columns = {column.ours: column for column in found.columns}
    assert "run on" in columns["t_s"].reason
    assert "1000 rows a second" in columns["t_s"].unit_reason
    assert columns["l3_mm"].guessed
    assert "lengths that the struts can have" in columns["l3_mm"].unit_reason
    assert "name" in columns["f2_N"].reason
    assert all(column.reason for column in found.columns if column.ours)
    assert not any(column.reason or column.unit_reason for column in found.columns if not column.ours)
    (part,) = found.parts
    assert part.table is None
    assert {*found.settings} == {*part.reasons}
    assert "line 3 " in part.reasons["header_rows"]
    stated = RecordingFormat.model_validate(dict(found.settings))
    again = look(found.file, hexapod_case.model_copy(update={"recording": stated}))
    assert {again.parts[0].reasons[key] for key in ("delimiter", "columns", "units")} == {"the case states it"}
    assert next(c for c in again.columns if c.ours == "l3_mm").reason == "the case names it"


def test_what_the_reader_mends_is_listed(hexapod_case: Case, tmp_path: Path) -> None:
    table = np.delete(run(hexapod_case), [500, 501], axis=0)
    table[700, 8] = np.nan
    found = look(RECORDERS[0].write(table, tmp_path), hexapod_case)
    assert any("2 samples are missing" in each and "501" in each for each in found.repairs)
    assert any("no measured value in f2_N" in each and "702" in each for each in found.repairs)
    whole = look(RECORDERS[0].write(run(hexapod_case), tmp_path), hexapod_case)
    assert not any("missing" in each or "no measured" in each for each in whole.repairs)


def test_a_layout_that_the_case_states_is_used_where_it_reads(hexapod_case: Case, tmp_path: Path) -> None:
    units = ",".join(["s", *["mm"] * 6, *["N"] * 6, "-"])
    file = Written("two.csv", [_named("a", "b#", "c#", "d"), _named("time", "Leg#", "F#", "gate"), units]).write(
        run(hexapod_case), tmp_path
    )
    usual = look(file, hexapod_case)
    assert usual.settings["names_row"] == 2

    def stating(**layout: int) -> Case:
        form = hexapod_case.recording.model_copy(update=layout)
        return hexapod_case.model_copy(
            update={"recording": RecordingFormat.model_validate(form.model_dump(exclude_unset=True) | layout)}
        )

    short = look(file, stating(header_rows=5, names_row=2))  # two samples are left out, by the case's word
    assert short.reads
    assert short.settings["header_rows"] == 5
    assert short.parts[0].reasons["header_rows"] == "the case states it"
    assert short.rows == usual.rows - 2
    wrong = look(file, stating(header_rows=1))
    assert wrong.reads
    assert wrong.settings["header_rows"] == usual.settings["header_rows"]


def test_a_folder_of_a_run_means_its_recording_and_other_folders_are_refused(
    hexapod_case: Case, tmp_path: Path
) -> None:
    run = np.column_stack([np.arange(4.0), *(np.full(4, k) for k in range(6))])
    (tmp_path / "run").mkdir()
    np.savetxt(
        tmp_path / "run" / "recording.csv", run, delimiter=",", comments="", header="t_s,f1_N,f2_N,f3_N,f4_N,f5_N,f6_N"
    )
    seen = look(tmp_path / "run", hexapod_case)
    assert seen.parts[0].file == tmp_path / "run" / "recording.csv"
    assert seen.rows == 4
    (tmp_path / "other" / "deeper").mkdir(parents=True)
    with pytest.raises(RecordingError, match=r"other/recording\.csv"):
        look(tmp_path / "other", hexapod_case)
    (tmp_path / "other" / "deeper" / "recording.csv").mkdir()
    with pytest.raises(RecordingError, match=r"deeper.*it is a folder"):
        look([tmp_path / "other" / "deeper"], hexapod_case)


OF_ANOTHER_FILE = {"columns": {f"f{k}_N": f"Axis{k}.Force" for k in range(1, 7)}, "filter_cutoff_Hz": 40.0}


@pytest.mark.parametrize(("label", "factor", "kept"), [("kN", 1e-3, "N"), ("N", 1.0, "kN")])
def test_a_label_counts_before_a_unit_that_is_kept_of_another_file(
    label: str, factor: float, kept: str, hexapod_case: Case, tmp_path: Path
) -> None:
    """The proposal reads the forces that were recorded, and says that the kept key changes."""
    table = run(hexapod_case)
    head = _named("Zeit [ms]", "Strebe # [mm]", f"Kraft # [{label}]", "Trigger")
    file = Written("run.csv", [head], time=1e3, force=factor).write(table, tmp_path)
    stated = RecordingFormat.model_validate({**OF_ANOTHER_FILE, "units": {"forces": kept}})
    found = look(file, hexapod_case.model_copy(update={"recording": stated}))
    assert found.reads, found.odd
    (said,) = [line for line in found.odd if "recording.units.forces" in line]
    assert "label_over_kept" in {entry["code"] for entry in found.to_json()["odd_phrases"]}, said
    form = RecordingFormat.model_validate(dict(found.settings))
    recording = read([file], hexapod_case.model_copy(update={"recording": form}))
    assert np.allclose(recording.forces, table[:, 7:13], atol=1e-5)
    again = look(file, hexapod_case.model_copy(update={"recording": form}))
    assert again.unchanged
    assert not [line for line in again.odd if "recording.units.forces" in line]


def test_a_label_that_values_exclude_does_not_count_before_a_kept_unit(hexapod_case: Case, tmp_path: Path) -> None:
    """Labels say mm, the values are lengths of this machine in m only, as the case says."""
    head = _named("Zeit [ms]", "Strebe # [mm]", "Kraft # [N]", "Trigger")
    file = Written("run.csv", [head], time=1e3, length=1e-3).write(run(hexapod_case), tmp_path)
    stated = RecordingFormat.model_validate({**OF_ANOTHER_FILE, "units": {"struts": "m"}})
    found = look(file, hexapod_case.model_copy(update={"recording": stated}))
    assert found.reads, found.odd
    assert found.settings["units"] == {"struts": "m"}


def test_a_kept_unit_that_puts_every_force_out_of_range_goes(hexapod_case: Case, tmp_path: Path) -> None:
    """No label states a unit: that which fits the sensors' range is proposed, and named beside the kept one."""
    table = run(hexapod_case)
    file = Written("run.csv", [_named("Zeit [ms]", "Strebe # [mm]", "F#", "Trigger")], time=1e3).write(table, tmp_path)
    stated = RecordingFormat.model_validate({**OF_ANOTHER_FILE, "units": {"forces": "kN"}})
    case = hexapod_case.model_copy(update={"recording": stated})
    assert case.sensors.range_N is not None
    found = look(file, case)
    assert found.reads, found.odd
    assert "forces" not in found.settings.get("units", {})
    (said,) = [line for line in found.odd if "recording.units.forces" in line]
    assert "kept_out_of_range" in {entry["code"] for entry in found.to_json()["odd_phrases"]}, said
    form = RecordingFormat.model_validate(dict(found.settings))
    recording = read([file], case.model_copy(update={"recording": form}))
    assert np.allclose(recording.forces, table[:, 7:13], atol=1e-5)


@pytest.mark.parametrize(
    ("key", "stated"),
    [
        ("recording.units.struts", {"units": {"struts": "m"}}),
        ("recording.clock.unit", {"clock": {"unit": "us"}}),
    ],
)
def test_a_kept_unit_that_values_exclude_goes(
    key: str, stated: dict[str, object], hexapod_case: Case, tmp_path: Path
) -> None:
    """No label states a unit: struts that the machine does not have, or a clock of no recorder, are not proposed."""
    table = run(hexapod_case)
    file = Written("run.csv", [_named("time", "Axis#", "F#", "Trigger")]).write(table, tmp_path)
    case = hexapod_case.model_copy(update={"recording": RecordingFormat.model_validate({**OF_ANOTHER_FILE, **stated})})
    found = look(file, case)
    assert found.reads, found.odd
    (said,) = [line for line in found.odd if key in line]
    assert "kept_excluded" in {entry["code"] for entry in found.to_json()["odd_phrases"]}, said
    recording = read([file], case.model_copy(update={"recording": RecordingFormat.model_validate(found.settings)}))
    assert recording.t is not None
    assert recording.drives is not None
    assert np.allclose(recording.t - recording.t[0], np.arange(ROWS) * 1e-3, atol=1e-6)
    assert np.allclose(recording.drives, table[:, 1:7] * 1e-3, atol=1e-7)


@pytest.mark.parametrize(
    ("kept", "factor", "goes"), [("rad", 1.0, True), ("deg", 1.0, False), ("rad", np.pi / 180, False)]
)
def test_kept_units_of_joints_go_where_the_joints_cannot_reach(
    kept: str, factor: float, goes: bool, tmp_path: Path
) -> None:
    """Joints of 40 to 130 degrees: as radians they are turns that no joint of this robot has."""
    case = load_case("ur10_wrist")
    assert case.chain is not None
    t = np.arange(ROWS) * 2e-3
    home = np.rad2deg([joint.home for joint in case.chain.joints])
    q = home + 20.0 * np.sin(2 * np.pi * 0.5 * t[:, None] + np.arange(len(home)))
    wrench = np.sin(2 * np.pi * 0.7 * t[:, None] + np.arange(6))
    head = ["time", *(f"joint {k}" for k in range(1, 7)), "Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
    file = tmp_path / "run.csv"
    np.savetxt(file, np.column_stack([t, q * factor, wrench]), delimiter=",", comments="", header=",".join(head))
    columns = {"fx_N": "Other.Fx"}
    stated = RecordingFormat.model_validate({"columns": columns, "units": {"joints": kept}})
    found = look(file, case.model_copy(update={"recording": stated}))
    codes = {entry["code"] for entry in found.to_json()["odd_phrases"]}
    assert ("kept_excluded" in codes) is goes, found.odd
    recording = read([file], case.model_copy(update={"recording": RecordingFormat.model_validate(found.settings)}))
    assert recording.drives is not None
    assert np.allclose(recording.drives, np.deg2rad(q), atol=1e-6)


@pytest.mark.parametrize("labels", [("O [deg]", "A [deg]", "T [deg]"), ("roll", "pitch", "yaw")])
def test_a_sensor_that_is_turned_needs_no_other_file_and_no_angle_is_a_time(
    labels: tuple[str, ...], tmp_path: Path
) -> None:
    draw = np.random.default_rng(4)
    turns = np.degrees(draw.uniform([-3.0, 0.1, -3.0], [3.0, 1.5, 3.0], (12, 3)))
    rows = np.column_stack([turns, draw.normal(size=(12, 6))])
    text = [",".join([*labels, *load_case("ft_wrist").sensor_frame.channels])]
    file = tmp_path / "standstills.csv"
    file.write_text("\n".join([*text, *(",".join(f"{v:.9g}" for v in row) for row in rows)]))
    case = load_case("ft_wrist").model_copy(update={"recording": RecordingFormat()})
    result = look(file, case)
    assert result.reads
    assert not any("OTHER" in doubt or "by the name a time" in doubt for doubt in result.odd)


def test_positions_in_metres_are_seen_by_where_home_is(tmp_path: Path) -> None:
    case = load_case("hexapod")
    assert case.hexapod is not None
    t = np.arange(400) * 1e-3
    poses = case.hexapod.home.vector + 0.02 * np.sin(2.0 * np.pi * t[:, None] + np.arange(6))
    rows = np.column_stack([t, poses[:, :3], np.degrees(poses[:, 3:]), np.sin(9.0 * t[:, None] + np.arange(6))])
    names = ["t_s", "X", "Y", "Z", "roll", "pitch", "yaw", *case.sensor_frame.channels]
    file = tmp_path / "run.csv"
    file.write_text("\n".join([",".join(names), *(",".join(f"{v:.9g}" for v in row) for row in rows)]))
    result = look(file, case)
    assert result.settings["units"] == {"positions": "m"}
    assert "in m;" in " ".join(result.odd)
    recording = read(file, case.model_copy(update={"recording": RecordingFormat.model_validate(result.settings)}))
    assert recording.drives is not None
    assert np.allclose(recording.drives, Hexapod.of(case).strut_lengths(poses), atol=1e-6)
