"""`hexcite identify` tells where a run went at another feed than programmed, by its own column."""

from pathlib import Path

import numpy as np
import pytest

from cases.schema import load_case
from tests.helpers import tells
from tests.hexcite.command_line import call, refused
from tests.postprocessors.programs import small_excitation

CASE = load_case("hexapod")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program and its run on the virtual controller."""
    folder = tmp_path_factory.mktemp("feed")
    (folder / "p.ngc").write_text(small_excitation(CASE), encoding="utf-8")
    call("run", folder / "p.ngc", "--case", "hexapod", "--on", "virtual", "-o", folder / "run", "--json").json()
    return folder


def identified(path: Path, tmp_path: Path, *words: object) -> dict:
    return call("identify", path, "--case", "hexapod", "-o", tmp_path / "r", "--json", *words).json()


@pytest.mark.slow
def test_the_column_of_the_override_is_read(folder: Path, tmp_path: Path) -> None:
    lines = (folder / "run" / "recording.csv").read_text().splitlines()
    on = [k for k, line in enumerate(lines) if line.endswith(",1")]
    middle = on[len(on) // 2]
    values = [80 if abs(k - middle) < 100 else 100 for k in range(1, len(lines))]
    table = [f"{lines[0]},override_percent", *(f"{a},{b}" for a, b in zip(lines[1:], values, strict=True))]
    file = tmp_path / "o.csv"
    file.write_text("\n".join(table) + "\n")
    answer = identified(file, tmp_path)
    assert answer["feed"] == pytest.approx({"lowest": 0.8, "highest": 0.8})
    assert any(tells(w, f"lines {middle - 98} to {middle + 100}", "override") for w in answer["warnings"])
    table[40] = table[40].rsplit(",", 1)[0] + ",-5"
    file.write_text("\n".join(table) + "\n")
    message = refused("identify", file, "--case", "hexapod", "-o", tmp_path / "s")
    assert tells(message, "line 41, override_percent: -5", "recording.units.override")


@pytest.mark.slow
def test_overrides_as_ratios_are_read_with_their_unit(folder: Path) -> None:
    from identification.recording.recording import read

    case = CASE.model_copy(
        update={
            "recording": type(CASE.recording).model_validate(
                CASE.recording.model_dump() | {"columns": {"override_percent": "ovr"}, "units": {"override": "1"}}
            )
        }
    )
    lines = (folder / "run" / "recording.csv").read_text().splitlines()
    file = folder / "ratio.csv"
    file.write_text("\n".join([f"{lines[0]},ovr", *(f"{line},0.5" for line in lines[1:])]) + "\n")
    np.testing.assert_array_equal(read(file, case).override, 0.5)
