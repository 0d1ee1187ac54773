"""Causes of mistakes in recordings and cases: which are named, on six kinds of machines, over seeds of motion, noise.

For each machine every mistake is made alone, then a sample of pairs, then what is no cause that hexcite knows, then
nothing. Recordings are made once for each seed, by plants that share no code with hexcite; mistakes change them or the
case. A cause counts as named right where its words are in what is said, and its sizes are right within four of the
deviations that are said with them; as one of several where others are said beside it, joined by "or"; as the same
forces where only others are, that leave what the sound run leaves within a hundredth; as wrong where only others are,
that leave anything else.

Usage: python tests/bench/causes.py [--seeds 20] [--pairs 20] [--sound 170] [machine ..]
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from time import process_time

import numpy as np
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from identification.findings.causes.answer import causes_of
from identification.findings.causes.search import search
from identification.identify import default_model, fits
from identification.model.model import identification_model
from identification.samples.samples import GAUSS_MARKOV
from tests.mistaken.machines import NAMES, Run, run
from tests.mistaken.mistakes import Mistake, mistakes_of, others_of

RIGHT, AMONG, SAME, NONE = "right", "among others", "the same forces", "none named"
QUIET, WRONG = "near the noise", "WRONG"
KINDS = (RIGHT, AMONG, SAME, NONE, QUIET, WRONG)
EQUAL = 2e-2  # of residuals: sizes that are found lower those of few standstills, turned channels have other noise


def named(run: Run, mistakes: Sequence[Mistake]) -> tuple[str, float, str]:
    """What becomes of a run with some mistakes: the kind of answer, processor time [s], and what was said."""
    recording, case = run.recording, run.case
    for mistake in mistakes:
        recording, case = mistake.make(run, recording, case)
    began = process_time()
    model = identification_model(case, default_model(recording, case))
    found = search(recording, case, model)
    if found is None or found.sound:
        return QUIET, process_time() - began, ""
    causes = causes_of(found, recording, case, model, fits(model.number, GAUSS_MARKOV))
    seconds = process_time() - began
    said = [cause.words for cause in causes]
    good = [bool(mistakes) and all(mistake.named_in(words) for mistake in mistakes) for words in said]
    kind = NONE if not said else RIGHT if all(good) else AMONG if any(good) else WRONG
    if kind == WRONG and mistakes and all(mistake.of != "other" for mistake in mistakes):
        left = sound(run)
        if all(abs(cause.entry.residuals / left - 1.0) < EQUAL for cause in causes):
            kind = SAME
    return kind, seconds, " OR ".join(said)


def sound(run: Run) -> float:
    """What the run leaves as it was recorded, over the noise."""
    found = search(run.recording, run.case, identification_model(run.case, default_model(run.recording, run.case)))
    assert found is not None
    assert found.recorded is not None
    return found.recorded.residuals


def alone(name: str, seeds: int) -> Iterator[tuple[str, Sequence[Mistake], int]]:
    """Each mistake of a machine, over seeds."""
    for mistake in mistakes_of(name):
        yield from ((mistake.name, (mistake,), seed) for seed in range(seeds))


_BEFORE = ("sensor", "gravity", "point", "axes", "signs")
"""What happens to a wrench before a recorder has it: where the sensor is, what a controller makes of it, its signs."""


def _happens(mistake: Mistake) -> int:
    """Where in the way of a wrench a mistake is made; those of the recorder and of the case last."""
    return _BEFORE.index(mistake.of) if mistake.of in _BEFORE else len(_BEFORE)


def in_pairs(name: str, pairs: int, seeds: int) -> Iterator[tuple[str, Sequence[Mistake], int]]:
    """A seeded sample of pairs of mistakes that concern different things."""
    draw = np.random.default_rng(36)
    possible = [pair for pair in combinations(mistakes_of(name), 2) if pair[0].of != pair[1].of]
    for k in draw.permutation(len(possible))[:pairs]:
        one, other = sorted(possible[int(k)], key=_happens)
        yield from ((f"{one.name} + {other.name}", (one, other), seed) for seed in range(seeds))


def tally(title: str, trials: Iterator[tuple[str, Sequence[Mistake], int]], name: str, verbose: bool) -> Counter[str]:
    """Counts of answers; what is not right is printed."""
    counts, seconds = Counter[str](), []
    for label, mistakes, seed in trials:
        try:
            if len(mistakes) > 1 and any(named(run(name, seed), (each,))[0] == QUIET for each in mistakes):
                continue  # one of them does not show in this motion
            kind, took, said = named(run(name, seed), mistakes)
        except ValueError as error:  # a case that two mistakes make impossible
            print(f"  {name}: {label}: left out, {str(error)[:80]}", flush=True)
            continue
        counts[kind] += 1
        seconds.append(took)
        if kind != (RIGHT if mistakes else QUIET) and (verbose or kind == WRONG):
            print(f"  {name}, seed {seed}: {label}: {kind} {said}", flush=True)
    figures = ", ".join(f"{kind} {counts[kind]}" for kind in KINDS if counts[kind])
    times = f"; {np.mean(seconds):.2f} s, at most {np.max(seconds):.2f} s" if seconds else ""
    print(f"{name:16s} {title:8s} {counts.total():5d}: {figures}{times}", flush=True)
    return counts


def main() -> None:
    """Parses the command line and prints the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="machine", help=f"all by default: {', '.join(NAMES)}")
    parser.add_argument("--seeds", type=int, default=20, help="motions of each mistake")
    parser.add_argument("--pair-seeds", type=int, default=2, help="motions of each pair")
    parser.add_argument("--pairs", type=int, default=20, help="pairs of mistakes of each machine")
    parser.add_argument("--sound", type=int, default=170, help="sound runs of each machine")
    parser.add_argument("-v", "--verbose", action="store_true", help="print every answer that is not right")
    given = parser.parse_args()
    totals: dict[str, Counter[str]] = {}
    with threadpool_limits(limits=1, user_api="blas"):
        for name in given.names or NAMES:
            others = [(m.name, (m,), seed) for m in others_of(name) for seed in range(given.seeds)]
            for title, trials in (
                ("alone", alone(name, given.seeds)),
                ("pairs", in_pairs(name, given.pairs, given.pair_seeds)),
                ("others", iter(others)),
                ("sound", (("sound", (), 1000 + seed) for seed in range(given.sound))),
            ):
                totals.setdefault(title, Counter()).update(tally(title, trials, name, given.verbose))
    for title, counts in totals.items():
        figures = ", ".join(f"{kind} {counts[kind]}" for kind in KINDS if counts[kind])
        print(f"{'all':16s} {title:8s} {counts.total():5d}: {figures}")


if __name__ == "__main__":
    main()
