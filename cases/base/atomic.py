"""Files and folders that are either whole or absent, also when the process is killed while it writes."""

import errno
import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cases.base.errors import WITH_OUTPUT, Code, FileProblem
from cases.base.file_reading import system_reason
from cases.base.folder_kinds import MARKER, FolderKind, files_below
from cases.base.leftovers import OLD, PART, clear_leftovers, in_use
from cases.base.output_places import check_folder, free_name
from cases.base.phrases import phrase
from cases.base.text_formats import json_text


def _flush(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Raises FileProblem where the system refuses to write to a place."""
    try:
        yield
    except FileProblem:  # of something else that the block read or wrote
        raise
    except OSError as error:
        raise FileProblem(
            place=path,
            problem=phrase("not_writable", "cannot be written ({reason})", reason=system_reason(error)),
            remedy=phrase("another_place", "choose another place{output}", output=WITH_OUTPUT),
            code=Code.NOT_WRITABLE,
        ) from error


def umask() -> int:
    """The permissions that new files of this process lack."""
    current = os.umask(0)
    os.umask(current)
    return current


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yields a path to write to; it appears as `path` when the block ends without an error. Raises FileProblem."""
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        clear_leftovers(path)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=PART, dir=path.parent)
        os.close(handle)
        part = Path(name)
        try:
            with in_use(part):
                yield part
                part.chmod(0o666 & ~umask())
                _flush(part)
                os.replace(part, path)
            WRITTEN.info("%s", path)
        finally:
            part.unlink(missing_ok=True)


WRITTEN = logging.getLogger("hexcite.written")
"""Where each file and folder is logged as it appears."""


@contextmanager
def atomic_folder(path: Path, kind: FolderKind, overwrite: bool = False) -> Iterator[Path]:
    """Yields an empty folder to fill; it takes the place of `path` only when the block ends without an error.

    With `overwrite`, a folder of the same kind is replaced as a whole. Without, what another command has written there
    in the meantime stays, and the new folder appears under a free name beside it: FileProblem names that, or why the
    place cannot be written.
    """
    check_folder(path, kind, overwrite=True)
    with _writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        clear_leftovers(path)
        part = Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=PART, dir=path.parent))
        try:
            with in_use(part):
                yield part
                listed = {"kind": kind.name, "files": sorted(name.as_posix() for name in files_below(part))}
                (part / MARKER).write_text(json_text(listed), encoding="utf-8")
                part.chmod(0o777 & ~umask())
                for file in part.rglob("*"):
                    _flush(file)
                place = _put(part, path, overwrite)
            WRITTEN.info("%s", place)
            if place != path:
                raise FileProblem(
                    place=path,
                    problem=f"{kind.name} stands there by now and stays",
                    remedy=f"the new one is in {place}",
                    code=Code.EXISTS,
                )
        finally:
            shutil.rmtree(part, ignore_errors=True)


def _put(part: Path, path: Path, overwrite: bool) -> Path:
    """Renames a folder to `path`, or to a free name where another stands there and stays; returns where it is.

    Other commands may write the same folder at the same time: whoever comes first or last, each finds a place.
    """
    place, aside = path, list[Path]()
    try:
        while True:
            try:
                os.rename(part, place)
                return place
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                    raise
            with suppress(FileNotFoundError):  # another command has just set it aside
                if overwrite or not any(path.iterdir()):
                    aside.append(Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=OLD, dir=path.parent)))
                    os.rename(path, aside[-1] / path.name)
                else:
                    place = free_name(path)
    except OSError:
        if aside and not path.exists():
            os.rename(aside[-1] / path.name, path)
        raise
    finally:
        for old in aside:
            shutil.rmtree(old, ignore_errors=True)


def write_text(path: Path, text: str) -> None:
    """Writes `text` to `path` as a whole or not at all."""
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")
