"""Whole searches from several seeds: what share of the best known they find, how long they take, whether they converge.

    python tests/bench/searches.py                                           # all machines, families and seeds: hours
    python tests/bench/searches.py --machines hexapod,panda --families best,spline --seeds 0,1
    python tests/bench/searches.py --known 600                               # first looks for the best with other seeds
    python tests/bench/searches.py --seconds 10                              # what is found in so many seconds

Machines are built-in cases, those of the portfolio, `drawn_SEED`, and robots of `tests/bench/robots`. `best` is a plan
without `--family`. The best known is the best of all runs of a machine and family here, none of them from a file; for
`best` it is that of all families.
"""

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from planner.families.settings import Best
from tests.bench.machines.description import write_machine
from tests.bench.machines.designed import DESIGNED
from tests.bench.portfolio import command, machine
from tests.bench.tables import print_table

ROBOTS = Path(__file__).parent / "robots"
BUILT_IN = ("hexapod", "ur10_wrist", "five_axis_table")
FAMILIES = ("fourier", "ptp", "spline", Best.name)
OTHER = 1000  # first seed of searches for the best known


@dataclass(frozen=True)
class Run:
    """A whole `hexcite plan`."""

    machine: str
    family: str  # as asked for
    seed: int
    efficiency: float
    seconds: float  # wall time
    processor: float  # processor time [s]
    converged: bool
    found: str  # family of the plan


def case_of(name: str, folder: Path) -> str:
    """What names the case of a machine on the command line; made ones are written into a folder."""
    if name in BUILT_IN:
        return name
    if (ROBOTS / name).is_dir():
        return str(ROBOTS / name)
    return str(write_machine(folder, name, machine(name)))


def planned(name: str, family: str, seed: int, options: Sequence[str] = ()) -> Run | None:
    """One search; None where it failed, which is printed."""
    with tempfile.TemporaryDirectory() as temporary:
        own = () if family == Best.name else ("--family", family)
        folder = case_of(name, Path(temporary))
        done = command(("plan", folder, *own, "--seed", str(seed), *options, "-o", str(Path(temporary) / "plan")))
    if done.answer is None:
        print(f"{name}, {family}, seed {seed}: {done.error}", file=sys.stderr, flush=True)
        return None
    best = next((start for start in done.answer["starts"] if start["refined"]), {"converged": False})
    run = Run(
        name, family, seed, done.answer["d_efficiency"], done.seconds, done.processor, best["converged"],
        done.answer["family"],
    )  # fmt: skip
    print(run, file=sys.stderr, flush=True)
    return run


def searches(
    machines: Sequence[str], families: Sequence[str], seeds: Sequence[int], known: float | None, options: Sequence[str]
) -> None:
    """Prints a table of machines and families: medians over seeds, and the spread.

    Args:
        known: how long each family is first searched for the best known, from another seed [s].
        options: further words for `hexcite plan`.
    """
    rows, shares, converged = [], [], []
    for name in machines:
        runs: list[Run] = []
        others: list[Run] = []
        for family in families:
            if known is not None:
                longer = planned(name, family, OTHER, ("--seconds", f"{known:g}"))
                others += [] if longer is None else [longer]
            runs += [run for seed in seeds if (run := planned(name, family, seed, options)) is not None]
        for family in families:
            own = [run for run in runs if run.family == family]
            if not own:
                rows.append([name, family, "failed", *[""] * 6])
                continue
            best = max(run.efficiency for run in (*runs, *others) if family in (Best.name, run.family, run.found))
            share = np.array([run.efficiency / best for run in own])
            shares += share.tolist()
            converged += [run.converged for run in own]
            rows.append(
                [
                    name,
                    family,
                    f"{np.median([run.efficiency for run in own]):.3f}",
                    f"{best:.3f}",
                    f"{np.median(share):.3f}",
                    f"{share.min():.3f} to {share.max():.3f}",
                    f"{np.median([run.seconds for run in own]):.0f} s",
                    f"{np.median([run.processor for run in own]):.0f} s",
                    f"{sum(run.converged for run in own)} of {len(own)}",
                    ", ".join(sorted({run.found for run in own})),
                ]
            )
    columns = (
        "machine", "family", "efficiency", "best known", "share", "spread", "time", "processor", "converged", "found",
    )  # fmt: skip
    print_table(f"Searches, medians over seeds {', '.join(map(str, seeds))}", columns, rows)
    if shares:
        print(f"{len(shares)} searches: median share {np.median(shares):.3f}, {sum(converged)} converged")


def main() -> None:
    """Parses the command line."""
    every = (*BUILT_IN, *sorted(folder.name for folder in ROBOTS.iterdir()), *DESIGNED)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--machines", default=",".join(every), help="with commas between")
    parser.add_argument("--families", default=",".join(FAMILIES), help="with commas between")
    parser.add_argument("--seeds", default="0,1,2,3,4", help="with commas between")
    parser.add_argument("--known", type=float, metavar="SECONDS", help="of each machine and family")
    parser.add_argument("--seconds", type=float, help="of each search; by default as long as it pays")
    given = parser.parse_args()
    options = () if given.seconds is None else ("--seconds", f"{given.seconds:g}")
    seeds = [int(seed) for seed in given.seeds.split(",")]
    searches(given.machines.split(","), given.families.split(","), seeds, given.known, options)


if __name__ == "__main__":
    main()
