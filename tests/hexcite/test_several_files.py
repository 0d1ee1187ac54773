"""Commands that read a run take it in several files, of which the case has a table each."""

from pathlib import Path

import numpy as np

from cases.recording_format import BAR_FORCES, STRUTS
from cases.tables import built_in_cases
from tests.hexcite.command_line import call
from tests.identification.recording.formats.loaded_hexapod import MASS, OFFSETS, run
from tests.identification.recording.formats.runs import csv, written

TABLES = """
[[recording.files]]
match = "forces*"
delimiter = ";"
columns = { t_s = "Zeit [s]", trigger = "Trigger" }
"""


def recorded(folder: Path, name: str, moves: bool) -> list[Path]:
    """A run, or a standstill, by two recorders: struts at 250 Hz, forces later at 500 Hz, the trigger in both."""
    fast, slow = np.arange(0.0, 4.0, 0.002), np.arange(0.1, 4.0, 0.004)
    files = []
    for t, kind in ((slow, "struts"), (fast, "forces")):
        truth, trigger = run(t if moves else 0.0 * t), (t > 0.3) & (t < 3.7)
        names = STRUTS if kind == "struts" else BAR_FORCES
        values = truth.struts * 1e3 if kind == "struts" else truth.forces
        stamps = t if kind == "struts" else t + 7.0
        clock, switch, separator = ("t_s", "trigger", ",") if kind == "struts" else ("Zeit [s]", "Trigger", ";")
        rows = np.column_stack([stamps, values, trigger])
        files.append(written(folder, csv(rows, [clock, *names, switch], separator), f"{kind}-{name}.csv"))
    return files


def test_a_run_in_two_files_is_identified_and_its_forces_and_offsets_are_told(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(built_in_cases()["hexapod"].read_text(encoding="utf-8") + TABLES)
    moving, standing = recorded(tmp_path, "run", True), recorded(tmp_path, "still", False)
    result = tmp_path / "result"
    found = call("identify", *moving, "--case", tmp_path, "-o", result, "--json").json()
    m = found["parameters"]["m"]
    assert abs(m["value"] - MASS) < 4.0 * max(m["std"], m["std_robust"])
    assert any("joined" in note for note in found["notes"])
    told = call("force", *moving, "--parameters", result, "-o", tmp_path / "force.csv", "--json").json()
    assert told["samples"] > 400
    assert told["peak"]["fz_N"] < 5.0  # nothing touches the body
    page = Path(told["report"]).read_text()
    assert "External force" in page
    assert page.count('data-plot="') == 2
    tared = call("tare", *standing, "--parameters", result, "-o", tmp_path / "tared", "--json").json()
    offsets = [tared["parameters"][f"f_q0_{k}"]["value"] for k in range(1, 7)]
    np.testing.assert_allclose(offsets, OFFSETS, atol=1.0)
