"""Damaged recordings of machines whose truth is known: is a wrong number said to be wrong, and a sound run left alone?

python tests/bench/silent.py                      # every damage on every machine: right, flagged, refused, SILENT
python tests/bench/silent.py hexapod --of gain    # some of it
python tests/bench/silent.py --sound 1000         # sound runs of drawn machines, with noise of all kinds
"""

import argparse
import itertools
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.base.errors import HexciteError
from identification.identify import estimate_parameters
from identification.results.estimate import Estimate
from tests.damaged.kinds import Damage, damages_of
from tests.damaged.runs import (
    CHAIN,
    HEXAPOD,
    SOUND,
    Change,
    Machine,
    Moves,
    Noise,
    Waves,
    machine,
    reached,
    recorded,
    truth_of,
)

MACHINES = ("hexapod", "mill", "ur10_wrist", "five_axis_table")
FRESH = 20_000  # seed from which on no run and no machine was looked at while the judgement was made
TOLD = "told beforehand"  # no warning, but a note names the parameter as one that such a damage biases unseen
FAR = 4.0  # reported deviations: an error beyond it is a wrong number
WORDS = ("right", "flagged", "refused", TOLD, "SILENT", "invisible")
SIZES = (0.8, 0.6, 0.4, 0.2, 0.1)  # of motions, as shares of the limits
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

    word: str  # right, flagged, refused, told beforehand, SILENT
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
    silent = TOLD if _linear(worst) in _told(estimate) else "SILENT"
    word = "flagged" if said else silent if abs(errors[worst]) > FAR else "right"
    return Verdict(word, worst, errors[worst], mass.reported / abs(mass.value), said, seconds)


def _told(estimate: Estimate) -> set[str]:
    """Linear parameters of which a note says what of this size would bias them unseen (`not_shown`)."""
    return {entry["parameter"] for f in estimate.findings for entry in f.quantity.get("not_shown", ())}


def _linear(name: str) -> str:
    """The linear parameter that a physical one follows from."""
    return f"m{name}" if name in ("xC", "yC", "zC") else name.replace("IC", "I")


def way_of(of: Machine, seed: int, duration: float = 8.0) -> Waves | Moves:
    """A motion of a machine, moves or waves, as large as its struts are long and short enough for."""
    for size in SIZES:
        way = (Moves if seed % 2 else Waves)(of, seed, duration, size)
        if reached(of, way):
            break
    return way


def table(
    names: Sequence[str], only: str, seeds: Sequence[int], times: float = 1.0
) -> Iterator[tuple[str, Damage, float, int, Verdict]]:
    """Verdicts of damages on machines; times: what the sizes of the damages are multiplied by."""
    for name in names:
        of = machine(name)
        for damage in damages_of(of):
            if only not in damage.name:
                continue
            for seed in seeds:
                for size in (times * each for each in damage.sizes):
                    yield (
                        name,
                        damage,
                        size,
                        seed,
                        verdict(of, way_of(of, seed), seed, Noise(), damage.change(of, size)),
                    )


def drawn_machines(first: int) -> Iterator[str]:
    """Names of machines that nothing was tuned on: hexapods and chains in turn, from a seed onwards."""
    for seed in itertools.count(first):
        yield f"{CHAIN if seed % 2 else HEXAPOD}{seed}"


def sound(count: int, names: Iterable[str], first: int) -> Iterator[tuple[int, str, str, Verdict]]:
    """Verdicts of sound runs of 4 to 6 s, each machine with noise of all kinds: seed, machine, noise, verdict."""
    seeds = itertools.count(first)
    for name, kind in itertools.islice(itertools.product(names, NOISES), count):
        seed, of = next(seeds), machine(name)
        yield seed, name, kind, verdict(of, way_of(of, seed, 4.0 + seed % 3), seed, NOISES[kind])


def word_of(damage: Damage, found: Verdict) -> str:
    """A verdict's word, where what no data can show is none that is silent."""
    return "invisible" if damage.invisible and found.word == "SILENT" else found.word


def silent_rows(names: Sequence[str] = ("hexapod", "ur10_wrist"), sounds: int = 70) -> list[list[str]]:
    """Damages of machines counted by what was made of them, those that say less when they grow, and sound runs."""
    rows = []
    for name in names:
        counts, less, last = Counter[str](), 0, dict[str, bool]()
        for _, damage, _, _, found in table([name], "", [1]):
            counts[word_of(damage, found)] += 1
            said = found.word in ("flagged", "refused")
            less += last.get(damage.name, False) and not said
            last[damage.name] = said
        words = ", ".join(f"{word} {counts[word]}" for word in WORDS)
        rows.append([f"damaged recordings of {name}", words, "SILENT 0"])
        rows.append(["  where a larger damage says less than a smaller one", str(less), "0"])
    verdicts = [found for *_, found in sound(sounds, _some(drawn_machines(FRESH), sounds), FRESH)]
    accused = sum(found.word in ("flagged", "refused") for found in verdicts)
    far = sum(abs(found.error) > FAR for found in verdicts)
    rows.append([f"{sounds} sound runs of drawn machines: accused", str(accused), "0"])
    rows.append([f"  beyond {FAR:g} reported deviations", str(far), "0"])
    return rows


def _some(names: Iterator[str], sounds: int) -> list[str]:
    return list(itertools.islice(names, 1 + sounds // len(NOISES)))


def main() -> None:
    """Prints the table, or what is said of sound runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("machines", nargs="*")
    parser.add_argument("--of", default="", help="damages whose name holds this")
    parser.add_argument("--seeds", type=int, nargs="*", default=[1, 2])
    parser.add_argument("--times", type=float, default=1.0, help="what sizes of damages are multiplied by")
    parser.add_argument("--sound", type=int, default=0)
    parser.add_argument("--first", type=int, default=FRESH, help="seed of the first sound run and drawn machine")
    given = parser.parse_args()
    counts = Counter[str]()
    if given.sound:
        names = given.machines or _some(drawn_machines(given.first), given.sound)
        for seed, name, kind, found in sound(given.sound, names, given.first):
            counts[found.word] += 1
            if found.word != "right":
                print(f"{seed} {name} | {kind} | {found.word} | {found.worst} {found.error:+.1f} | {found.said}")
            if sum(counts.values()) % 50 == 0:
                print(dict(counts), flush=True)
        print(dict(counts))
        return
    for name, damage, size, seed, found in table(given.machines or MACHINES, given.of, given.seeds, given.times):
        word = word_of(damage, found)
        counts[word] += 1
        print(
            f"{name[:12]:12} | {damage.name} | {size:g} {damage.unit} | {seed} | {word} | {found.worst} "
            f"{found.error:+.1f} | m +- {100 * found.wide:.2g} % | {found.said[:230]} | {found.seconds:.2f} s",
            flush=True,
        )
    print(dict(counts))


if __name__ == "__main__":
    main()
