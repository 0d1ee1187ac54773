"""Files and folders that are either whole or absent, also when the process is killed while it writes."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cases.errors import FileProblem


def _flush(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _reason(error: OSError) -> str:
    return error.strerror or str(error)


def _mask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yields a path to write to; what was written appears under `path` only when the block ends without an error.

    Raises:
        FileProblem: the place cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    except OSError as error:
        raise FileProblem(f"{path}: cannot be written ({_reason(error)}); choose another place with -o") from error
    os.close(handle)
    part = Path(name)
    try:
        yield part
        part.chmod(0o666 & ~_mask())
        _flush(part)
        os.replace(part, path)
    except FileProblem:  # of something else that the block read or wrote
        raise
    except OSError as error:
        raise FileProblem(f"{path}: cannot be written ({_reason(error)}); choose another place with -o") from error
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yields an empty folder to fill; it takes the place of `path` only when the block ends without an error.

    A folder that stood there before is replaced as a whole. Only folders that hold nothing or a `*.json` of ours are
    replaced, so that a slip of `-o` cannot wipe a folder of somebody else's.

    Raises:
        FileProblem: the place cannot be written, or holds something that is not ours.
    """
    try:
        if path.exists() and not _is_ours(path):
            raise FileProblem(f"{path}: exists and is not a folder written by hexcite; choose another place with -o")
        path.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent))
    except OSError as error:
        if isinstance(error, FileProblem):
            raise
        raise FileProblem(f"{path}: cannot be written ({_reason(error)}); choose another place with -o") from error
    try:
        yield part
        part.chmod(0o777 & ~_mask())
        for file in part.rglob("*"):
            _flush(file)
        if path.exists():
            old = Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=".old", dir=path.parent))
            os.rename(path, old / path.name)
            try:
                os.rename(part, path)
            except OSError:
                os.rename(old / path.name, path)
                raise
            finally:
                shutil.rmtree(old)
        else:
            os.rename(part, path)
    except FileProblem:
        raise
    except OSError as error:
        raise FileProblem(f"{path}: cannot be written ({_reason(error)}); choose another place with -o") from error
    finally:
        shutil.rmtree(part, ignore_errors=True)


# What each kind of folder of ours holds: one with anything else in it is somebody's and is not replaced.
_CONTENTS = (
    {"plan.json", "motion.csv", "plots"},
    {"recording.json", "recording.csv"},
    {"result.json", "identifiability.json", "plots"},
)


def _is_ours(path: Path) -> bool:
    if not path.is_dir():
        return False
    entries = list(path.iterdir())
    return not entries or any({e.name for e in entries} <= content for content in _CONTENTS)


def write_text(path: Path, text: str) -> None:
    """Writes `text` to `path` as a whole or not at all."""
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")


def json_text(value: Any) -> str:
    """JSON with two-space indent; NaN and infinity are refused, since they are not JSON."""
    return json.dumps(value, indent=2, allow_nan=False) + "\n"


def read_json(path: Path, made_by: str) -> dict[str, Any]:
    """Reads a JSON object.

    Args:
        path: the file.
        made_by: the command that writes such files, for the message.

    Raises:
        FileProblem: it is missing, unreadable or not a JSON object.
    """
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileProblem(f"{path}: cannot be read ({_reason(error)}); {made_by} writes it") from error
    except ValueError as error:
        raise FileProblem(f"{path}: is not JSON ({error}); write it again with {made_by}") from error
    if not isinstance(value, dict):
        raise FileProblem(f"{path}: holds no JSON object; write it again with {made_by}")
    return value
