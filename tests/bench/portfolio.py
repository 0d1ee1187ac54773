"""The planner on hexapods that differ in kind.

`python tests/bench/portfolio.py --write FOLDER` writes their case files, one folder a machine.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is no installed package

from tests.bench.machines.description import Hexapod, write_machine
from tests.bench.machines.designed import DESIGNED


def machine(name: str) -> Hexapod:
    """The hexapod of a name."""
    return DESIGNED[name]


def main() -> None:
    """Writes the case files."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", type=Path, metavar="FOLDER")
    parser.add_argument("--machines", default=",".join(DESIGNED), help="names, with commas between")
    given = parser.parse_args()
    for name in given.machines.split(","):
        print(write_machine(given.write, name, machine(name)))


if __name__ == "__main__":
    main()
