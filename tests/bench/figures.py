"""Measures the figures that users care about, from real runs, and prints them side by side. Run by `make bench`.

`--save FILE` keeps the tables, `--compare FILE` says what differs from those that were kept.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.schema import load_case
from hexcite._run import execute
from identification.identify import estimate_parameters
from identification.recording.recording import read, write_recording
from identification.simulate import simulate_recording
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing
from postprocessors.program import read_program
from tests.bench.coverage import coverage, idealised
from tests.bench.criteria import criteria_table
from tests.bench.crossed import COLUMNS, crossed
from tests.bench.damaged import damaged_rows
from tests.bench.exported import exported
from tests.bench.families import families, limits_of_information
from tests.bench.identified import identification_figures
from tests.bench.leaps import leaps
from tests.bench.monte_carlo import monte_carlo_table
from tests.bench.portfolio import portfolio
from tests.bench.pose_errors import pose_error_rows
from tests.bench.poses import pose_figures, pose_tables
from tests.bench.programs import programs
from tests.bench.robot import robot_figures
from tests.bench.searches import FAMILIES, searches
from tests.bench.silent import silent_rows
from tests.bench.single_moves import single_moves_rows
from tests.bench.size import sizes
from tests.bench.study import study_rows
from tests.bench.tables import Change, changes, load, print_table, printed, save
from tests.bench.under_load import under_load_rows
from tests.bench.validation import validation_rows
from tests.bench.wall_times import wall_time_rows

HEXCITE = Path(sys.executable).parent / "hexcite"
SEEDS = 100
SEARCHED = ("hexapod", "ur10_wrist", "five_axis_table", "panda", "small")  # machines of the table of searches


def command(*words: str) -> tuple[float, str]:
    """Wall time of a whole command [s], and what it printed."""
    began = time.perf_counter()
    done = subprocess.run([str(HEXCITE), *words], capture_output=True, text=True, check=True)
    return time.perf_counter() - began, done.stdout


def demos(folder: Path) -> list[list[str]]:
    """The demo on each controller."""
    rows = []
    controllers = ["virtual"] + ([] if linuxcnc_missing() else ["linuxcnc"])
    for controller in controllers:
        seconds, printed = command("demo", "--on", controller, "-o", str(folder / controller), "--json")
        answer = json.loads(printed)
        run, plan = answer["run"], answer["plan"]
        rows += [
            [f"hexcite demo on {controller}", f"{seconds:.1f} s", "25 s"],
            ["  worst error in reported standard deviations", f"{answer['worst_error_in_std']:.2f}", "4"],
            [f"  {plan['settings']['moves']} moves, solving", f"{plan['solve_s']:.1f} s", ""],
            ["  D-efficiency planned / executed", f"{plan['d_efficiency']:.3f} / {run['d_efficiency']:.3f}", ""],
            ["  duration executed / planned", f"{run['duration_s'] / run['planned_s']:.4f}", ""],
            ["  distance from the planned path", f"{run['path_error_mm']:.3f} mm", ""],
        ]
    return rows


def identification(folder: Path) -> list[list[str]]:
    """Identification of 20 000 samples, and coverage of the intervals."""
    case = load_case("hexapod")
    run, _ = execute(read_program(folder / "virtual" / "excitation.ngc", case), case, "virtual", 0)
    recording = simulate_recording(case, run.execution, run.trigger, 0)
    repeats = 20_000 // len(recording.forces) + 1
    assert recording.t is not None
    assert recording.drives is not None
    # The run begins and ends standing at home: repeated, it is a longer run of the same machine.
    count = 20_000
    long_run = type(recording)(
        "long", np.arange(count) * 1e-3, np.tile(recording.drives, (repeats, 1))[:count], None,
        np.tile(recording.forces, (repeats, 1))[:count], np.ones(count, dtype=bool),
    )  # fmt: skip
    file = folder / "long.csv"
    write_recording(file, long_run, case)
    times = []
    for _ in range(3):
        began = time.perf_counter()
        estimate_parameters(read(file, case), case, 9)
        times.append(time.perf_counter() - began)
    rows = [["identification of 20 000 samples x 6 forces, CSV to result", f"{min(times):.2f} s", "1.5 s"]]
    ideal = coverage(idealised(case), run.execution, run.trigger, SEEDS)
    default = coverage(case, run.execution, run.trigger, SEEDS)
    rows += [
        [f"coverage, white noise and ideal encoders, {SEEDS} seeds: std (28)", f"{ideal.white:.1f} %", "92 to 98 %"],
        ["  the same: the interval that is printed", f"{ideal.reported:.1f} %", ""],
        ["coverage, default imperfections: std (28)", f"{default.white:.1f} %", "as it is"],
        ["  the same: the interval that is printed", f"{default.reported:.1f} %", ""],
        ["  the same: worst error in reported deviations", f"{default.worst:.2f}", ""],
    ]
    return rows


def sections() -> Iterator[tuple[str, list[list[str]]]]:
    """Title and rows of each group of figures, as they are measured."""
    starts = [command("--help")[0] for _ in range(7)]
    with tempfile.TemporaryDirectory() as name:
        yield "The chain", [["hexcite --help, median of 7", f"{np.median(starts):.2f} s", "0.4 s"], *demos(Path(name))]
        yield "Wall times of identification", wall_time_rows(Path(name), command)
        yield "Identification of 20 000 samples, and coverage", identification(Path(name))
    with tempfile.TemporaryDirectory() as name:
        yield "Programs", programs(Path(name), command)
    with tempfile.TemporaryDirectory() as name:
        yield "Identification", [*identification_figures(Path(name)), *leaps(), *damaged_rows()]
    yield "Exported models", exported()
    with tempfile.TemporaryDirectory() as name:
        yield "Validation", validation_rows(Path(name), command)
    with tempfile.TemporaryDirectory() as name:
        yield "Errors of the pose", pose_error_rows(Path(name), command)
    yield "Studies", study_rows()
    yield "Poses", pose_figures()
    yield "Reliability", [] if linuxcnc_missing() else under_load_rows()
    yield "Wrong numbers without a word", silent_rows()
    yield "Limits of information", [*limits_of_information(), *single_moves_rows()]


def measure() -> Iterator[None]:
    """Prints all figures, each table as soon as it is measured, and stops after each table or two."""
    sizes()
    print_table("Files that a command runs through", COLUMNS, crossed())
    yield
    with tempfile.TemporaryDirectory() as name:
        families(Path(name), command)
    yield
    portfolio()
    yield
    searches(SEARCHED, FAMILIES, (0, 1, 2), None, ())
    yield
    for title, rows in sections():
        print_table(title, ("figure", "measured", "wanted"), rows)
        yield
    for tables in (criteria_table, monte_carlo_table, pose_tables, robot_figures):
        tables()
        yield


def main() -> None:
    """Prints all figures, saves them and compares them with saved ones, as the options say."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--save", type=Path, metavar="FILE", help="keep all tables in a file (JSON)")
    options.add_argument("--compare", type=Path, metavar="FILE", help="say what differs from those that were kept")
    given = options.parse_args()
    before = None if given.compare is None else load(given.compare)  # a file that cannot be read ends it at once
    for _ in measure():
        if given.save is not None:  # after each table: a bench that is stopped keeps what it has
            save(given.save)
    if before is not None:
        print_table(f"Differences from {given.compare}", Change._fields, changes(before, printed))


if __name__ == "__main__":
    main()
