"""Files on their way from the browser: each comes whole or not at all, those of one run in a folder of their own."""

import os
import re
import shutil
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Collection, Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import takewhile
from pathlib import Path

from starlette.concurrency import run_in_threadpool

from cases.base.atomic import umask
from cases.base.leftovers import PART, abandoned, in_use
from hexcite.page.security import Outside
from hexcite.page.stages import BAG_INDEX, MARK, free

RUN = "incomplete-"
"""How names of folders begin whose files are on their way: to be seen, whatever becomes of server and browser."""
_RUN = re.compile(re.escape(RUN) + r"[a-z0-9_]{8}")
WAIT = 600.0
"""Time after which no further file is expected of a browser that has not ended a run [s]."""


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
    """Folders that files of one run come into; no stage offers them until all of them are there.

    Args:
        root: the folder that they are in.
        clock: time [s].
    """

    def __init__(self, root: Path, clock: Callable[[], float] = time.monotonic) -> None:
        self.root, self._clock = root, clock
        self._held: dict[str, ExitStack] = {}
        self._heard: dict[str, float] = {}  # when something of a run came last
        self._coming: list[str] = []  # runs of which a file is just coming

    def begin(self) -> str:
        """Makes a folder; returns its name until it is whole."""
        folder = Path(tempfile.mkdtemp(prefix=RUN, dir=self.root))
        (folder / MARK).touch()
        lock = self._held[folder.name] = ExitStack()
        lock.enter_context(in_use(folder / MARK))
        self._heard[folder.name] = self._clock()
        return folder.name

    @contextmanager
    def arriving(self, name: str) -> Iterator[Path]:
        """The folder of a run, which is kept while a file comes into it; raises Outside for any other name."""
        folder = self.folder(name)
        self._coming.append(name)
        try:
            yield folder
        finally:
            self._coming.remove(name)
            self._heard[name] = self._clock()

    def give_up(self, taken: Collection[str]) -> list[str]:
        """Shows what has come of runs whose browser went away; returns the names of their folders."""
        names = []
        for name in [each for each in self._held if each not in self._coming]:
            if self._clock() - self._heard[name] > WAIT:
                with suppress(OSError, Outside):
                    names.append(_appear(self.root, self.folder(name), taken, ENDING))
                self._forget(name)
        return [name for name in names if name]

    def _forget(self, name: str) -> None:
        self._held.pop(name, ExitStack()).close()
        self._heard.pop(name, None)

    def folder(self, name: str) -> Path:
        """The folder of a run that is on its way; raises Outside for any other name."""
        folder = self.root / name
        if not _RUN.fullmatch(name) or folder.is_symlink() or not (folder / MARK).is_file():
            raise Outside(name)
        return folder

    def end(self, name: str, taken: Collection[str]) -> str:
        """Gives a folder the name that its files have in common; returns it, empty where no file has come."""
        shown_name = _appear(self.root, self.folder(name), taken, "")
        self._forget(name)
        return shown_name

    def close(self) -> None:
        """Lets go of folders whose files no longer come."""
        for lock in self._held.values():
            lock.close()


ENDING = "-incomplete"
"""How the names of runs end of which a file may be missing."""


def left_over(root: Path) -> list[str]:
    """Shows the files of runs whose browser or server ended before all had come; returns the names of their folders.

    What has come whole is the user's: it gets a name that says that something is missing. Empty folders go.
    """
    names = []
    for folder in sorted(root.glob(f"{RUN}*")):
        mark = folder / MARK
        with suppress(OSError):
            if not _RUN.fullmatch(folder.name) or folder.is_symlink() or not mark.is_file() or mark.is_symlink():
                continue
            with abandoned(mark) as is_so:
                if is_so and (name := _appear(root, folder, (), ENDING)):
                    names.append(name)
    return names


def _appear(root: Path, folder: Path, taken: Collection[str], ending: str) -> str:
    names = sorted(entry.name for entry in folder.iterdir() if entry.name != MARK)
    if not names:
        shutil.rmtree(folder)
        return ""
    stems = [Path(name).stem for name in names if name != BAG_INDEX] or names
    alike = takewhile(lambda letters: len({*letters}) == 1, zip(*stems, strict=False))
    common = "".join(letters[0] for letters in alike).strip("-_. ")
    free_name = free(root, (common if len(common) > 2 else "run") + ending, {*taken})
    (folder / MARK).unlink()
    folder.rename(root / free_name)
    (root / free_name).chmod(0o777 & ~umask())  # a folder for one person alone until then
    return free_name
