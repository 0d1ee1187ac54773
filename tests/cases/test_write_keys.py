"""Keys are written into a case file, and no other; the earlier file is kept."""

import tomllib
from pathlib import Path

import pytest

from cases.base.errors import HexciteError, Write
from cases.base.places import placed
from cases.editing import write_keys
from cases.scaffold import new_case
from cases.schema import load_case


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return new_case("mill", "hexapod", tmp_path / "mill")


def comments(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.lstrip().startswith("#")]


def test_keys_are_written_and_the_earlier_file_is_kept(file: Path) -> None:
    before = file.read_text()
    gravity = [0.0, 0.0, -9.80665]
    keys = [
        Write(("recording", "columns", "l1_mm"), "LOAD"),
        Write(("recording", "filter_cutoff_Hz"), 33.0),
        Write(("gravity_m_s2",), gravity),
    ]
    written = write_keys(file, keys)
    assert {key for key, _, _ in written.changes} == {"recording.columns", "recording.filter_cutoff_Hz", "gravity_m_s2"}
    assert written.earlier == file.with_name("case-1.toml")
    assert written.earlier.read_text() == before
    after = file.read_text()
    assert comments(after) == comments(before)
    case = load_case(str(file))
    assert case.recording.columns["l1_mm"] == "LOAD"
    assert case.gravity_m_s2 == tuple(gravity)
    expected = tomllib.loads(before)
    expected["gravity_m_s2"] = gravity
    expected["recording"] |= {"columns": {"l1_mm": "LOAD"}, "filter_cutoff_Hz": 33.0}
    assert tomllib.loads(after) == expected
    assert write_keys(file, keys).earlier is None
    assert write_keys(file, [Write(("recording", "columns"), None)]).earlier == file.with_name("case-2.toml")


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        (("machine", "base", "ring", "radius_mm"), -3.0, "radius_mm"),
        (("machine", "no_such_key"), 1.0, "no_such_key"),
        (("sensors", 3, "gain"), 1.0, "sensors"),
        (("name", "of"), 1.0, "name.of"),
    ],
)
def test_what_makes_no_case_is_not_written(file: Path, key: tuple[str | int, ...], value: float, said: str) -> None:
    before = file.read_bytes()
    with pytest.raises(HexciteError, match=said) as error:
        write_keys(file, [Write(key, value)])
    assert str(file) in str(error.value)
    assert file.read_bytes() == before
    assert [each.name for each in file.parent.iterdir()] == ["case.toml"]


def test_one_entry_of_a_list_of_tables_is_changed_alone(tmp_path: Path) -> None:
    file = new_case("arm", "ur10_wrist", tmp_path / "arm")
    before = file.read_text()
    joints = load_case(str(file)).chain.joints
    place = ("machine", "chain", "joints", 1, "rpy_deg")
    turned = [1.0, *joints[1].rpy_deg[1:]]
    assert placed(place) == "machine.chain.joints[2].rpy_deg"
    write_keys(file, [Write(place, turned)])
    after = load_case(str(file)).chain.joints
    assert list(after[1].rpy_deg) == turned
    assert (after[0], *after[2:]) == (joints[0], *joints[2:])
    assert comments(file.read_text()) == comments(before)


def test_a_table_in_which_nothing_is_left_goes(file: Path) -> None:
    before = tomllib.loads(file.read_text())
    write_keys(file, [Write(("accept", "reference", "mass_kg"), 2.0), Write(("accept", "reference", "mass_U_kg"), 0.1)])
    assert load_case(str(file)).accept is not None
    keys = [Write(("accept", "reference", key), None) for key in ("mass_kg", "mass_U_kg")]
    write_keys(file, [*keys, Write(("accept", "deviations", "mass_kg"), None)])
    assert tomllib.loads(file.read_text()) == before
