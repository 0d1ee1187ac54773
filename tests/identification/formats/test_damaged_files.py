"""Whatever happens to a file of any format, it is read, or refused in one printable line that names it."""

import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.schema import Case
from identification.recording import read_recording
from tests.helpers import answer
from tests.identification.formats.runs import NAMES, Truth, case_with, csv
from tests.identification.formats.test_halsampler import sampled
from tests.identification.formats.test_twincat import COLUMNS, both, exported

RUN = Truth()
FILES: dict[str, tuple[Case, str]] = {
    "semicolons and commas": (case_with(delimiter=";", decimal=","), csv(RUN.numbers(), delimiter=";", decimal=",")),
    "halsampler": (
        case_with(format="halsampler", column_names=NAMES[1:], clock={"period_ms": 1.0}),
        sampled(RUN.numbers()[:, 1:], tagged=True),
    ),
    "twincat": (case_with(format="twincat-scope", decimal=",", columns=COLUMNS), exported(both())),
    "sinumerik": (
        case_with(
            format="sinumerik-trace", delimiter="\t", decimal=".", header_rows=2, trailing_rows=1, clock={"unit": "ms"}
        ),
        "Trace\n" + csv(RUN.numbers(tick=1e-3), delimiter="\t") + "END",
    ),
}
ODD = [
    "",
    "nan",
    "-",
    "1e308",
    "0",
    "x",
    "1,2",
    "1.2",
    '"',
    "\n",
    ";",
    "\t",
    "\x00",
    "overrun",
    "EOF",
    "Name",
    "9" * 30,
]


def damaged(text: str, seed: int, times: int) -> bytes:
    """The text after a few accidents with lines, words and bytes."""
    draw = random.Random(seed)
    for _ in range(times):
        lines = text.split("\n")
        k = draw.randrange(len(lines))
        match draw.randrange(7):
            case 0:
                del lines[k]
            case 1:
                lines.insert(draw.randrange(len(lines) + 1), lines[k])
            case 2:
                lines = lines[: k + 1]
            case 3:
                lines[k] = lines[k][: draw.randrange(len(lines[k]) + 1)]
            case 4:
                words = lines[k].replace("\t", " ").split(" ")
                lines[k] = lines[k].replace(draw.choice(words), draw.choice(ODD), 1)
            case 5:
                lines[k], lines[-k] = lines[-k], lines[k]
            case 6:
                whole = "\n".join(lines)
                at = draw.randrange(len(whole) + 1)
                return (whole[:at] + chr(draw.randrange(256)) + whole[at + draw.randrange(3) :]).encode("latin-1")
        text = "\n".join(lines)
    return text.encode()


@pytest.mark.parametrize("kind", FILES)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32 - 1), times=st.integers(1, 3))
def test_a_damaged_file_is_read_or_named(kind: str, seed: int, times: int, tmp_path: Path) -> None:
    case, text = FILES[kind]
    file = tmp_path / "run.txt"
    file.write_bytes(damaged(text, seed, times))
    recording = answer(lambda: read_recording(file, case), str(file))
    if recording is not None:
        for stream in recording.streams:
            assert all(np.isfinite(array).all() for array in stream.channels.values())
            assert (np.diff(stream.t) > 0.0).all()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(content=st.binary(max_size=300) | st.text(max_size=200).map(str.encode))
@pytest.mark.parametrize("kind", FILES)
def test_any_bytes_are_refused_in_one_line(kind: str, content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    file.write_bytes(content)
    assert answer(lambda: read_recording(file, FILES[kind][0]), str(file)) is None
