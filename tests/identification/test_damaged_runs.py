"""Whatever happens to a file on its way, a user sees one line: an answer or an error of ours, never a traceback."""

import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.loading import load_case
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.recording import read_recording, write_recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, answer, paper_poses
from tests.simulated_machine import PoseExecution

HEXAPOD, WRIST = load_case("hexapod"), load_case("ft_wrist")
FILES: dict[str, tuple[Case, str]] = {}
ODD = [
    "",
    "nan",
    "-",
    "1e308",
    "-1e308",
    "1e-320",
    "0",
    "x",
    "1,2",
    '"',
    "\n",
    ";",
    "\x00",
    "1_0",
    "99999999999999999999",
]


@pytest.fixture(scope="module", autouse=True)
def _files(tmp_path_factory: pytest.TempPathFactory) -> None:
    """A moving run, standstills of the hexapod, standstills of a wrist sensor."""
    file = tmp_path_factory.mktemp("runs") / "recording.csv"
    execution = PoseExecution(Hexapod.of(HEXAPOD), Harmonic(duration=0.4))
    write_recording(file, simulate_recording(HEXAPOD, execution, np.array([[0.1, 0.3]]), 1), HEXAPOD)
    moving = file.read_text()
    header, *rows = [line.split(",", 1)[1].rsplit(",", 1)[0] for line in moving.splitlines()]
    FILES["moving"] = HEXAPOD, moving
    FILES["standstills"] = HEXAPOD, "\n".join([header, *rows[::20]])
    draw, turns = np.random.default_rng(0), paper_poses()[1][:24].reshape(24, 9)
    lines = [",".join(f"{v:.9g}" for v in np.r_[draw.normal(size=6), turn]) for turn in turns]
    names = "fx,fy,fz,tx,ty,tz," + ",".join(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
    FILES["wrist"] = WRIST, "\n".join([names, *lines])


def damaged(text: str, seed: int, times: int) -> bytes:
    """The file after a few accidents: lost, doubled or swapped rows, columns and bytes, odd values, a torn end."""
    draw = random.Random(seed)
    for _ in range(times):
        rows = [line.split(",") for line in text.splitlines()] or [[""]]
        row, column = draw.randrange(len(rows)), draw.randrange(len(rows[0]))
        match draw.randrange(9):
            case 0:
                rows[row][draw.randrange(len(rows[row]))] = draw.choice(ODD)
            case 1:
                value = draw.choice(ODD)
                rows[1:] = [[value if k == column else v for k, v in enumerate(r)] for r in rows[1:]]
            case 2:
                del rows[row]
            case 3:
                rows.insert(draw.randrange(len(rows) + 1), list(rows[row]))
            case 4:
                rows = [r[:column] + r[column + 1 :] for r in rows]
            case 5:
                rows = rows[: row + 1]
            case 6:
                draw.shuffle(rows[0])
            case 7:
                rows[1:] = [[v[1:] if k == column and v[:1] == "-" else v for k, v in enumerate(r)] for r in rows[1:]]
            case 8:
                text = "\n".join(",".join(r) for r in rows)
                place = draw.randrange(len(text) + 1)
                return (text[:place] + chr(draw.randrange(256)) + text[place + draw.randrange(3) :]).encode("latin-1")
        text = "\n".join(",".join(r) for r in rows)
    return text.encode()


@pytest.mark.parametrize("kind", ["moving", "standstills", "wrist"])
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32 - 1), times=st.integers(1, 3))
def test_a_damaged_run_is_answered_in_one_line(kind: str, seed: int, times: int, tmp_path: Path) -> None:
    case, text = FILES[kind]
    file = tmp_path / "run.csv"
    file.write_bytes(damaged(text, seed, times))
    estimate = answer(lambda: identify(read_recording(file, case), case), str(file))
    assert estimate is None or np.isfinite(estimate.values).all()
    assert estimate is None or np.isfinite(estimate.covariance).all()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["moving", "standstills", "wrist"])
def test_thousands_of_damaged_runs_are_answered_in_one_line(kind: str, tmp_path: Path) -> None:
    case, text = FILES[kind]
    file = tmp_path / "run.csv"
    for seed in range(1700):
        file.write_bytes(damaged(text, seed, 1 + seed % 3))
        estimate = answer(lambda: identify(read_recording(file, case), case), str(file))
        assert estimate is None or (np.isfinite(estimate.values).all() and np.isfinite(estimate.covariance).all())


def mildly_damaged(text: str, seed: int) -> str:
    """One value in a thousand rows is another one: nothing, zero, a neighbour's, ten or a thousand times as large."""
    draw = random.Random(seed)
    rows = [line.split(",") for line in text.splitlines()]
    for first in range(1, len(rows), 1000):
        row = draw.randrange(first, min(first + 1000, len(rows)))
        column = draw.randrange(1, 13)
        value = float(rows[row][column])
        choices = ["", "0", rows[max(row - 1, 1)][column], f"{10 * value:.6f}", f"{1000 * value:.6f}", f"{-value:.6f}"]
        rows[row][column] = draw.choice(choices)
    return "\n".join(",".join(row) for row in rows)


def within_3_std(seeds: range, folder: Path) -> float:
    """Share of mildly damaged runs that give every parameter within 3 standard deviations of the undamaged ones."""
    file = folder / "recording.csv"
    execution = PoseExecution(Hexapod.of(HEXAPOD), Harmonic(seed=1, duration=2.0))
    write_recording(file, simulate_recording(HEXAPOD, execution, np.array([[0.2, 1.8]]), 1), HEXAPOD)
    text = file.read_text()
    clean = identify(read_recording(file, HEXAPOD), HEXAPOD)
    std = np.sqrt(np.diag(clean.covariance))
    good = 0
    for seed in seeds:
        file.write_text(mildly_damaged(text, seed))
        estimate = answer(lambda: identify(read_recording(file, HEXAPOD), HEXAPOD), str(file))
        good += estimate is not None and bool((np.abs(estimate.values - clean.values) < 3.0 * std).all())
    return good / len(seeds)


@pytest.mark.parametrize("seeds", [range(10), pytest.param(range(10, 200), marks=pytest.mark.slow)])
def test_mild_damage_leaves_most_runs_usable(seeds: range, tmp_path: Path) -> None:
    assert within_3_std(seeds, tmp_path) >= 0.9
