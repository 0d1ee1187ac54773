"""How wide deviations are: errors that noise of a known kind makes, over the reported deviations.

python tests/bench/noise.py                                  # all machines, 14 runs each, and standstills
python tests/bench/noise.py 6 --of hexapod --noise white     # fewer
python tests/bench/noise.py --standstills                    # means of standstills alone, seconds
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from identification.estimation.standing_mean import standing_mean
from identification.identify import identify
from identification.motion.motion import Motion
from tests.bench.silent import way_of
from tests.damaged.runs import SOUND, Change, Noise, machine, recorded

NAMES = ("hexapod", "ur10_wrist", "five_axis_table", "panda")
BLUE = "white noise of encoders"
NOISES = {
    "white": Noise(),
    "remembers 50 ms": Noise(0.5, 0.05, 0.8),
    "remembers 0.3 s": Noise(0.7, 0.3, 0.6),
    "remembers 1 s": Noise(0.7, 1.0, 0.6),
    BLUE: Noise(encoder=0.0),
}
SIZES = np.array([1e-6, 20e-6])  # of the noise of encoders that slide and turn [m, rad]
STANDING = ((0.0, 0.0), (0.05, 0.8), (0.3, 0.3), (0.3, 0.65), (0.3, 1.0), (1.0, 0.6), (3.0, 0.6))
SECONDS, RATE, STANDSTILLS = 2.0, 250.0, 150


def blue(slides: np.ndarray) -> Change:
    """Encoders with white noise, of joints that slide or turn."""
    size = np.where(slides, *SIZES)

    def noisy(_: Motion, drives: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        return drives + size * draw.normal(size=drives.shape)

    return Change(drives=noisy)


def errors(name: str, kind: str, seed: int) -> tuple[dict[str, float], bool]:
    """Of each parameter the error over its deviation, in a run of 4 to 6 s of a machine that is as its case says.

    And whether a note says that the run is short for what its noise remembers.
    """
    of = machine(name)
    slides = np.ones(6, dtype=bool) if of.case.chain is None else np.array([j.slides for j in of.plant.joints])
    change = blue(slides) if kind == BLUE else SOUND
    found = identify(recorded(of, way_of(of, seed, 4.0 + seed % 3), seed, NOISES[kind], change), of.case)
    told = any("slow_noise" in finding.quantity for finding in found.findings)
    known = {name: true for name, true in of.truth.items() if name in found.parameters}
    return {name: (found[name].value - true) / found[name].reported for name, true in known.items()}, told


def words(off: np.ndarray) -> str:
    """Root mean square, its own deviation by the scatter of runs, and shares, of errors by run, shape (n, k)."""
    squares = np.mean(off**2, axis=1)
    size = float(np.sqrt(squares.mean()))
    own = float(squares.std(ddof=1) / np.sqrt(len(squares)) / 2.0 / size) if len(squares) > 1 else np.nan
    inside, beyond = np.mean(np.abs(off) < 1.96), np.mean(np.abs(off) > 3.0)
    return f"{size:.2f} +- {own:.2f}, within 1.96: {100 * inside:.1f} %, beyond 3: {100 * beyond:.1f} %"


def runs(names: list[str], kinds: list[str], repeats: int, first: int) -> None:
    """Prints each machine with each noise."""
    for kind in kinds:
        for name in names:
            found = [errors(name, kind, seed) for seed in range(first, first + repeats)]
            rows, told = [row for row, _ in found], sum(told for _, told in found)
            off = np.array([list(row.values()) for row in rows])
            offsets = np.array([parameter.startswith("f_q0") for parameter in rows[0]])
            print(f"{name} | {kind} | {words(off)} | offsets {words(off[:, offsets])} | told {told}", flush=True)


def standing(memory: float, share: float, seed: int) -> np.ndarray:
    """A standstill of six channels of variance 1 and mean 0: white, and a share that remembers so many seconds."""
    draw, count = np.random.default_rng(seed), round(SECONDS * RATE)
    white = draw.normal(size=(count, 6))
    if not memory:
        return white
    keep, before = np.exp(-1.0 / (memory * RATE)), round(8.0 * memory * RATE)
    slow = lfilter([1.0], [1.0, -keep], draw.normal(size=(count + before, 6)), axis=0)[before:]
    return np.asarray(np.sqrt(1.0 - share**2) * white + share * np.sqrt(1.0 - keep**2) * slow)


def standstills() -> None:
    """Prints how means are off, and in how many standstills a note says that they are short."""
    for memory, share in STANDING:
        off, told = [], 0
        for seed in range(STANDSTILLS):
            values = standing(memory, share, seed)
            found = standing_mean(values)
            off.append(values.mean(axis=0) / np.sqrt(np.diag(found.covariance)))
            told += found.short
        print(f"standstill of {SECONDS:g} s | {share:g} remembers {memory:g} s | {words(np.array(off))} | told {told}")


def main() -> None:
    """Prints what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repeats", type=int, nargs="?", default=14)
    parser.add_argument("--of", nargs="*", default=list(NAMES), help="names of machines")
    parser.add_argument("--noise", nargs="*", default=list(NOISES), help="kinds of noise")
    parser.add_argument("--first", type=int, default=93_000, help="seed of the first run")
    parser.add_argument("--standstills", action="store_true", help="these alone")
    asked = parser.parse_args()
    standstills()
    if not asked.standstills:
        runs(asked.of, asked.noise, asked.repeats, asked.first)


if __name__ == "__main__":
    main()
