"""All kinds of damaged input, with counts and a first seed: nothing breaks, hangs, or is wrong unnoticed.

python -m tests.bench.reliability.everything --seed 1 --recordings 1000 --programs 3000
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.bench.reliability.folders import tally_of_cases, tally_of_plans, tally_of_results
from tests.bench.reliability.programs import DIALECTS
from tests.bench.reliability.rearranged import tally_of_rearranged
from tests.bench.reliability.recordings import tally_of_other_files, tally_of_runs
from tests.bench.reliability.tally import Tally
from tests.bench.reliability.texts import tally_of_texts

COUNTS = {"recordings": 20_000, "texts": 5_000, "programs": 20_000, "cases": 5_000, "folders": 2_000}
"""How many of each kind `make bench` tries; programs are of each dialect."""


def tallies(counts: dict[str, int], first: int = 0) -> Iterator[Tally]:
    """The tallies of all kinds, one after the other.

    Args:
        counts: inputs of each kind; none of the kinds that are left out.
        first: seed.
    """

    def seeds(kind: str, share: float = 1.0) -> range:
        return range(first, first + round(share * counts.get(kind, 0)))

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for tally_of in DIALECTS.values():
            yield tally_of(seeds("programs"))
        yield tally_of_cases(seeds("cases"), folder)
        yield tally_of_plans(seeds("folders", 0.5), folder)
        yield tally_of_results(seeds("folders", 0.5), folder)
        yield tally_of_texts(seeds("texts"), folder)
        yield tally_of_rearranged(seeds("recordings", 0.5), folder)
        yield tally_of_other_files(seeds("recordings", 0.25), folder)
        yield tally_of_runs(seeds("recordings", 0.25), folder)


def reliability_rows(counts: dict[str, int] = COUNTS) -> list[list[str]]:
    """Defects among damaged inputs."""
    return [tally.row() for tally in tallies(counts)]


def main() -> None:
    """Prints the tallies; exit code 1 where there are defects."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=0)
    for kind in COUNTS:
        parser.add_argument(f"--{kind}", type=int, default=0)
    asked = vars(parser.parse_args())
    found = 0
    for tally in tallies(asked, asked["seed"]):
        if tally.tried:
            print(*tally.row(), flush=True)
            found += len(tally.defects)
    sys.exit(found > 0)


if __name__ == "__main__":
    main()
