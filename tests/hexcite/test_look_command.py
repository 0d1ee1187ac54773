"""`hexcite look` on the command line: the table that it prints is the table that the case needs."""

import json
import tomllib
from pathlib import Path

import pytest

from tests.hexcite.command_line import call, hexcite


def _recording(folder: Path) -> Path:
    """Twelve standstills of a force/torque sensor under names of a recorder's own."""
    rows = [f"{k / 10};{-k / 7};9.81;0.1;{k / 30};0,2;1;0;0;0;1;0;0;0;1".replace(".", ",") for k in range(12)]
    names = "Kraft x;Kraft y;Kraft z;Moment x;Moment y;Moment z;R11;R12;R13;R21;R22;R23;R31;R32;R33"
    file = folder / "wrist.csv"
    file.write_text("\n".join([names, *rows]) + "\n")
    return file


def test_the_printed_table_is_toml_that_reads_the_file(tmp_path: Path) -> None:
    file = _recording(tmp_path)
    answer = hexcite("look", file, "--case", "ft_wrist", "-o", tmp_path / "look.svg")
    assert answer.code == 0, answer.err
    table = tomllib.loads(answer.out[answer.out.index("\n[recording]\n") : answer.out.index("picture written")])
    assert table["recording"]["delimiter"] == ";"
    assert table["recording"]["decimal"] == ","
    assert table["recording"]["columns"]["fx_N"] == "Kraft x"
    assert (tmp_path / "look.svg").read_text().lstrip().startswith("<?xml")


def test_numbers_that_nothing_measures_are_left_out_of_what_columns_look_like(tmp_path: Path) -> None:
    """Differences and squares of them overflow; a reader takes them for missing too."""
    rows = [f"{k / 10},{(-1) ** k * 1.7e308},{k % 7 + 0.5}" for k in range(60)]
    file = tmp_path / "odd.csv"
    file.write_text("\n".join(rows) + "\n")
    answer = hexcite("look", file, "--json", "-o", tmp_path / "look.svg")
    assert answer.code in (0, 1)
    assert "1.7e308" not in answer.out
    assert "overflow" not in answer.out + answer.err


def test_json_says_the_same(tmp_path: Path) -> None:
    answer = call("look", _recording(tmp_path), "--case", "ft_wrist", "-o", tmp_path / "look.png", "--json").json()
    assert answer["reads"]
    assert answer["rows"] == 12
    (force,) = (column for column in answer["columns"] if column["name"] == "Kraft x")
    assert {"meaning": "fx_N", "unit": "N", "guessed": False}.items() <= force.items()


def test_a_picture_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "look.svg").write_text("mine")
    refusal = call("look", _recording(tmp_path), "-o", tmp_path / "look.svg").refusal()
    assert "--overwrite" in refusal
    assert (tmp_path / "look.svg").read_text() == "mine"


CASE = """\
# Drawing 4711, revision C.
schema_version = 1
name = "wrist"
title = "a sensor on a flange"
setup = "R"
gravity_m_s2 = [0.0, 0.0, -9.81] # of the town

[sensor_frame.transducer]
sense = "load_on_sensor"

[sensors] # from the data sheet
weights = "equal"

# How the recorder of the lab writes.
[recording]
filter_cutoff_Hz = 20.0 # by hand

# What is still to be measured.
"""


def _case(folder: Path, text: str = CASE) -> Path:
    file = folder / "case.toml"
    file.write_text(text)
    return file


def test_the_proposal_is_written_into_the_case_and_nothing_else_changes(tmp_path: Path) -> None:
    case = _case(tmp_path)
    answer = call("look", _recording(tmp_path), "--write", tmp_path, "-o", tmp_path / "look.svg")
    assert answer.code == 0, answer.err
    assert "recording.delimiter" in answer.out
    text = case.read_text()
    head, tail = CASE.split("filter_cutoff_Hz = 20.0 # by hand\n")
    assert text.startswith(f"{head}filter_cutoff_Hz = 20.0 # by hand\n")
    assert text.endswith(tail)
    printed = tomllib.loads(answer.out[answer.out.index("\n[recording]\n") : answer.out.index("picture written")])
    assert tomllib.loads(text)["recording"] == printed["recording"]
    again = call("look", _recording(tmp_path), "--write", tmp_path, "-o", tmp_path / "again.svg", "--json").json()
    assert again["unchanged"]
    assert again["changes"] == []
    assert case.read_text() == text


def test_what_a_case_states_otherwise_is_replaced_only_if_asked(tmp_path: Path) -> None:
    case = _case(tmp_path, CASE.replace("# by hand\n", '# by hand\ndelimiter = "|"\n'))
    before = case.read_text()
    refusal = call("look", _recording(tmp_path), "--write", case, "-o", tmp_path / "look.svg").refusal()
    assert "recording.delimiter" in refusal
    assert "--overwrite" in refusal
    assert case.read_text() == before
    done = call("look", _recording(tmp_path), "--write", case, "-o", tmp_path / "look.svg", "--overwrite", "--json")
    assert {"key": "recording.delimiter", "before": "|", "after": ";"} in done.json()["changes"]
    assert 'delimiter = ";"' in case.read_text()


def test_a_proposal_that_does_not_read_the_file_is_not_written(tmp_path: Path) -> None:
    """Counts need a scale that only a person knows: the exit code says so, the sentence of the reader comes first."""
    case = _case(tmp_path)
    rows = [f"{k},{-k},900,10,{k},2,1,0,0,0,1,0,0,0,1" for k in range(12)]
    names = "fx [counts],fy [counts],fz [counts],mx,my,mz,r11,r12,r13,r21,r22,r23,r31,r32,r33"
    (file := tmp_path / "raw.csv").write_text("\n".join([names, *rows]) + "\n")
    answer = call("look", file, "--write", case, "-o", tmp_path / "look.svg")
    assert answer.code == 1
    assert answer.err == ""
    assert "recording.scale" in answer.out.splitlines()[1]
    assert "nothing was written" in answer.out
    assert "paste" not in answer.out
    assert case.read_text() == CASE


def test_a_built_in_case_is_not_written(tmp_path: Path) -> None:
    refusal = call("look", _recording(tmp_path), "--write", "ft_wrist", "-o", tmp_path / "look.svg").refusal()
    assert "case new" in refusal


@pytest.mark.slow
def test_many_channels_are_drawn_on_pages_without_a_word(tmp_path: Path) -> None:
    """150 columns, names longer than a page is wide, letters that no font has, numbers that no picture can show."""
    names = [f"{'long' * 40}{chr(0x4E00 + k)}[{i}]" for k in range(17) for i in range(9)]
    rows = [",".join(str(k * i) for i in range(152)) + (",1e300" if k else ",nan") for k in range(40)]
    (file := tmp_path / "log.csv").write_text("\n".join([",".join(names), *rows]) + "\n")
    answer = call("look", file, "-o", tmp_path / "look.png", "--json")
    assert answer.err == ""
    pages = [Path(page) for page in json.loads(answer.out)["pictures"]]
    assert len(pages) > 1
    assert pages[0] == tmp_path / "look.png"
    assert all(page.read_bytes().startswith(b"\x89PNG") for page in pages)
    refusal = call("look", file, "-o", tmp_path / "look-page2.png")
    assert "--overwrite" in refusal.err  # a page of the first look stands there
    pdf = call("look", file, "-o", tmp_path / "look.pdf", "--json")
    assert json.loads(pdf.out)["pictures"] == [str(tmp_path / "look.pdf")]
