"""Arms that are driven by written programs, each seed on another day: errors, deviations and intervals by recorder.

A program is planned and written once an arm. Each seed has other drives, other friction and another recorder's noise,
losses and stamps; bag, table and RTDE file are of one motion. Errors are multiples of the reported deviation.

Usage: python tests/bench/driven.py FOLDER [arm ..] [--seeds 0 20]; what FOLDER has from earlier calls is not run again
"""

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from shutil import rmtree
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from hexcite.cli.console import print_table
from tests.driven.arms import ARMS
from tests.driven.runs import Driven, driven_by, written


def arm_in(folder: Path, name: str) -> Driven:
    """The arm with its program, which is written where the folder has none."""
    place = folder / name
    program = place / "program.txt"
    if not program.is_file():
        place.mkdir(parents=True, exist_ok=True)
        began = process_time()
        program.write_text(written(name, place))
        print(f"{name}: planned and written in {process_time() - began:.0f} s of the processor")
    return driven_by(program.read_text(), name, place)


def entries(arm: Driven, seed: int) -> Iterator[dict[str, object]]:
    """What is identified from each recorder's file of a seed."""
    began = process_time()
    day = arm.again(seed)
    drove = process_time() - began
    for kind in day.kinds:
        began = process_time()
        result = day.identified(kind, seed)
        assert result.estimate is not None
        freedom = result.estimate.fit.freedom
        parameters = {}
        for name, true in day.truth.items():
            found = result[name]
            low, high = found.interval(freedom)
            parameters[name] = {
                "error": found.value - true, "reported": found.reported, "std": found.std,
                "inside": bool(low <= true <= high),
            }  # fmt: skip
        yield {
            "kind": kind, "seed": seed, "parameters": parameters, "warnings": list(result.warnings),
            "drove_s": drove, "identified_s": process_time() - began,
        }  # fmt: skip
        recording = arm.folder / f"{kind}_{seed}"
        rmtree(recording) if recording.is_dir() else next(arm.folder.glob(f"{recording.name}.*")).unlink()


def row(name: str, kind: str, found: list[dict[str, dict[str, float]]]) -> list[str]:
    """A row of the table."""
    errors = np.array([[p["error"] / p["reported"] for p in each.values()] for each in found])
    inside = np.array([[p["inside"] for p in each.values()] for each in found])
    worst = np.unravel_index(np.argmax(np.abs(errors)), errors.shape)
    return [
        name, kind, str(len(found)), f"{np.sqrt(np.mean(errors**2)):.2f}", f"{np.abs(errors).max():.2f}",
        list(found[0])[worst[1]], f"{100 * inside.mean():.1f} %",
    ]  # fmt: skip


def main() -> None:
    """Parses the command line, runs what is not there, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", metavar="arm", help=f"all by default: {', '.join(ARMS)}")
    parser.add_argument("--seeds", nargs=2, type=int, default=(0, 20), metavar=("FIRST", "END"))
    given = parser.parse_args()
    rows = []
    for name in given.names or ARMS:
        kept = given.folder / f"{name}.jsonl"
        there = [json.loads(line) for line in kept.read_text().splitlines()] if kept.is_file() else []
        if seeds := sorted({*range(*given.seeds)} - {entry["seed"] for entry in there}):
            arm = arm_in(given.folder, name)
            for seed in seeds:
                made = list(entries(arm, seed))
                with kept.open("a") as file:
                    file.writelines(json.dumps(entry) + "\n" for entry in made)
                there += made
        for kind in dict.fromkeys(entry["kind"] for entry in there):
            rows.append(row(name, kind, [entry["parameters"] for entry in there if entry["kind"] == kind]))
        cost = [entry["identified_s"] for entry in there]
        print(f"{name}: driven in {there[0]['drove_s']:.1f} s, identified in {np.median(cost):.1f} s (median)")
    columns = ("arm", "recorder", "seeds", "rms", "worst", "of", "inside 95 %")
    print_table("Errors of 16 parameters over their reported deviations", columns, rows)


if __name__ == "__main__":
    main()
