"""All kinds of damaged input and of accidents, by seeds: nothing breaks, hangs, is lost, or is wrong unnoticed.

python -m tests.bench.reliability.everything --seed 1                  all of `make nightly`, hours
python -m tests.bench.reliability.everything texts cases --count 100   some kinds
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.bench.reliability.executed import tally_of_executed
from tests.bench.reliability.folders import tally_of_cases, tally_of_plans, tally_of_recordings, tally_of_results
from tests.bench.reliability.interrupted import tally_of_full_disks, tally_of_kills
from tests.bench.reliability.long_texts import tally_of_long_texts
from tests.bench.reliability.programs import DIALECTS
from tests.bench.reliability.rearranged import tally_of_rearranged
from tests.bench.reliability.recordings import tally_of_other_files, tally_of_runs
from tests.bench.reliability.stored import tally_of_bags, tally_of_parquet
from tests.bench.reliability.tally import Tally
from tests.bench.reliability.texts import tally_of_texts
from tests.bench.reliability.urdf import tally_of_urdf


@dataclass(frozen=True)
class Part:
    """A kind of input.

    Args:
        name: what the command line calls it.
        count: how many seeds `make nightly` tries.
        tally_of: tries them; the folder is empty at first and may be written to.
    """

    name: str
    count: int
    tally_of: Callable[[range, Path], Tally]


def _of_programs(dialect: str) -> Callable[[range, Path], Tally]:
    return lambda seeds, _: DIALECTS[dialect](seeds)


PARTS = (
    *(Part(f"programs of {dialect}", 20_000, _of_programs(dialect)) for dialect in DIALECTS),
    Part("random programs", 1_000, tally_of_executed),
    Part("cases", 5_000, tally_of_cases),
    Part("urdf", 5_000, tally_of_urdf),
    Part("plans", 5_000, tally_of_plans),
    Part("recordings", 5_000, tally_of_recordings),
    Part("results", 5_000, tally_of_results),
    Part("texts", 5_000, tally_of_texts),
    Part("long texts", 2_000, tally_of_long_texts),
    Part("bags", 5_000, tally_of_bags),
    Part("parquet", 5_000, tally_of_parquet),
    Part("rearranged", 10_000, tally_of_rearranged),
    Part("other files", 5_000, tally_of_other_files),
    Part("runs", 5_000, tally_of_runs),
    Part("kills", 200, tally_of_kills),
    Part("full disks", 6, tally_of_full_disks),
)
"""What is tried, one after the other; a new kind is a line here."""


def tallies(parts: tuple[Part, ...], first: int, count: int | None = None) -> Iterator[Tally]:
    """The tallies of some kinds, one after the other.

    Args:
        parts: kinds.
        first: seed of the first input of each kind.
        count: inputs of each kind; None: as many as `make nightly` tries.
    """
    for part in parts:
        with tempfile.TemporaryDirectory() as name:
            yield part.tally_of(range(first, first + (part.count if count is None else count)), Path(name))


def main() -> None:
    """Prints the tallies; exit code 1 where there are defects."""
    names = {part.name: part for part in PARTS}
    parser = argparse.ArgumentParser()
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"all where none is named: {', '.join(names)}")
    parser.add_argument("--seed", type=int, default=0, help="the first one")
    parser.add_argument("--count", type=int, help="inputs of each part; as many as `make nightly` tries")
    asked = parser.parse_args()
    if unknown := [name for name in asked.parts if name not in names]:
        parser.error(f"there is no {', '.join(unknown)}; choose from {', '.join(names)}")
    chosen = tuple(names[name] for name in asked.parts) or PARTS
    print(f"seeds from {asked.seed} on", flush=True)
    found = 0
    for tally in tallies(chosen, asked.seed, asked.count):
        print(*tally.row(), flush=True)
        found += len(tally.defects)
    sys.exit(found > 0)


if __name__ == "__main__":
    main()
