"""Looks for better starts to ship with hexcite, on the built-in hexapod by default settings.

    python tests/bench/shipped_starts.py 600                     # seconds a family
    python tests/bench/shipped_starts.py 600 --families spline

`planner/families/shipped.json` keeps the best of each family that was ever found, with its D-efficiency.
"""

import argparse
import json
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.errors import HexciteError
from cases.files import write_text
from cases.loading import load_case
from identification.model import identification_model
from planner.bounds.kept import box_bound
from planner.families.saved import FILE, shipped_start
from planner.families.settings import family_class
from planner.search.solving import Start, Step, Task, run_start

DIGITS = 5
PROMISING = 0.97  # share of the best from which an exploration is refined
HARDER = 4  # refinements one after the other


def search(family_name: str, seconds: float) -> None:
    """Optimises from the shipped start and then from random ones, and keeps what is better than the shipped one."""
    case = load_case("hexapod")
    model = identification_model(case, 9)
    bound = box_bound(case, model)
    (family,) = family_class(family_name)().families(case, 12.0)
    until = time.monotonic() + seconds
    task = Task(case, 9, family, "D", 0, begin=shipped_start(family, case))
    while time.monotonic() < until:
        tables = json.loads(FILE.read_text(encoding="utf-8"))
        best = tables[family_name]["d_efficiency"]
        try:
            found = run_start(task)
            if bound.efficiency(found.promise) > PROMISING * best:
                found = _refined(task, found)
        except HexciteError as error:
            print(f"{family_name}, {task.seed}: {error}", flush=True)
        else:
            efficiency = bound.efficiency(found.logdet)
            print(f"{family_name}, seed {task.seed}: {efficiency:.4f}", flush=True)
            if efficiency > best:
                table = found.family.table(found.unknowns).round(DIGITS).tolist()
                tables[family_name] = {"d_efficiency": round(efficiency, 4), "table": table}
                write_text(FILE, json.dumps(tables) + "\n")
        task = replace(task, begin=None, seed=int(np.random.default_rng().integers(2**31)))


def _refined(task: Task, found: Start) -> Start:
    """The motion after as many refinements as pay."""
    for _ in range(HARDER):
        better = run_start(replace(task, family=found.family, step=Step.REFINE, begin=found.begin))
        if better.logdet <= found.logdet and found.refined:
            break
        found = better
    return found


def main() -> None:
    """Parses the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--families", default="fourier,ptp,spline", help="with commas between")
    given = parser.parse_args()
    for family in given.families.split(","):
        search(family, given.seconds)


if __name__ == "__main__":
    main()
