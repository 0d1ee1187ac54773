"""Damaged recordings of machines whose truth is known: is a wrong number said to be wrong, and a sound run left alone?

python tests/bench/silent.py                      # every damage on every machine: right, flagged, refused, SILENT
python tests/bench/silent.py hexapod --of gain    # some of it
python tests/bench/silent.py --sound 1000         # sound runs of all machines, with noise of all kinds
"""

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.errors import HexciteError
from identification.identify import estimate_parameters
from tests.damaged.kinds import Damage, damages_of
from tests.damaged.runs import SOUND, Change, Machine, Moves, Noise, Waves, machine, recorded, truth_of

MACHINES = ("hexapod", "mill", "ur10_wrist", "five_axis_table")
FAR = 4.0  # reported deviations: an error beyond it is a wrong number
NOISES = {
    "white": Noise(),
    "white, stated 20 % too low": Noise(1.2),
    "remembers 10 ms": Noise(0.3, 0.01, 0.9),
    "remembers 50 ms": Noise(0.5, 0.05, 0.8),
    "remembers 0.3 s": Noise(0.7, 0.3, 0.6),
    "hum of 50 Hz": Noise(1.0, hum=2.0),
    "in steps": Noise(1.0, step=1.0),
}


class Verdict(NamedTuple):
    """What identification made of a run."""

    word: str  # right, flagged, refused, SILENT
    worst: str  # parameter of the largest error
    error: float  # in reported deviations
    wide: float  # reported deviation of the mass over its value
    said: str  # the first warning, or the refusal
    seconds: float


def verdict(
    of: Machine, way: Waves | Moves, seed: int, noise: Noise, change: Change = SOUND, model: int | None = None
) -> Verdict:
    """Of a run with or without a damage."""
    run = recorded(of, way, seed, noise, change)
    began = time.process_time()
    try:
        estimate = estimate_parameters(run, of.case, model)
    except HexciteError as error:
        return Verdict("refused", "", 0.0, 0.0, str(error), time.process_time() - began)
    seconds = time.process_time() - began
    truth = change.truth or truth_of(of.plant)
    errors = {
        k: (p.value - truth[k]) / p.reported for k, p in estimate.physical.items() if k in truth and p.reported > 0.0
    }
    worst = max(errors, key=lambda name: abs(errors[name]))
    mass = estimate.physical["m"]
    said = estimate.warnings[0] if estimate.warnings else ""
    word = "flagged" if said else "SILENT" if abs(errors[worst]) > FAR else "right"
    return Verdict(word, worst, errors[worst], mass.reported / abs(mass.value), said, seconds)


def way_of(of: Machine, seed: int, duration: float = 8.0) -> Waves | Moves:
    """A motion of a machine: moves or waves."""
    size = 0.6 if of.name in ("mill",) else 0.8
    return (Moves if seed % 2 else Waves)(of, seed, duration, size)


def table(names: Sequence[str], only: str, seeds: Sequence[int]) -> Iterator[tuple[str, Damage, float, int, Verdict]]:
    """Verdicts of damages on machines."""
    for name in names:
        of = machine(name)
        for damage in damages_of(of):
            if only not in damage.name:
                continue
            for seed in seeds:
                for size in damage.sizes:
                    yield (
                        name,
                        damage,
                        size,
                        seed,
                        verdict(of, way_of(of, seed), seed, Noise(), damage.change(of, size)),
                    )


def main() -> None:
    """Prints the table, or what is said of sound runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("machines", nargs="*", default=list(MACHINES))
    parser.add_argument("--of", default="", help="damages whose name holds this")
    parser.add_argument("--seeds", type=int, nargs="*", default=[1, 2])
    parser.add_argument("--sound", type=int, default=0)
    given = parser.parse_args()
    counts: dict[str, int] = {}
    if given.sound:
        for k in range(given.sound):
            name = given.machines[k % len(given.machines)]
            kind = list(NOISES)[(k // len(given.machines)) % len(NOISES)]
            of = machine(name)
            found = verdict(of, way_of(of, 1000 + k, 6.0 + k % 3), k, NOISES[kind])
            counts[found.word] = counts.get(found.word, 0) + 1
            if found.word != "right":
                print(
                    f"{k} {name} | {kind} | {found.word} | {found.worst} {found.error:+.1f} | {found.said}", flush=True
                )
        print(counts)
        return
    for name, damage, size, seed, found in table(given.machines, given.of, given.seeds):
        word = "invisible" if damage.invisible and found.word == "SILENT" else found.word
        counts[word] = counts.get(word, 0) + 1
        print(
            f"{name[:8]:8} | {damage.name} | {size:g} {damage.unit} | {seed} | {word} | {found.worst} "
            f"{found.error:+.1f} | m +- {100 * found.wide:.2g} % | {found.said[:230]} | {found.seconds:.2f} s",
            flush=True,
        )
    print(counts)


if __name__ == "__main__":
    main()
