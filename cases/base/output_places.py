"""Where a command writes, refused before the work starts if that place is taken or cannot be written."""

import os
import shutil
import tempfile
from collections.abc import Iterable
from itertools import chain, count
from pathlib import Path
from typing import NoReturn

from cases.base.errors import WITH_OUTPUT, Code, FileProblem, option
from cases.base.file_reading import system_reason
from cases.base.folder_kinds import LOOKS, FolderKind, looked_at
from cases.base.leftovers import TRY
from cases.base.phrases import phrase


def free_name(path: Path, separator: str = "-") -> Path:
    """`path` where nothing stands there, else the first of path-2, path-3, .. that is free."""
    names = (path.with_name(f"{path.stem}{separator}{k}{path.suffix}") for k in count(2))
    return next(p for p in chain([path], names) if not os.path.lexists(p))


def output_place(named: Path | None, usual: Path, overwrite: bool, separator: str = "-") -> Path:
    """Where a command writes: the place that was named with -o, else the usual one, or a free name beside it."""
    if named is not None:
        return named
    return usual if overwrite else free_name(usual, separator)


def _refuse_to_replace(path: Path, content: str) -> NoReturn:
    raise FileProblem(
        place=path,
        problem=phrase("stands_there", "{what} stands there", what=content),
        remedy=phrase(
            "place_or_overwrite",
            "choose another place{output}, or replace it with {overwrite}",
            output=WITH_OUTPUT,
            overwrite=option("overwrite"),
        ),
        code=Code.EXISTS,
    )


def check_file(path: Path, suffixes: Iterable[str], inputs: Iterable[Path] = (), overwrite: bool = False) -> None:
    """Raises FileProblem, before the work starts, for an output file that could not be written, or has a wrong ending.

    Args:
        suffixes: endings that it may have, in lower case; upper case in `path` is as good.
        inputs: what the work reads, which is never overwritten.
        overwrite: whether a file that stands there may be replaced.
    """
    endings = tuple(suffixes)
    if path.suffix.lower() not in endings:
        ending = repr(path.suffix) if path.suffix else "no suffix"
        raise FileProblem(
            place=path,
            problem=f"ends in {ending}",
            remedy=f"name a file that ends in {' or '.join(endings)}",
            code=Code.WRONG_KIND,
        )
    require_place(path)
    if path.is_dir():
        raise FileProblem(
            place=path, problem="is a folder", remedy=f"name a file in it{WITH_OUTPUT}", code=Code.WRONG_KIND
        )
    for source in inputs:
        if path.exists() and source.exists() and path.samefile(source):
            raise FileProblem(
                place=path,
                problem="is also what is read",
                remedy=f"choose another place{WITH_OUTPUT}",
                code=Code.NOT_WRITABLE,
            )
    if path.exists() and not overwrite:
        _refuse_to_replace(path, "a file")


def check_folder(path: Path, kind: FolderKind, inputs: Iterable[Path] = (), overwrite: bool = False) -> None:
    """Raises FileProblem, before the work starts, for an output folder that could not be written.

    A folder that stands there is replaced only if it is empty, or of the same kind, with nothing else in it, and
    `overwrite` is set, so that no slip of `-o` wipes what is not ours, or another result of ours. None of `inputs`,
    which the work reads, may be in it.
    """
    if path.resolve() == Path.cwd() or path.resolve() in Path.cwd().parents:
        raise FileProblem(
            place=path,
            problem="is the folder that you work in",
            remedy=f"name a new one{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    for source in inputs:
        if path.resolve() in (source.resolve(), *source.resolve().parents):
            raise FileProblem(
                place=path,
                problem=f"holds {source}, which is read",
                remedy=f"choose another place{WITH_OUTPUT}",
                code=Code.NOT_WRITABLE,
            )
    if os.path.islink(path):
        raise FileProblem(
            place=path,
            problem="exists and is not a folder but a link",
            remedy=f"name the folder itself{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    entries, other = looked_at(path, kind)
    if other:
        raise FileProblem(
            place=path,
            problem=f"is not {kind.name} of hexcite's ({other})",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    if entries and not overwrite:
        _refuse_to_replace(path, kind.name)
    if entries and not _may_be_written(path):
        raise FileProblem(
            place=path,
            problem="cannot be replaced (Permission denied)",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        )
    require_place(path)


def _may_be_written(path: Path) -> bool:
    """Whether what stands at a place may be replaced; where nothing does, another command has just set it aside."""
    return any(os.access(path, os.W_OK) or not os.path.lexists(path) for _ in range(LOOKS))


LEAST_SPACE = 2**23  # bytes that results, with their pages, take at most


def require_place(path: Path) -> None:
    """Tries to write beside `path`, since permission bits do not say all that a file system allows."""
    above = next(p for p in path.absolute().parents if os.path.lexists(p))
    try:
        os.rmdir(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=TRY, dir=above))
    except OSError as error:
        reason = system_reason(error) if above.is_dir() else f"{above} is not a folder"
        raise FileProblem(
            place=path,
            problem=f"cannot be written ({reason})",
            remedy=f"choose another place{WITH_OUTPUT}",
            code=Code.NOT_WRITABLE,
        ) from error
    if (free := shutil.disk_usage(above).free) < LEAST_SPACE:
        raise FileProblem(
            place=path,
            problem=phrase("disk_full", "cannot be written ({left} MB are left there)", left=f"{free / 2**20:.1f}"),
            remedy=phrase("make_room", "make room there"),
            code=Code.NOT_WRITABLE,
        )
