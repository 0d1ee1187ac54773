"""Looks for better starts to ship with hexcite, near those that it has, on the built-in hexapod by default settings.

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
from cases.schema import load_case
from cases.units import Array
from identification.criteria import box_middle
from identification.model import identification_model
from planner.bounds.information_limit import information_limit
from planner.families import Family
from planner.families.ptp import PointToPointFamily
from planner.families.settings import family_class
from planner.planning import SHIPPED
from planner.search.solving import Start, Task, run_start

DIGITS = 5
STEPS = (0.0, 0.03, 0.1, 0.2, 0.05)  # from the best, over the deviation of its unknowns: local optima lie near it
PROMISING = 0.97  # share of the best from which an exploration is refined
HARDER = 4  # refinements one after the other


def table_of(family: Family, unknowns: Array) -> Array:
    """Unknowns in units that do not depend on the machine, as `like` of their family reads them.

    Of moves: where they begin; then the way of each in longest steps, and its times in units of a mean move.
    """
    if not isinstance(family, PointToPointFamily):
        return unknowns.reshape(-1, len(box_middle(load_case("hexapod"))[0]))
    points, times = family.split(unknowns)
    rows = np.vstack([points[0], np.diff(points, axis=0) / family.longest_steps()[1]])
    return np.hstack([rows, np.vstack([np.zeros(3), times])])


def search(name: str, seconds: float) -> None:
    """Optimises from the shipped start and from others near it, and keeps what is better."""
    case = load_case("hexapod")
    case = case.without_jerk() if name.endswith("steps") else case
    model = identification_model(case, 9)
    bound = information_limit(case, model)
    (family,) = family_class(name.partition(",")[0])().families(case, 12.0)
    draw, until, k = np.random.default_rng(), time.monotonic() + seconds, 0
    while time.monotonic() < until:
        tables = json.loads(SHIPPED.read_text(encoding="utf-8"))
        best, near = tables[name]["d_efficiency"], family.like(np.array(tables[name]["table"]))
        assert near is not None
        begin = near + STEPS[k % len(STEPS)] * near.std() * draw.normal(size=near.shape)
        task = Task(case, 9, family, "D", k, begin=begin)
        try:
            found = run_start(task)
            if bound.efficiency(found.promise) > PROMISING * best:
                found = _refined(task, found)
        except HexciteError as error:
            print(f"{name}, {k}: {error}", flush=True)
        else:
            efficiency = bound.efficiency(found.record.logdet)
            print(f"{name}, {k}: {efficiency:.4f}", flush=True)
            if efficiency > best:
                table = table_of(found.family, found.unknowns).round(DIGITS).tolist()
                tables = json.loads(SHIPPED.read_text(encoding="utf-8"))
                tables[name] = {"d_efficiency": round(efficiency, 4), "table": table}
                write_text(SHIPPED, json.dumps(tables) + "\n")
        k += 1


def _refined(task: Task, found: Start) -> Start:
    """The motion after as many refinements as pay."""
    for _ in range(HARDER):
        better = run_start(replace(task, family=found.family, refine=True, begin=found.begin))
        if better.record.logdet <= found.record.logdet and found.record.refined:
            break
        found = better
    return found


def main() -> None:
    """Parses the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--families", default="fourier;ptp;ptp, steps;spline", help="with semicolons between")
    given = parser.parse_args()
    for family in given.families.split(";"):
        search(family, given.seconds)


if __name__ == "__main__":
    main()
