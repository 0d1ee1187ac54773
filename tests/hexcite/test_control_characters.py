"""Names from files reach terminal, pages, pictures and cases without characters that steer what shows them."""

import re
import tomllib
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cases.base.errors import legible, printable
from cases.base.text_formats import toml_value
from cases.recording_format import BAR_FORCES, STRUTS
from identification.finding import Kind, warning
from identification.recording.recording import Recording
from tests.bench.reliability.recordings import HEADER, simulated
from tests.hexcite.command_line import call

pytestmark = pytest.mark.usefixtures("every_picture")

EVIL = "\x1b[31m\x07\u202e<script>alert(1)</script>[b]&\"'\\\x85\u2028\n\r"
STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def recorded(folder: Path) -> tuple[Path, Path]:
    """A run whose channels have such names, and a case that reads it."""
    names = {name: f"{name} {EVIL}" for name in (*STRUTS, *BAR_FORCES)}
    file = folder / "run.parquet"
    pq.write_table(pa.table([pa.array(c) for c in simulated().rows.T], names=[names.get(n, n) for n in HEADER]), file)
    assert call("case", "new", "own", "--like", "hexapod", "-o", folder / "own").code == 0
    case = folder / "own" / "case.toml"
    columns = "\n".join(f"{ours} = {toml_value(theirs)}" for ours, theirs in names.items())
    units = '[recording]\nunits = { struts = "mm", forces = "N" }'
    text = re.sub(r"(?m)^\[recording\]", units, case.read_text(encoding="utf-8"))
    case.write_text(f"{text}\n[recording.columns]\n{columns}\n", encoding="utf-8")
    return file, case


def test_names_of_channels_steer_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file, case = recorded(tmp_path)
    looked = call("look", file, "--case", case)
    identified = call("identify", file, "--case", case, "-o", "result")
    assert (looked.code, identified.code) == (0, 0), (looked, identified)
    written = [
        *tmp_path.glob("*.svg"),
        *(tmp_path / "result").glob("*.html"),
        *(tmp_path / "result").glob("*.json"),
        case,
    ]
    assert len(written) >= 4
    for name, text in [
        ("look", looked.out), ("identify", identified.out),
        *((path.name, path.read_text(encoding="utf-8")) for path in written),
    ]:  # fmt: skip
        assert not STEERING.search(text), name
        assert "<script>alert" not in text or name not in ("report.html", "run-look.svg")
    lines = [line for line in looked.out.splitlines() if "alert(1)" in line]
    assert len(lines) >= 12
    assert not any(line.startswith("[") for line in looked.out.splitlines() if "\\n" in line)


def test_a_file_is_named_in_one_printable_line() -> None:
    source = Recording(f"run{EVIL}.csv", None, None, None, simulated().rows[:3, 7:13], None).source
    assert source == printable(f"run{EVIL}.csv")
    assert source.isprintable()
    assert str(warning(Kind.DAMAGE, f"channel {EVIL} is stuck")).isprintable()


def test_toml_of_any_text_is_printable_and_reads_back() -> None:
    text = EVIL + "\x00\x7f\U000e0001\ufeff\u00e4\u4e2d"
    assert toml_value(text).isprintable()
    assert tomllib.loads(f"x = {toml_value(text)}") == {"x": text}


def test_lines_and_letters_of_any_language_stay() -> None:
    text = "Zug ü\n\tМасса 质量 ± µ"
    assert legible(text) == text
    assert not STEERING.search(legible(EVIL))
