"""Robots from public descriptions, one with seven joints: planned moves against chance, at equal time and moves.

Prints for each the D-efficiency of a plan of 10 s, that of the best of some random feasible walks of as many moves, and
what the search cost. The cases stand in `tests/bench/robots`, with their sources.

Usage: python tests/bench/robots.py [--starts 4] [--walks 100] [robot ..]
"""

import argparse
import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.schema import load_case
from identification.estimation.criteria import reference_scaling
from identification.model.model import identification_model
from planner.bounds.bound import information_limit
from planner.families.ptp import PointToPointFamily
from planner.families.settings import PointToPoint
from planner.noise import mean_information
from planner.plans.making import make
from planner.request import Request
from planner.search.feasibility import keep_limits
from planner.search.parallel import run_here, silent
from tests.bench.tables import print_table
from tests.random_start import random_start

ROBOTS = Path(__file__).parent / "robots"
DURATION, RATE = 10.0, 1000.0  # [s], [1/s]


def planned(name: str, starts: int, walks: int) -> list[str]:
    """A row of the table: what a search finds on a robot, beside chance."""
    case = load_case(str(ROBOTS / name))
    model = identification_model(case, 6)
    scaling, bound = reference_scaling(case, model), information_limit(case, model)
    began = process_time()
    plan = make(Request(PointToPoint(), DURATION, model=6, starts=starts), case, silent, run_here)
    cost = process_time() - began
    family = PointToPointFamily.of(case, PointToPoint().count(case, DURATION), DURATION)
    chance = []
    for seed in range(walks):
        walk = random_start(family, np.random.default_rng(seed), lambda unknowns: 1.0)
        inside, _ = keep_limits(case, family, walk, RATE)
        information = mean_information(model, scaling, family.motion(inside))
        chance.append(bound.efficiency(float(np.linalg.slogdet(information)[1])))
    found, best = plan.of_motion[1].d_efficiency, max(chance)
    joints = str(len(case.need_motion("the bench")[0]))
    return [name, joints, str(family.moves), f"{found:.3f}", f"{best:.3f}", f"{found / best:.1f}", f"{cost:.0f} s"]


def main() -> None:
    """Parses the command line and prints the table."""
    every = sorted(folder.name for folder in ROBOTS.iterdir())
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="robot", help=f"all by default: {', '.join(every)}")
    parser.add_argument("--starts", type=int, default=4, help="of each search")
    parser.add_argument("--walks", type=int, default=100, help="random walks beside each plan")
    given = parser.parse_args()
    rows = [planned(name, given.starts, given.walks) for name in given.names or every]
    columns = ("robot", "joints", "moves", "D-efficiency", "best of the walks", "times", "processor time")
    print_table(f"Moves of {DURATION:g} s beside {given.walks} random walks", columns, rows)


if __name__ == "__main__":
    main()
