"""One sound run, written as recorders write: separators, headers, names, units, clocks, triggers and words drawn anew.

`look` proposes how each file is read, and the run is identified with the proposal: what comes out is right, has a
finding, or is refused in one line. Half of the files are damaged besides.
"""

import random
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cases.recording_format import RecordingFormat
from cases.schema import Case, load_case
from identification.finding import Kind
from identification.identify import estimate_parameters
from identification.looks.looking import look
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.recording.recording import read
from identification.results.estimate import Estimate
from identification.samples.clocks import on_one_clock
from identification.simulate import simulate_recording
from tests.bench.reliability.recordings import DEVIATIONS, stained
from tests.bench.reliability.tally import Tally, tallied
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

Array = NDArray[np.float64]

STRUT_NAMES = ("Strut {}", "Bein {}", "leg_{}", "ActPos{}", "L{}", "strut.{}.length", "Achse {} Ist", "l{}_mm")
FORCE_NAMES = ("Force {}", "Kraft {}", "loadcell_{}", "F{}", "force[{}]", "DMS {}", "f{}_N")
OF_NO_KNOWN_NAME = ("Kanal {}", "channel {}", "b{}")
LENGTH_UNITS = {"mm": 1.0, "m": 1e-3, "um": 1e3, "inch": 1 / 25.4, "in": 1 / 25.4, "": 1.0}
FORCE_UNITS = {"N": 1.0, "kN": 1e-3, "daN": 0.1, "lbf": 1 / 4.4482216152605, "kgf": 1 / 9.80665, "": 1.0}
UNKNOWN_UNITS = ("counts", "V", "mV/V", "digits", "a.u.")
TIMES = ("t_s", "time", "Time", "Zeit", "timestamp", "t", "elapsed")
MISSING = ("", "NaN", "--", "#N/A", "1.#QNAN", "-1.#IND")
BRACKETS = ("{} [{}]", "{} ({})", "{}_{}", "{} / {}")
ABOUT_THE_FILE = (Kind.DAMAGE, Kind.WINDOW, Kind.CLOCK, Kind.FORMAT)  # such a finding does not doubt the numbers
BEGAN = datetime(2024, 3, 5, 23, 59, 58)


@dataclass(frozen=True)
class Sound:
    """A run without damage.

    Args:
        case: of the machine.
        t: time stamps, shape (n,) [s].
        struts: shape (n, 6) [mm].
        forces: shape (n, 6) [N].
        trigger: shape (n,).
        truth: physical parameters of model 9, by name.
    """

    case: Case
    t: Array
    struts: Array
    forces: Array
    trigger: Array
    truth: dict[str, float]


@cache
def sound() -> Sound:
    """The run that is written, at 500 samples a second."""
    case = load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=3.0))
    run = simulate_recording(case, execution, np.array([[0.2, 2.8]]), 1)
    assert run.t is not None
    assert run.drives is not None
    assert run.trigger is not None
    model, form = identification_model(case, 9), physical_form(identification_model(case, 9))
    u = linear_parameters(model, case.need_simulation("a test").parameters)
    truth = dict(zip((p.name for p in form.parameters), form.of(u, np.eye(len(u)))[0], strict=True))
    every = slice(None, None, 2)
    return Sound(
        case, run.t[every], 1e3 * run.drives[every], run.forces[every], run.trigger[every].astype(float), truth
    )


@dataclass(frozen=True)
class Written:
    """A file, and what was drawn for it.

    Args:
        content: the file.
        words: what was drawn, for people.
        known: whether all that is needed to read it stands in it.
    """

    content: bytes
    words: str
    known: bool


def written(seed: int) -> Written:
    """The run as some recorder would write it."""
    draw, run = random.Random(seed), sound()
    known = True
    separator = draw.choice([",", ";", "\t", "|", " ", "aligned"])
    decimal = "," if separator in ";\t|" and draw.random() < 0.5 else "."
    digits = draw.choice([6, 7, 9])

    def number(value: float) -> str:
        return f"{value:.{digits}g}".replace(".", decimal)

    def with_sign(fields: list[str]) -> list[str]:
        return [
            field.replace(".", decimal) if field.lstrip("-").replace(".", "", 1).isdigit() else field
            for field in fields
        ]

    columns: list[tuple[str, str, list[str]]] = []  # name, unit, fields
    for names, values, units, role in (
        (STRUT_NAMES, run.struts, LENGTH_UNITS, "struts"),
        (FORCE_NAMES, run.forces, FORCE_UNITS, "forces"),
    ):
        name = draw.choice(names if draw.random() < 0.9 else OF_NO_KNOWN_NAME)
        known &= name in names
        unit = draw.choice(list(units))
        if name.endswith(("_mm", "_N")):
            unit = ""
        factor = units[unit]
        if unit == "" and draw.random() < 0.15:
            unit, known = draw.choice(UNKNOWN_UNITS), False
            # within a factor of two nothing in a file speaks against the usual unit, and only the mass says so
            factor = 10.0 ** (draw.choice([-1, 1]) * draw.uniform(0.3, 2.0))
        first = 0 if draw.random() < 0.2 and "_" not in name else 1
        for k in range(6):
            columns.append((name.format(k + first), unit, [number(v * factor) for v in values[:, k]]))
        del role
    clock, names_of_time = (
        draw.choice(["s", "ms", "us", "iso", "german", "filetime", "jitter", "none"]),
        draw.choice(TIMES),
    )
    if clock != "none":
        columns.insert(
            0, (names_of_time, clock if clock in ("s", "ms", "us") else "", with_sign(stamps(clock, run.t, draw)))
        )
    known &= clock not in ("none", "filetime")
    switch = draw.choice(["0", "words", "volts", "bits", "none"])
    if switch != "none":
        fields = with_sign(trigger_fields(switch, run.trigger, draw))
        columns.append((draw.choice(["trigger", "Trigger", "TTL", "digitalout"]), "", fields))
        known &= switch != "bits"
    for extra in draw.sample(["Temperature", "SetPos1", "counter", "comment"], draw.randint(0, 2)):
        fields = {
            "Temperature": [number(20.0 + 1e-3 * k) for k in range(len(run.t))],
            "SetPos1": [number(v) for v in run.struts[:, 0] + 0.1],
            "counter": [str(k) for k in range(len(run.t))],
            "comment": ["ok"] * len(run.t),
        }[extra]
        columns.insert(draw.randint(0, len(columns)), (extra, "", fields))
    if draw.random() < 0.2:
        missing = draw.choice(MISSING)
        for _ in range(draw.randint(1, 3)):
            _, _, fields = draw.choice([c for c in columns if c[0].lower() not in map(str.lower, TIMES)])
            fields[draw.randrange(len(fields))] = missing if separator != "aligned" else "nan"
    header = draw.choice(["names", "names", "units row", "brackets", "preamble", "headless"])
    known &= header != "headless" and (header in ("units row", "brackets") or all(not unit for _, unit, _ in columns))
    lines = list(table(columns, separator, header, draw))
    if draw.random() < 0.15 and separator not in (" ", "aligned"):
        lines = [line + separator for line in lines]
    text = draw.choice(["\n", "\r\n"]).join([*lines, ""])
    encoding = draw.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "cp1252"])
    words = f"{separator!r} {decimal!r} {header}, {encoding}, clock {clock}, trigger {switch}"
    return Written(text.encode(encoding), words, known)


def stamps(clock: str, t: Array, draw: random.Random) -> list[str]:
    """The time stamps as a recorder writes them."""
    match clock:
        case "s":
            return [f"{v:.6f}" for v in t]
        case "ms":
            return [f"{1e3 * v:.3f}" for v in t]
        case "us":
            return [f"{1e6 * v:.0f}" for v in t]
        case "iso":
            return [(BEGAN + timedelta(seconds=float(v))).isoformat(sep=draw.choice("T ")[0]) for v in t]
        case "german":
            return [(BEGAN + timedelta(seconds=float(v))).strftime("%d.%m.%Y %H:%M:%S.%f") for v in t]
        case "filetime":
            return [str(133_541_000_000_000_000 + round(1e7 * v)) for v in t]
        case _:
            late = [draw.expovariate(1 / 0.2e-3) for _ in t]
            return [f"{v + d:.6f}" for v, d in zip(t, late, strict=True)]


def trigger_fields(switch: str, trigger: Array, draw: random.Random) -> list[str]:
    """The trigger as a recorder writes it."""
    match switch:
        case "words":
            return ["TRUE" if v else "FALSE" for v in trigger]
        case "volts":
            return [f"{24.0 * v + draw.uniform(-0.05, 0.05):.3f}" for v in trigger]
        case "bits":
            return [str(256 + round(v)) for v in trigger]
        case _:
            return [str(round(v)) for v in trigger]


def table(columns: list[tuple[str, str, list[str]]], separator: str, header: str, draw: random.Random) -> Iterator[str]:
    """The lines of a table."""
    labels = [name for name, _, _ in columns]
    if header == "brackets":
        pattern = draw.choice(BRACKETS)
        labels = [pattern.format(name, unit) if unit else name for name, unit, _ in columns]
    if separator in (" ", "aligned"):
        labels = [label.replace(" ", "_") for label in labels]
    rows = [labels] if header != "headless" else []
    if header == "units row":
        rows.append([f"[{unit}]" if unit else "-" for _, unit, _ in columns])
    rows += [[field.replace(" ", "T") if separator in (" ", "aligned") else field for field in row]
             for row in zip(*(fields for _, _, fields in columns), strict=True)]  # fmt: skip
    if header == "preamble":
        yield from ("Recorder 7", "Operator: somebody", f"Sample time: {draw.choice([2, 2.0])} ms", "")
    if separator == "aligned":
        width = 2 + max(len(field) for row in rows[:50] for field in row)
        yield from ("".join(field.rjust(width) for field in row) for row in rows)
    else:
        quoted = draw.random() < 0.2
        for k, row in enumerate(rows):
            yield separator.join(f'"{field}"' if quoted and k == 0 else field for field in row)


def proposed(file: Path) -> Estimate:
    """The estimate of a file with what `look` proposes for it; raises HexciteError where it cannot be read."""
    case = sound().case
    seen = look(file, case)
    form = RecordingFormat.model_validate({"filter_cutoff_Hz": 40.0, **seen.settings})
    own = case.model_copy(update={"recording": form})
    return estimate_parameters(on_one_clock(read(file, own), own), own)


def tally_of_rearranged(seeds: range, folder: Path) -> Tally:
    """Files of recorders, every second one damaged, read as `look` proposes, and identified."""

    def one(seed: int, tally: Tally) -> None:
        drawn = written(seed)
        content = drawn.content
        if seed % 2 and not drawn.words.count("utf-16"):
            content = stained(content.decode("latin-1"), random.Random(seed))
        file = folder / "run.txt"
        file.write_bytes(content)
        found = tally.attempt(seed, lambda: proposed(file), str(file))
        if found is None:
            if drawn.known and not seed % 2:
                tally.counts["refused though sound"] += 1
                tally.counts["refused"] -= 1
            return
        if any(f.severity == "warning" and f.kind not in ABOUT_THE_FILE for f in found.findings):
            tally.counts.update({"answered": -1, "answered with findings": 1})
            return
        truth = sound().truth
        off = {name: abs(p.value - truth[name]) / p.reported for name, p in found.physical.items() if name in truth}
        worst = max(off, key=lambda name: off[name])
        if not np.isfinite(off[worst]) or (off[worst] > DEVIATIONS and found.model.number == 9):
            tally.defect(seed, f"{drawn.words}: {worst} is {off[worst]:.1f} deviations off without a finding")

    return tallied("files as recorders write them", seeds, one)
