"""What is half written or set aside, and what commands that were killed left of it."""

import glob
import os
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

ABANDONED = 5.0  # [s] after which what nobody has locked is a leftover: it is locked as soon as it is made
PART, TRY, OLD = ".hexcite.part", ".hexcite.try", ".hexcite.old"
"""How names of what is half written, tried, or set aside end; they begin with a dot and the name of the place."""
_LEFTOVER = re.compile(r"\.(?P<place>.+)\.[a-z0-9_]{8}(?P<kind>\.hexcite\.(part|try|old))", re.DOTALL)


@contextmanager
def in_use(part: Path) -> Iterator[None]:
    """Inside, other commands know that a file or folder under way is not a leftover; a killed process lets go of it."""
    handle = None
    with suppress(OSError):
        handle = os.open(part, os.O_RDONLY)
    try:
        if handle is not None:
            _locked(handle)
        yield
    finally:
        if handle is not None:
            os.close(handle)


def _locked(handle: int) -> bool:
    """Whether an open file or folder is locked by this call; False where another process has it, or none can."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (ImportError, OSError):
        return False
    return True


def clear_leftovers(path: Path) -> None:
    """Removes what commands that were killed left of a place, half written."""
    for suffix in (PART, TRY):
        for part in path.parent.glob(f".{glob.escape(path.name)}.*{suffix}"):
            _clear(part)


def _clear(part: Path) -> None:
    """Removes what is half written, where no process has it any more."""
    with suppress(OSError):
        if part.is_symlink():
            return
        with abandoned(part) as is_so:
            if is_so:
                shutil.rmtree(part, ignore_errors=True) if part.is_dir() else part.unlink()


@contextmanager
def abandoned(part: Path) -> Iterator[bool]:
    """Whether no process has a file or folder that is under way; inside, no other one takes it for a leftover.

    Raises:
        OSError: it cannot be looked at.
    """
    if time.time() - part.lstat().st_mtime < ABANDONED:
        yield False
        return
    handle = os.open(part, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))  # whatever stands there
    try:
        yield _locked(handle)
    finally:
        os.close(handle)


def tidy(folder: Path) -> list[Path]:
    """Clears a folder of what killed commands left in it; returns places whose earlier content stands there again.

    What is half written goes. What a command had set aside to replace it, and did not, comes back to its place.
    """
    back = []
    for part in sorted(folder.iterdir()):
        match = _LEFTOVER.fullmatch(part.name)
        if match is None:
            continue
        if match["kind"] != OLD:
            _clear(part)
            continue
        place = folder / match["place"]
        with suppress(OSError):
            if part.is_symlink() or not part.is_dir() or time.time() - part.lstat().st_mtime < ABANDONED:
                continue
            if not os.path.lexists(place):
                os.rename(part / place.name, place)
                back.append(place)
                part.rmdir()
            elif not any(part.iterdir()):
                part.rmdir()
    return back
