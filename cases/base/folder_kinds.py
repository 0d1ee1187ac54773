"""Kinds of folders that hexcite writes, and whether a folder that stands somewhere is one of them."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from cases.base.errors import WITH_OUTPUT, Code, FileProblem
from cases.base.file_reading import DAMAGED, MOST_JSON, read_whole, system_reason


class FolderKind(NamedTuple):
    """A kind of folder that hexcite writes."""

    name: str  # what it is, for messages
    contents: frozenset[str]  # names of everything that it may hold
    record: str = ""  # the file that says what it is; folders of 0.2 are known by it, later ones by their marker
    beside: frozenset[str] = frozenset()  # what others may make of it there, and may be replaced too


MARKER = ".hexcite"
"""The file in a folder of ours that lists all its files: what is not listed is not ours."""
_RECORDED = frozenset({"case", "case_hash", "rows", "schema_version", "source"})  # keys of our records, one at least
_DRAWN = frozenset({".parquet", ".csv", ".json", ".html", ".svg", ".png", ".ngc", ".mpf", ".nc", ".script", ".yaml"})
_DEEPEST = 3  # folders of 0.2 inside each other
PLAN = FolderKind("a plan", frozenset({"plan.json", "motion.csv", "poses.csv", "plots", "report.html"}), "plan.json")
RUN = FolderKind("a run", frozenset({"recording.json", "recording.csv"}), "recording.json")
RESULT = FolderKind(
    "a result", frozenset({"result.json", "identifiability.json", "plots", "report.html", "runs"}), "result.json"
)
COMPARISON = FolderKind("a comparison", frozenset({"comparison.json", "report.html", "plots"}), "comparison.json")
VALIDATION = FolderKind(
    "a validation", frozenset({"validation.json", "report.html", "plots", "plans", "programs"}), "validation.json"
)
DEMO = FolderKind(
    "a demo",
    frozenset({"plan", "recording", "result", "report.html", "manual", "fourier"})
    | {f"excitation{suffix}" for suffix in (".ngc", ".mpf", ".nc", ".csv", ".script", ".yaml")},
    "plan/plan.json",
)
LOOKS = 100  # at a folder that other commands are replacing


def looked_at(path: Path, kind: FolderKind) -> tuple[set[str], str]:
    """Names in a folder, and what is not ours in it, both of one folder: another command may be replacing it."""
    for _ in range(LOOKS):
        before = _identity(path)
        try:
            entries = {entry.name for entry in path.iterdir()}
        except (NotADirectoryError, FileNotFoundError) as error:
            # where a file stands above it, this is reported later
            if isinstance(error, NotADirectoryError) and os.path.lexists(path):
                raise FileProblem(
                    place=path,
                    problem="exists and is not a folder",
                    remedy=f"choose another place{WITH_OUTPUT}",
                    code=Code.NOT_WRITABLE,
                ) from error
            return set(), ""
        except OSError as error:
            raise FileProblem(
                place=path,
                problem=f"cannot be read ({system_reason(error)})",
                remedy=f"choose another place{WITH_OUTPUT}",
                code=Code.NOT_WRITABLE,
            ) from error
        other = _foreign(path, entries, kind) if entries else ""
        if _identity(path) == before:
            break
    return entries, other


def _identity(path: Path) -> int | None:
    """Number of a folder on its disk; None where there is none."""
    try:
        return path.stat().st_ino
    except (OSError, ValueError):
        return None


def _foreign(path: Path, entries: set[str], kind: FolderKind) -> str:
    """What says that a folder is not one of a kind that hexcite wrote; empty where it is."""
    marked = _marked(path)
    if marked is None or marked[0] != kind.name:
        if others := sorted(entries - kind.contents - {MARKER}):
            return f"it holds {others[0]}"
        if marked is not None:
            return f"it is {marked[0]}"
        if kind.record and not _is_record(path / kind.record):
            return f"it has no {kind.record} of hexcite's"
    for name in files_below(path):
        of_the_kind = len(name.parts) <= _DEEPEST and (len(name.parts) == 1 or name.suffix in _DRAWN)
        listed = of_the_kind if marked is None else name.as_posix() in marked[1]
        if not listed and name.name != MARKER and name.as_posix() not in kind.beside:
            return f"it holds {name}"
    return ""


def _marked(path: Path) -> tuple[str, frozenset[str]] | None:
    """Kind and files of a folder by its marker; None where it has none that says them."""
    try:
        content = json.loads(read_whole(path / MARKER, MOST_JSON))
        return str(content["kind"]), frozenset(map(str, content["files"]))
    except (FileProblem, *DAMAGED, RecursionError):
        return None


def _is_record(file: Path) -> bool:
    """Whether a file is one of ours by which folders without a marker are known."""
    try:
        content = read_whole(file, MOST_JSON)
        return b"hexcite" in content if file.suffix == ".h" else not _RECORDED.isdisjoint(json.loads(content))
    except (FileProblem, *DAMAGED, RecursionError):
        return False


def files_below(folder: Path) -> Iterator[Path]:
    """Everything in a folder but folders with something in them, relative to it."""
    for place, folders, files in os.walk(folder):
        below = Path(place).relative_to(folder)
        links = [name for name in folders if os.path.islink(os.path.join(place, name))]
        yield from (below / name for name in (*files, *links))
        if not folders and not files and below.parts:
            yield below
