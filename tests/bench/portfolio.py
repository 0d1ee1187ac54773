"""The planner on hexapods that differ in kind: how good and how quick its default settings are on each.

    python tests/bench/portfolio.py                                        # the table, every machine and family
    python tests/bench/portfolio.py desktop tall drawn_7 --families ptp    # some of it; drawn_SEED is drawn
    python tests/bench/portfolio.py desktop --options "--starts 1"         # with more words for hexcite plan
    python tests/bench/portfolio.py --write FOLDER                         # the case files, one folder a machine
    python tests/bench/portfolio.py --search 600 desktop --families ptp    # looks for better plans, 600 s a family

`machines/best_known.json` holds the best that was ever found for each machine and family.
"""

import argparse
import json
import math
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.base.atomic import write_text
from cases.schema import load_case
from tests.bench.machines.description import Hexapod, reachable, write_machine
from tests.bench.machines.designed import DESIGNED
from tests.bench.machines.drawn import drawn
from tests.bench.tables import print_table

HEXCITE = Path(sys.executable).parent / "hexcite"
BEST_KNOWN = Path(__file__).parent / "machines" / "best_known.json"
FAMILIES = ("fourier", "ptp", "spline")
DRAWN = "drawn_"
PATIENCE = 300.0  # seconds for a search to end after Ctrl-C
POLL = 0.05  # [s]


@dataclass(frozen=True)
class Done:
    """A finished command.

    Args:
        seconds: wall time.
        megabytes: largest resident memory of its largest process.
        answer: its JSON; None where it failed.
        error: the last line that it said where it failed.
        processor: processor time of all its processes, where the computer is not idle the better figure.
    """

    seconds: float
    megabytes: float
    answer: dict[str, Any] | None
    error: str
    processor: float = 0.0

    @property
    def cost(self) -> list[str]:
        """Time and memory, for a table."""
        return [f"{self.seconds:.1f} s", f"{self.megabytes:.0f} MB"]


def machine(name: str) -> Hexapod:
    """The machine of a name: one of the twelve, or `drawn_SEED`."""
    if name.startswith(DRAWN) and name.removeprefix(DRAWN).isdecimal():
        return drawn(int(name.removeprefix(DRAWN)))
    if name not in DESIGNED:
        sys.exit(f"{name} is not a machine of the portfolio; choose {', '.join(DESIGNED)} or {DRAWN}SEED")
    return DESIGNED[name]


def command(words: Sequence[str], deadline: float = float("inf")) -> Done:
    """Runs `hexcite` with words, and presses Ctrl-C once `deadline` seconds have passed."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        began = time.perf_counter()
        process = subprocess.Popen([str(HEXCITE), *words, "--json"], stdout=out, stderr=err)
        pressed = False
        while not (ended := os.wait4(process.pid, os.WNOHANG))[0]:
            seconds = time.perf_counter() - began
            if seconds > deadline and not pressed:
                process.send_signal(signal.SIGINT)
                pressed = True
            if seconds > deadline + PATIENCE:
                process.kill()
            time.sleep(POLL)
        seconds = time.perf_counter() - began
        process.returncode = os.waitstatus_to_exitcode(ended[1])  # or Popen waits for it again
        out.seek(0)
        err.seek(0)
        answer = json.load(out) if process.returncode == 0 else None
        said = err.read().strip().splitlines() or [f"ended with {process.returncode}"]
    usage = ended[2]
    return Done(seconds, usage.ru_maxrss / 1024, answer, said[-1], usage.ru_utime + usage.ru_stime)


def read_best_known() -> dict[str, Any]:
    """Machine -> family -> d_efficiency, duration, hash of the case, and the command that found it."""
    return json.loads(BEST_KNOWN.read_text(encoding="utf-8")) if BEST_KNOWN.exists() else {}


def best_known(name: str, case_hash: str, family: str, duration: float) -> float | None:
    """The best efficiency known; None where there is none of the machine as it is now and of such a duration [s]."""
    entry = read_best_known().get(name, {}).get(family)
    if (
        entry is None
        or entry["case_hash"] != case_hash
        or not math.isclose(entry["duration_s"], duration, rel_tol=0.02)
    ):
        return None
    return float(entry["d_efficiency"])


def keep_if_better(name: str, answer: Mapping[str, Any], found_by: str) -> bool:
    """Enters what `hexcite plan` answered in the file where nothing better is known; returns whether it did."""
    family, efficiency = answer["family"], answer["d_efficiency"]
    before = best_known(name, answer["case_hash"], family, answer["duration_s"])
    if before is not None and efficiency <= before:
        return False
    known = read_best_known()
    entry = {key: answer[key] for key in ("d_efficiency", "duration_s", "case_hash")} | {"found_by": found_by}
    known[name] = known.get(name, {}) | {family: entry}
    write_text(BEST_KNOWN, json.dumps(known, indent=1, sort_keys=True) + "\n")
    return True


def portfolio(names: Sequence[str] = tuple(DESIGNED), families: Sequence[str] = FAMILIES, options: str = "") -> None:
    """Plans on each machine and prints what came out, and at what cost.

    Args:
        names: of machines.
        families: of motions.
        options: further words for `hexcite plan`.
    """
    rows, shares = [], []
    with tempfile.TemporaryDirectory() as temporary:
        for name in names:
            folder = write_machine(Path(temporary), name, machine(name))
            case = load_case(str(folder))
            reach = f"{100 * reachable(case).all_limits:.0f} %"
            rows.append([name, reach, "its bound alone", "", "", *command(("bound", str(folder))).cost, ""])
            for family in families:
                words = ("plan", str(folder), "--family", family, *shlex.split(options))
                done = command((*words, "-o", str(Path(temporary) / f"{name}-{family}")))
                if done.answer is None:
                    rows.append([name, reach, family, "failed", "", *done.cost, done.error])
                    continue
                efficiency = done.answer["d_efficiency"]
                best = best_known(name, case.hash, family, done.answer["duration_s"])
                keep_if_better(name, done.answer, shlex.join(words[2:]))
                if best is not None:
                    shares.append(efficiency / best)
                share = "-" if best is None else f"{efficiency / best:.3f}"
                binding = ", ".join(done.answer["bound_by"]) or "-"
                rows.append([name, reach, family, f"{efficiency:.3f}", share, *done.cost, binding])
                print(*rows[-1], sep=", ", file=sys.stderr, flush=True)
    columns = ("machine", "box reachable", "family", "efficiency", "of best known", "time", "memory", "what binds")
    print_table("Planning on machines that differ in kind", columns, rows)
    if shares:
        print(f"of the best known, {len(shares)} plans: median {np.median(shares):.3f}, least {min(shares):.3f}")


def search(seconds: float, names: Sequence[str], families: Sequence[str], options: str) -> None:
    """Plans with one seed after the other and keeps in `best_known.json` what is better.

    Args:
        seconds: of each machine and family; the last search is then ended as by Ctrl-C, which keeps its best.
        names: of machines.
        families: of motions.
        options: further words for `hexcite plan`, such as `--starts 64`.
    """
    for name in names:
        for family in families:
            with tempfile.TemporaryDirectory() as temporary:
                folder = write_machine(Path(temporary), name, machine(name))
                until = time.perf_counter() + seconds
                fresh = int(time.time())  # a search that is repeated goes on with other seeds
                while (rest := until - time.perf_counter()) > 0.0:
                    words = f"--family {family} --seed {fresh} {options}".strip()
                    output = ("-o", str(Path(temporary) / f"seed-{fresh}"))
                    done = command(("plan", str(folder), *shlex.split(words), *output), rest)
                    fresh += 1000  # farther than a search has starts
                    if done.answer is None:
                        print(f"{name}, {family}: {done.error}", flush=True)
                        break
                    better = keep_if_better(name, done.answer, f"{words}, {done.seconds:.0f} s")
                    word = ", the best known" if better else ""
                    print(f"{name}, {family}: {done.answer['d_efficiency']:.4f}{word}", flush=True)


def write(folder: Path, names: Sequence[str]) -> None:
    """Writes case files and prints how much of each motion box is reachable."""
    rows = []
    for name in names:
        hexapod = machine(name)
        case = load_case(str(write_machine(folder, name, hexapod)))
        rows.append([name, *(f"{100 * share:.0f} %" for share in reachable(case)), hexapod.title])
    columns = ("machine", "within strut lengths", "within all limits", "what it is")
    print_table("Machines, and the share of poses of their boxes that they reach", columns, rows)


def main() -> None:
    """Parses the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="machine", help="all twelve by default")
    parser.add_argument("--machines", default=",".join(DESIGNED), help="the same, with commas between")
    parser.add_argument("--families", default=",".join(FAMILIES), help="with commas between")
    parser.add_argument("--options", default="", help="more words for hexcite plan")
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="write case files, plan nothing")
    parser.add_argument("--search", type=float, metavar="SECONDS", help="of each machine and family")
    given = parser.parse_args()
    names, families = given.names or given.machines.split(","), given.families.split(",")
    for name in names:
        machine(name)  # a misspelt one is refused before the work begins
    if given.write is not None:
        write(given.write, names)
    elif given.search is not None:
        search(given.search, names, families, given.options)
    else:
        portfolio(names, families, given.options)


if __name__ == "__main__":
    main()
