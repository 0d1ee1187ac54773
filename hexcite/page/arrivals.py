"""Files on their way from the browser: each comes whole or not at all, those of one run in a folder of their own."""

import os
import re
import shutil
import tempfile
from collections.abc import AsyncIterator, Collection
from contextlib import ExitStack, suppress
from itertools import takewhile
from pathlib import Path

from starlette.concurrency import run_in_threadpool

from cases.base.atomic import umask
from cases.base.leftovers import PART, abandoned, in_use
from hexcite.page.security import Outside
from hexcite.page.stages import BAG_INDEX, free

RUN = ".run-"
"""How names of folders begin whose files are on their way."""
_RUN = re.compile(re.escape(RUN) + r"[a-z0-9_]{8}")
MARK = ".on-its-way"
"""The file in such a folder by which it is known as ours; the server that takes its files has it locked."""


class TooLarge(ValueError):
    """A file is larger than it may be."""


async def received(root: Path, folder: Path, name: str, chunks: AsyncIterator[bytes], most: int) -> Path | None:
    """The file that has come, under a name that nothing has yet; None where there is no such name.

    Raises:
        TooLarge: it has more than `most` bytes; nothing of it stays.
    """
    handle, part = tempfile.mkstemp(prefix=".upload.", suffix=PART, dir=root)
    size = 0
    with ExitStack() as ends:
        ends.callback(os.unlink, part)
        ends.enter_context(in_use(Path(part)))
        with os.fdopen(handle, "wb") as stream:
            async for chunk in chunks:
                size += len(chunk)
                if size > most:
                    raise TooLarge(name)
                await run_in_threadpool(stream.write, chunk)
        for k in range(1, 1000):
            target = folder / (name if k == 1 else f"{Path(name).stem}-{k}{Path(name).suffix}")
            with suppress(FileExistsError):
                os.link(part, target)  # never onto another file
                return target
    return None


class Runs:
    """Folders that files of one run come into: hidden until all of them are there."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._held: dict[str, ExitStack] = {}

    def begin(self) -> str:
        """Makes a folder; returns its name until it is whole."""
        folder = Path(tempfile.mkdtemp(prefix=RUN, dir=self.root))
        (folder / MARK).touch()
        held = self._held[folder.name] = ExitStack()
        held.enter_context(in_use(folder / MARK))
        return folder.name

    def folder(self, name: str) -> Path:
        """The folder of a run that is on its way; raises Outside for any other name."""
        folder = self.root / name
        if not _RUN.fullmatch(name) or folder.is_symlink() or not (folder / MARK).is_file():
            raise Outside(name)
        return folder

    def end(self, name: str, taken: Collection[str]) -> str:
        """Gives a folder the name that its files have in common; returns it, empty where no file has come."""
        shown = _appear(self.root, self.folder(name), taken, "")
        self._held.pop(name, ExitStack()).close()
        return shown

    def close(self) -> None:
        """Lets go of folders whose files no longer come."""
        for held in self._held.values():
            held.close()


def left_over(root: Path) -> list[str]:
    """Shows the files of runs whose browser or server ended before all had come; returns the names of their folders.

    What has come whole is the user's: it gets a name that says that something is missing. Empty folders go.
    """
    shown = []
    for folder in sorted(root.glob(f"{RUN}*")):
        mark = folder / MARK
        with suppress(OSError):
            if not _RUN.fullmatch(folder.name) or folder.is_symlink() or not mark.is_file() or mark.is_symlink():
                continue
            with abandoned(mark) as is_so:
                if is_so and (name := _appear(root, folder, (), "-incomplete")):
                    shown.append(name)
    return shown


def _appear(root: Path, folder: Path, taken: Collection[str], ending: str) -> str:
    names = sorted(entry.name for entry in folder.iterdir() if entry.name != MARK)
    if not names:
        shutil.rmtree(folder)
        return ""
    stems = [Path(name).stem for name in names if name != BAG_INDEX] or names
    alike = takewhile(lambda letters: len({*letters}) == 1, zip(*stems, strict=False))
    common = "".join(letters[0] for letters in alike).strip("-_. ")
    shown = free(root, (common if len(common) > 2 else "run") + ending, {*taken})
    (folder / MARK).unlink()
    folder.rename(root / shown)
    (root / shown).chmod(0o777 & ~umask())  # a folder for one person alone until then
    return shown
