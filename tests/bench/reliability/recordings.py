"""Damaged recordings: fifteen kinds of damage, alone and in pairs; whatever is wrong in a result is a finding.

The run is simulated once and kept in memory; so are the other files, whose damage a reader must answer.
"""

import io
import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
from numpy.typing import NDArray

from cases.base.units import MM
from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import Case, load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.recording.recording import read
from identification.samples.clocks import on_one_clock
from identification.simulate import simulate_recording
from tests.bench.reliability.looked import as_stated
from tests.bench.reliability.tally import Tally, tallied
from tests.helpers import Harmonic, paper_poses
from tests.identification.recording.formats.runs import NAMES, Truth, case_with, csv
from tests.identification.recording.formats.test_halsampler import sampled
from tests.identification.recording.formats.test_twincat import COLUMNS, both, exported
from tests.simulated_machine import PoseExecution

Array = NDArray[np.float64]
Draw = np.random.Generator
Damage = Callable[[Array, Draw], Array]

DEVIATIONS = 4.0  # reported ones, by which a value may be off without a finding
T, LENGTHS, FORCES, TRIGGER = 0, slice(1, 7), slice(7, 13), 13
HEADER = ["t_s", *STRUTS, *BAR_FORCES, "trigger"]


def _rows(rows: Array, draw: Draw, most: int) -> slice:
    """Some rows in a row: mostly few, at most `most`."""
    count = int(np.exp(draw.uniform(0.0, np.log(most))))
    start = int(draw.integers(0, max(1, len(rows) - count)))
    return slice(start, start + count)


def _channel(draw: Draw) -> int:
    return int(draw.integers(1, 13))


def rows_lost(rows: Array, draw: Draw) -> Array:
    return np.delete(rows, _rows(rows, draw, 400), axis=0)


def rows_doubled(rows: Array, draw: Draw) -> Array:
    part = _rows(rows, draw, 50)
    return np.insert(rows, part.stop, rows[part], axis=0)


def rows_exchanged(rows: Array, draw: Draw) -> Array:
    one, other = draw.integers(0, len(rows), 2)
    columns = slice(int(draw.integers(0, 2)), None)  # with their time or without
    rows[[one, other], columns] = rows[[other, one], columns]
    return rows


def end_cut(rows: Array, draw: Draw) -> Array:
    return rows[: int(draw.integers(1, len(rows)))]


def values_missing(rows: Array, draw: Draw) -> Array:
    channels = draw.choice(np.arange(1, 13), int(draw.integers(1, 5)), replace=False)
    rows[np.ix_(np.arange(len(rows))[_rows(rows, draw, 1500)], channels)] = np.nan
    return rows


def outliers(rows: Array, draw: Draw) -> Array:
    column = _channel(draw)
    at = draw.integers(0, len(rows), int(draw.integers(1, 6)))
    rows[at, column] *= draw.choice([-1.0, 0.0, 2.0, 10.0, 1e3])
    return rows


def channel_stuck(rows: Array, draw: Draw) -> Array:
    part, column = _rows(rows, draw, 2 * len(rows) // 3), _channel(draw)
    rows[part, column] = rows[part.start, column]
    return rows


def channel_saturated(rows: Array, draw: Draw) -> Array:
    column = int(draw.integers(7, 13))
    level = np.nanquantile(np.abs(rows[:, column]), draw.uniform(0.3, 0.995))
    rows[:, column] = np.clip(rows[:, column], -level, level)
    return rows


def columns_exchanged(rows: Array, draw: Draw) -> Array:
    pair = draw.choice(np.arange(1, 13), 2, replace=False)
    rows[:, pair] = rows[:, pair[::-1]]
    return rows


def sign_turned(rows: Array, draw: Draw) -> Array:
    rows[:, _channel(draw) if draw.random() < 0.8 else FORCES] *= -1.0
    return rows


def unit_mistaken(rows: Array, draw: Draw) -> Array:
    group: Any = [T, LENGTHS, FORCES, _channel(draw)][int(draw.integers(4))]
    rows[:, group] *= draw.choice([1e-3, 1e3, 25.4, 1 / 25.4, 9.81, 1 / 9.81, 60.0, 10.0])
    return rows


def external_force(rows: Array, draw: Draw) -> Array:
    part = _rows(rows[30:], draw, 1500)
    shape = np.sin(np.pi * np.linspace(0.0, 1.0, max(part.stop - part.start, 2)))[: len(rows[part])]
    rows[part, FORCES] += shape[:, None] * draw.normal(size=6) * 10.0 ** draw.uniform(1.0, 3.0)
    return rows


def clock_wrong(rows: Array, draw: Draw) -> Array:
    k = int(draw.integers(1, len(rows)))
    match int(draw.integers(4)):
        case 0:
            rows[k:, T] += draw.choice([-1.0, 1.0]) * 10.0 ** draw.uniform(-3.0, 2.0)
        case 1:
            rows[:, T] *= draw.choice([0.5, 2.0, 1e3, 60.0])
        case 2:
            rows[:, T] += draw.normal(0.0, 10.0 ** draw.uniform(-6.0, -2.0), len(rows))
        case 3:
            rows = np.vstack([rows[:k], rows[k :: int(draw.integers(2, 5))]])
    return rows


def trigger_wrong(rows: Array, draw: Draw) -> Array:
    match int(draw.integers(5)):
        case 0:
            rows[:, TRIGGER] = float(draw.integers(2))
        case 1:
            rows[:, TRIGGER] = np.roll(rows[:, TRIGGER], int(draw.integers(-800, 800)))
        case 2:
            part = _rows(rows, draw, 1500)
            rows[part, TRIGGER] = 1.0 - rows[part, TRIGGER]
        case 3:
            rows[:, TRIGGER] = 1.0 - rows[:, TRIGGER]
        case 4:
            rows[int(draw.integers(len(rows))), TRIGGER] = draw.choice([2.0, -1.0, 0.5, np.nan])
    return rows


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
    "1.2",
    '"',
    "\n",
    ";",
    "\t",
    "\x00",
    "1_0",
    "9" * 30,
]
ODD += ["overrun", "EOF", "Name"]


def stained(text: str, draw: random.Random) -> bytes:
    """The text after an accident with a line, a word or a byte."""
    lines = text.split("\n")
    k = draw.randrange(len(lines))
    match draw.randrange(9):
        case 0:
            del lines[k]
        case 1:
            lines.insert(draw.randrange(len(lines) + 1), lines[k])
        case 2:
            lines = lines[: k + 1]
        case 3:
            lines[k] = lines[k][: draw.randrange(len(lines[k]) + 1)]
        case 4:
            words = lines[k].replace("\t", ",").replace(";", ",").replace(" ", ",").split(",")
            lines[k] = lines[k].replace(draw.choice(words), draw.choice(ODD), 1)
        case 5:
            lines[k], lines[-k] = lines[-k], lines[k]
        case 6:
            old, new = draw.choice([(",", ";"), (".", ","), (",", "\t"), ("\n", "\r\n"), ("_", " "), ("f", "F")])
            return text.replace(old, new).encode()
        case 7:
            words = lines[0].split(",")
            draw.shuffle(words)
            lines[0] = ",".join(words)
        case 8:
            at = draw.randrange(len(text) + 1)
            return (text[:at] + chr(draw.randrange(256)) + text[at + draw.randrange(3) :]).encode("latin-1")
    return "\n".join(lines).encode()


OF_ROWS: tuple[Damage, ...] = (
    rows_lost, rows_doubled, rows_exchanged, end_cut, values_missing, outliers, channel_stuck, channel_saturated,
    columns_exchanged, sign_turned, unit_mistaken, external_force, clock_wrong, trigger_wrong,
)  # fmt: skip
KINDS = (*OF_ROWS, stained)
ALONE_AND_IN_PAIRS = (*((kind,) for kind in KINDS), *combinations(KINDS, 2))


@dataclass(frozen=True)
class Simulated:
    """A run of 3 s without damage, and what it must give.

    Args:
        case: of the machine.
        rows: shape (n, 14), in the units of the file.
        truth: physical parameters of model 9.
    """

    case: Case
    rows: Array
    truth: Array


@cache
def simulated() -> Simulated:
    """The run that is damaged."""
    case = load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=3.0))
    run = simulate_recording(case, execution, np.array([[0.2, 2.8]]), 1)
    rows = np.column_stack([run.t, np.round(run.drives / MM, 8), np.round(run.forces, 6), run.trigger])
    model = identification_model(case, 9)
    u = linear_parameters(model, case.simulation.parameters)
    return Simulated(case, rows, physical_form(model).of(u, np.eye(len(u)))[0])


def file_of(rows: Array) -> bytes:
    """The rows as a CSV file; what is not a number is empty."""
    sink = io.BytesIO()
    columns = [pa.array(np.ascontiguousarray(column), from_pandas=True) for column in rows.T]
    pacsv.write_csv(pa.table(columns, names=HEADER), sink, pacsv.WriteOptions(quoting_style="none"))
    return sink.getvalue()


def damaged(seed: int) -> tuple[tuple[str, ...], bytes]:
    """The kinds of damage of a seed, and the file."""
    kinds: Any = ALONE_AND_IN_PAIRS[seed % len(ALONE_AND_IN_PAIRS)]
    draw, rows = np.random.default_rng(seed), simulated().rows.copy()
    for kind in kinds:
        if kind is not stained and len(rows) > 1:
            rows = kind(rows, draw)
    content = file_of(rows)
    if stained in kinds:
        content = stained(content.decode(), random.Random(seed))
    return tuple(kind.__name__ for kind in kinds), content


def tally_of_runs(seeds: range, folder: Path) -> Tally:
    """Damaged moving runs, read and identified."""

    def one(seed: int, tally: Tally) -> None:
        names, content = damaged(seed)
        run, file = simulated(), folder / "run.csv"
        file.write_bytes(content)

        def call():
            return estimate_parameters(on_one_clock(read(file, run.case), run.case), run.case)

        found = tally.attempt(seed, call, str(file))
        if found is None:
            return
        if found.warnings:
            tally.counts.update({"answered": -1, "answered with findings": 1})
        values = np.array([[p.value, p.reported] for p in found.physical.values()])
        if not np.isfinite(values).all():
            tally.defect(seed, f"{names}: values that are not finite")
        elif found.model.number == 9 and not found.warnings:
            off = np.abs(values[:, 0] - simulated().truth) / values[:, 1]
            if off.max() > DEVIATIONS:
                worst = list(found.physical)[int(np.argmax(off))]
                tally.defect(
                    seed, f"{' and '.join(names)}: {worst} is {off.max():.1f} deviations off without a finding"
                )

    return tallied("recordings", seeds, one)


@cache
def other_files() -> dict[str, tuple[Case, str]]:
    """Standstills, a wrist sensor's standstills, and short runs in the formats of recorders."""
    hexapod, wrist, run = load_case("hexapod"), load_case("ft_wrist"), Truth()
    header, *rows = [line.split(",", 1)[1].rsplit(",", 1)[0] for line in file_of(simulated().rows).decode().split()]
    draw, turns = np.random.default_rng(0), paper_poses()[1][:24].reshape(24, 9)
    lines = [",".join(f"{v:.9g}" for v in np.r_[draw.normal(size=6), turn]) for turn in turns]
    names = "fx,fy,fz,tx,ty,tz," + ",".join(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
    trace = {"format": "sinumerik-trace", "delimiter": "\t", "decimal": ".", "header_rows": 2, "trailing_rows": 1}
    return {
        "standstills": (hexapod, "\n".join([header, *rows[::60]])),
        "wrist": (wrist, "\n".join([names, *lines])),
        "semicolons": (case_with(delimiter=";", decimal=","), csv(run.numbers(), delimiter=";", decimal=",")),
        "halsampler": (
            case_with(format="halsampler", column_names=NAMES[1:], clock={"period_ms": 1.0}),
            sampled(run.numbers()[:, 1:], tagged=True),
        ),
        "twincat": (case_with(format="twincat-scope", decimal=",", columns=COLUMNS), exported(both())),
        "sinumerik": (
            case_with(**trace, clock={"unit": "ms"}),
            "Trace\n" + csv(run.numbers(tick=1e-3), delimiter="\t") + "END",
        ),
    }


def tally_of_other_files(seeds: range, folder: Path) -> Tally:
    """Damaged standstills, which are identified, and damaged files of each format, which are read."""

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        name = list(other_files())[seed % len(other_files())]
        case, text = other_files()[name]
        content = text.encode()
        for _ in range(draw.randint(1, 3)):
            content = stained(content.decode("latin-1"), draw)
        file = folder / "run.txt"
        file.write_bytes(content)
        if name in ("standstills", "wrist"):
            found = tally.attempt(seed, lambda: estimate_parameters(read(file, case), case), str(file))
            if found is not None and not (
                np.isfinite(found.fit.values).all() and np.isfinite(found.fit.covariance).all()
            ):
                tally.defect(seed, f"{name}: values that are not finite")
            return
        as_stated(file, case, name, seed, tally)

    return tallied("standstills and files of other formats", seeds, one)
