"""Files that are read whole, up to a size, and JSON objects in them."""

import json
import os
import stat
from pathlib import Path
from typing import Any

from cases.base.errors import Code, FileProblem


def system_reason(error: OSError) -> str:
    """What the system says of an error, without its number."""
    return error.strerror or str(error)


MOST_JSON = 16 * 2**20
"""Bytes of a JSON file that is read, within about a second; those of plans and results are far smaller."""
MOST_TABLE = 64 * 2**20
"""Bytes of another file of a plan or result that is read whole."""


def read_whole(path: Path, most: int) -> bytes:
    """All that a file of at most `most` bytes holds.

    Raises:
        FileProblem: there is no such file, it is larger, or it is a pipe or device, which may never end.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            kind = "a folder" if path.is_dir() else "a pipe or device"
            raise FileProblem(
                place=path,
                problem=f"cannot be read (is {kind}, not a file)",
                remedy="name a file",
                code=Code.UNREADABLE,
            )
        with open(path, "rb", opener=_at_once) as stream:
            content: bytes | None = stream.read(most + 1)
        if content is None:
            raise FileProblem(
                place=path,
                problem="cannot be read (it holds nothing that is there at once)",
                remedy="name a file",
                code=Code.UNREADABLE,
            )
    except FileProblem:
        raise
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        reason = system_reason(error) if isinstance(error, OSError) else str(error)
        raise FileProblem(
            place=path, problem=f"cannot be read ({reason})", remedy="name a readable file", code=Code.UNREADABLE
        ) from error
    if len(content) > most:
        raise FileProblem(
            place=path, problem=f"is larger than {most / 2**20:g} MB", remedy="name another file", code=Code.UNREADABLE
        )
    return content


def _at_once(name: str, flags: int) -> int:
    """Opens a file of which a read answers at once, also where the system only calls it a file (/proc/kmsg)."""
    return os.open(name, flags | getattr(os, "O_NONBLOCK", 0))


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a number of JSON")


def read_json(path: Path, made_by: str) -> dict[str, Any]:
    """Reads a JSON object; raises FileProblem, which names the command that writes such files, where there is none."""
    try:
        value = json.loads(read_whole(path, MOST_JSON).decode("utf-8"), parse_constant=_refuse)
    except FileProblem as error:
        raise FileProblem(
            place=path, problem=error.problem, remedy=f"{made_by} writes it", code=Code.UNREADABLE
        ) from error
    except ValueError as error:
        again = f"write it again with {made_by}" if path.suffix == ".json" else f"name what {made_by} wrote"
        raise FileProblem(place=path, problem=f"is not JSON ({error})", remedy=again, code=Code.DAMAGED) from error
    except RecursionError as error:
        raise FileProblem(
            place=path, problem="is nested too deeply", remedy=f"write it again with {made_by}", code=Code.DAMAGED
        ) from error
    if not isinstance(value, dict):
        raise FileProblem(
            place=path, problem="holds no JSON object", remedy=f"write it again with {made_by}", code=Code.DAMAGED
        )
    return value


DAMAGED = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError)
"""What a JSON object raises where it is taken apart and is not of the shape that the command gave it."""
