"""CSV exports of TwinCAT Scope, in the layouts of genuine files: header, clocks, missing fields, decimal comma, EOF."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from identification.looks.looking import look
from identification.recording.recording import Recording, read
from tests.helpers import refused_at
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, case_with, number, written

RUN = Truth()
STRUTS = [f"MAIN.strut[{k}]" for k in range(1, 7)]
FORCES = [f"force {k}" for k in range(1, 7)]
COLUMNS = dict(zip(NAMES[1:], [*STRUTS, *FORCES], strict=True))
FILETIME = 132_959_733_843_760_000
Group = tuple[list[str], np.ndarray, np.ndarray]  # channels, their stamps, their values, shape (n, channels)


def exported(
    groups: list[Group], delimiter: str = "\t", decimal: str = ",", shared: bool = True, eof: bool = True
) -> str:
    """An export: `shared` with one clock for neighbours, else one for each channel."""
    if not shared:
        groups = [([n], t, v[:, [k]]) for names, t, v in groups for k, n in enumerate(names)]
    d = delimiter
    lines = [
        f"Name{d}Scope Project{d}", f"File{d}C:\\TwinCAT\\run.csv{d}",
        f"Starttime of export{d}{FILETIME}{d}Montag, 2. Mai 2022{d}15:56:24.376",
        f"Endtime of export{d}{FILETIME + 9990000}{d}Montag, 2. Mai 2022{d}15:56:25.375", "", "",
    ]  # fmt: skip
    for key in ("Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "Port", "Unit"):
        cells = {"Name": None, "SymbolComment": "", "Data-Type": "REAL64", "SampleTime[ms]": "0,2", "Port": "851"}
        lines.append(
            d.join(
                d.join([key, *((n if key == "Name" else cells.get(key, "(None)")) for n in names)])
                for names, _, _ in groups
            )
        )
    lines.append("")
    for row in range(max(len(t) for _, t, _ in groups)):
        fields = []
        for names, t, values in groups:
            there = row < len(t)
            fields += [number(v, decimal) for v in (t[row], *values[row])] if there else [" "] * (len(names) + 1)
        while fields[-1] == " ":
            fields.pop()
        lines.append(d.join(fields))
    return "\n".join([*lines, *["EOF"] * eof]) + "\n"


def both(stamps: np.ndarray = 1e3 * RUN.t) -> list[Group]:
    return [(STRUTS, stamps, RUN.struts * 1e3), (FORCES, stamps, RUN.forces)]


def case(**says: object):
    return case_with(**{"format": "twincat-scope", "decimal": ",", "columns": COLUMNS, **says})


def require_the_run(recording: Recording) -> None:
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)


@pytest.mark.parametrize("delimiter", ["\t", ";"])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("eof", [True, False])
def test_an_export_is_read_whatever_its_settings(
    delimiter: str, decimal: str, shared: bool, eof: bool, tmp_path: Path
) -> None:
    file = written(tmp_path, exported(both(), delimiter, decimal, shared, eof))
    require_the_run(read(file, case(decimal=decimal)))


def test_a_channel_that_was_not_recorded_hides_none_of_the_others(tmp_path: Path) -> None:
    empty: Group = (["override"], np.zeros(0), np.zeros((0, 1)))
    file = written(tmp_path, exported([*both(), empty]))
    require_the_run(read(file, case(columns={**COLUMNS, "override_percent": "override"})))


def test_separated_by_commas_it_has_points(tmp_path: Path) -> None:
    """The header keeps the decimal commas of the system's language, so that its lines have odd numbers of fields."""
    text = exported(both(), ",", ".")
    require_the_run(read(written(tmp_path, text), case(decimal=".")))


def test_stamps_may_be_filetimes(tmp_path: Path) -> None:
    text = exported(both(np.arange(RUN.count)))
    head, rows = text.split("\n\n0\t", 1)
    lines = []
    for line in ("0\t" + rows).splitlines()[:-1]:
        fields = line.split("\t")
        for k in (0, 7):
            fields[k] = str(FILETIME + 10_000 * int(fields[k]))
        lines.append("\t".join(fields))
    file = written(tmp_path, head + "\n\n" + "\n".join(lines))
    require_the_run(read(file, case(clock={"unit": "filetime"})))


@pytest.mark.parametrize("shared", [True, False])
def test_channels_of_another_rate_are_a_stream_of_their_own(shared: bool, tmp_path: Path) -> None:
    """Forces at 1 kHz, struts at 250 Hz from 0.5 ms on: their fields end earlier, in the middle of the lines."""
    slow = RUN.struts[::4]
    groups = [(FORCES[:3], 1e3 * RUN.t, RUN.forces[:, :3]), (STRUTS, 0.5 + 4.0 * np.arange(len(slow)), slow * 1e3)]
    groups.append((FORCES[3:], 1e3 * RUN.t, RUN.forces[:, 3:]))
    recording = read(written(tmp_path, exported(groups, shared=shared)), case())
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    (other,) = recording.others
    np.testing.assert_allclose(other.drives, slow, rtol=1e-8)
    np.testing.assert_allclose(other.t, 0.5e-3 + 4e-3 * np.arange(len(slow)), atol=1e-9)
    assert recording.drives is None
    assert recording.stream_with("drives") is other


def test_a_channel_that_ends_a_sample_early_shortens_its_group(tmp_path: Path) -> None:
    groups = [(STRUTS, 1e3 * RUN.t, RUN.struts * 1e3), (FORCES, 1e3 * RUN.t[:-1], RUN.forces[:-1])]
    recording = read(written(tmp_path, exported(groups)), case())
    np.testing.assert_allclose(recording.drives, RUN.struts[:-1], rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces[:-1], rtol=1e-8)


def test_a_comment_of_several_lines_does_no_harm(tmp_path: Path) -> None:
    text = exported(both()).replace("\nData-Type", "(* length\n\n of strut 1\n12 *)\nData-Type", 1)
    require_the_run(read(written(tmp_path, text), case()))


def test_a_long_export_is_read_whole(tmp_path: Path) -> None:
    long = Truth(count=70_000)
    groups = [(STRUTS, 1e3 * long.t, long.struts * 1e3), (FORCES, 1e3 * long.t, long.forces)]
    recording = read(written(tmp_path, exported(groups)), case())
    np.testing.assert_allclose(recording.t, long.t, atol=1e-9)
    np.testing.assert_allclose(recording.forces, long.forces, rtol=1e-8)


GOOD = exported(both())
LINES = GOOD.splitlines()
HEADER = 13
DAMAGES = {
    "another format": ("t_s,l1_mm\n0,1\n", {}, r"no two lines that start with Name.*recording.format"),
    "no header of channels": ("\n".join([*LINES[:4], "", *LINES[13:]]), {}, r"no two lines that start with Name"),
    "no rows": ("\n".join(LINES[:HEADER]), {}, r"rows of numbers below"),
    "no rows but EOF": ("\n".join([*LINES[:HEADER], "EOF"]), {}, r"rows of numbers below"),
    "points for commas": (GOOD, {"decimal": "."}, r"line 14, .*: '-?\d+,\d+' is not .*recording.decimal"),
    "commas for points": (exported(both(), decimal="."), {}, r"decimal ','; .*recording.decimal"),
    "unknown channels": (GOOD, {"columns": {"l1_mm": "MAIN.x"}}, r"none of .*MAIN.x.*; it has MAIN.strut\[1\], "),
    "one channel missing": (GOOD.replace("force 3", "fors 3", 1), {}, r"column force 3 is missing; it has .*fors 3"),
    "a hole in a clock": (GOOD.replace("\n5\t", "\n \t", 1), {}, r"line 19: a clock has no value but goes on below"),
    "channels filled with previous values": (GOOD.replace("\n5\t", "\n4\t", 1), {}, r"line 19.*is not later"),
    "ticks for milliseconds": (GOOD, {"clock": {"unit": "filetime"}}, r"such as 0.*, are not in filetime; set .*'ms'"),
    "text": (GOOD.replace("\n5\t", "\nfive\t", 1), {}, r"line 19, time of MAIN.strut\[1\]: 'five' is not a number"),
    "two of one name": (GOOD.replace("force 3", "force 2", 1), {"columns": COLUMNS}, r"column force 2 is there twice"),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damage_is_named_with_its_place(damage: str, tmp_path: Path) -> None:
    text, says, message = DAMAGES[damage]
    file = written(tmp_path, text)
    with refused_at(file, message):
        read(file, case(**says))


def labelled(names: list[str], rows: dict[str, list[str]], delimiter: str = "\t") -> str:
    """An export with a clock for each channel, whose names say less than the lines below them."""
    text = exported([(names, 1e3 * RUN.t, np.column_stack([RUN.struts * 1e3, RUN.forces]))], delimiter, shared=False)
    lines = text.splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("SymbolComment"))
    more = [delimiter.join(f"{key}{delimiter}{cell}" for cell in cells) for key, cells in rows.items()]
    kept = [line for line in lines if not line.startswith(tuple(f"{key}{delimiter}" for key in rows))]
    return "\n".join([*kept[:at], *more, *kept[at:]]) + "\n"


PATHS = [f"Axes.Bein_{k}.NcToPlc.ActPos" for k in range(1, 7)] + [f"GVL.Kraft_{k}" for k in range(1, 7)]
COMMENTS = [f"Istlänge Bein {k}" for k in range(1, 7)] + [f"Messstab {k}, Zug positiv" for k in range(1, 7)]
ABOUT = {"SymbolComment": COMMENTS, "SymbolName": PATHS, "Unit": ["mm"] * 6 + ["N"] * 6}
COUNTED = ["ActPos", *(f"ActPos ({k})" for k in range(1, 6)), *(f"Kraft_{k}" for k in range(1, 7))]
EQUAL = ["ActPos"] * 6 + ["Kraft"] * 6


@pytest.mark.parametrize("names", [COUNTED, EQUAL], ids=["counted", "equal"])
@pytest.mark.parametrize("by", [PATHS, COMMENTS], ids=["path", "comment"])
def test_a_channel_may_be_named_by_its_symbol_or_its_comment(names: list[str], by: list[str], tmp_path: Path) -> None:
    file = written(tmp_path, labelled(names, ABOUT))
    require_the_run(read(file, case(columns=dict(zip(NAMES[1:], by, strict=True)))))


def test_look_names_channels_by_what_tells_them_apart(tmp_path: Path) -> None:
    seen = look(written(tmp_path, labelled(EQUAL, ABOUT)), HEXAPOD)
    assert seen.reads, seen.odd
    assert {ours: seen.settings["columns"][ours] for ours in ("l1_mm", "f6_N")} == {
        "l1_mm": PATHS[0],
        "f6_N": PATHS[11],
    }


def test_channels_of_one_name_are_told_apart_in_the_refusal(tmp_path: Path) -> None:
    file = written(tmp_path, labelled(EQUAL, ABOUT))
    with pytest.raises(RecordingError, match=r"column ActPos is there 6 times.*other names.* Axes\.Bein_1\.NcToPlc"):
        read(file, case(columns=COLUMNS | {"l1_mm": "ActPos"}))


def test_a_unit_of_a_channel_is_that_of_its_line(tmp_path: Path) -> None:
    """Struts in m, as the line `Unit` says: 1000 times the numbers in mm."""
    text = labelled(COUNTED, ABOUT | {"Unit": ["m"] * 6 + ["N"] * 6})
    columns = dict(zip(NAMES[1:], PATHS, strict=True))
    with pytest.raises(RecordingError, match=r"struts of 1.0\d*e\+06 mm where the machine.* in mm: set rec"):
        read(written(tmp_path, text), case(columns=columns))


def test_nothing_needs_to_be_stated_of_the_layout(tmp_path: Path) -> None:
    """Format, separator, decimal sign and unit of the stamps are in the file."""
    for delimiter, decimal in (("\t", ","), (";", "."), (",", ".")):
        file = written(tmp_path, exported(both(), delimiter, decimal))
        require_the_run(read(file, case_with(columns=COLUMNS)))


def test_look_sees_channels_of_several_sample_times(tmp_path: Path) -> None:
    slow = RUN.struts[::4]
    groups: list[Group] = [(FORCES, 1e3 * RUN.t, RUN.forces), (STRUTS, 4.0 * np.arange(len(slow)), slow * 1e3)]
    seen = look(written(tmp_path, exported(groups)), HEXAPOD)
    assert seen.settings["format"] == "twincat-scope"
    assert {len(c.values) for c in seen.columns} == {len(slow), RUN.count}
    assert {c.name for c in seen.columns} >= {*FORCES, *STRUTS}


def test_dates_for_stamps_are_read(tmp_path: Path) -> None:
    """Full Timestamp: a date with ms for each row."""
    text = exported([([*STRUTS, *FORCES], 1e3 * RUN.t, np.hstack([RUN.struts * 1e3, RUN.forces]))])
    head, rows = text.split("\n\n0\t", 1)
    dated = "\n".join(
        "\t".join([f"02.05.2022 15:56:24.{376 + int(line.split(chr(9))[0])}", *line.split("\t")[1:]])
        for line in ("0\t" + rows).splitlines()[:-1]
    )
    require_the_run(read(written(tmp_path, head + "\n\n" + dated), case()))
