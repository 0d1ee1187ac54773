"""Which plan a run followed: the plan's fingerprint goes into the program, and from there into the recording."""

import hashlib
import re
from pathlib import Path

from cases.files import read_json

DIGITS = 16
_IN_PROGRAM = re.compile(rb"plan hash ([0-9a-f]{%d})" % DIGITS)


def plan_hash(folder: Path) -> str:
    """Fingerprint of a plan: the first 16 digits of the SHA-256 of its plan.json, wherever the folder is."""
    return hashlib.sha256((folder / "plan.json").read_bytes()).hexdigest()[:DIGITS]


def plan_line(folder: Path) -> str:
    """What a program says of its plan."""
    return f"plan hash {plan_hash(folder)}"


def plan_of_program(content: bytes) -> str | None:
    """The fingerprint in a program; None where it names none, or several."""
    found = set(_IN_PROGRAM.findall(content))
    return found.pop().decode() if len(found) == 1 else None


def plan_of_recording(path: Path) -> str | None:
    """The fingerprint in a folder of `hexcite run`; None where nothing tells.

    Raises:
        FileProblem: recording.json is damaged.
    """
    file = path / "recording.json"
    if not (path.is_dir() and file.is_file()):
        return None
    found = read_json(file, "hexcite run").get("plan_hash")
    return None if found is None else str(found)
