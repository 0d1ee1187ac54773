"""What a server keeps in the folder besides what commands write: its address, and how its commands ended.

A server that is started again after the first was killed answers at the same address and shows the same state.
"""

import json
import os
import secrets
import stat
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

PLACE = ".hexcite-page"
"""The folder, for one person alone."""
MOST_BYTES = 16 * 2**20  # of one record
MOST_RECORDS = 200
_ADDRESS = "address.json"


class Address(NamedTuple):
    """Where a page answers: its port, 0 for any, and the secret of its address."""

    port: int
    token: str


def address_of(root: Path) -> Address:
    """The address that the page of a folder had; a new one where it had none, or others may read it."""
    record = _read(root / PLACE / _ADDRESS, private=True)
    port, token = record.get("port"), record.get("token")
    if isinstance(port, int) and 0 < port <= 65535 and isinstance(token, str) and len(token) >= 20:
        return Address(port, token)
    return Address(0, secrets.token_urlsafe(24))


def keep_address(root: Path, address: Address) -> None:
    """Keeps an address for the next server of the folder, readable by its owner alone."""
    _write(root / PLACE / _ADDRESS, address._asdict())


class Journal:
    """Records of commands, each in a file of its own, so that several servers of a folder do not fight."""

    def __init__(self, root: Path) -> None:
        self.folder = root / PLACE

    def write(self, name: str, record: Mapping[str, Any]) -> None:
        """Keeps a record, in place of an earlier one of this name; one that cannot be kept is not."""
        _write(self.folder / f"{name}.json", record)

    def remove(self, name: str) -> None:
        """Forgets a record."""
        with suppress(OSError):
            (self.folder / f"{name}.json").unlink()

    def records(self) -> dict[str, dict[str, Any]]:
        """Records by name, the earliest first; damaged ones are left out, those beyond the newest many removed."""
        try:
            names = sorted(file.stem for file in self.folder.glob("[0-9]*.json"))
        except OSError:
            return {}
        for name in names[:-MOST_RECORDS]:
            self.remove(name)
        records = {name: _read(self.folder / f"{name}.json") for name in names[-MOST_RECORDS:]}
        return {name: record for name, record in records.items() if record}


def alive(process: object) -> bool:
    """Whether there is a process of this number."""
    if not isinstance(process, int) or process <= 0:
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _read(file: Path, private: bool = False) -> dict[str, Any]:
    try:
        handle = os.open(file, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        with os.fdopen(handle, "rb") as stream:
            about = os.fstat(handle)
            open_to_others = private and (about.st_mode & 0o077 or about.st_uid != os.getuid())
            if not stat.S_ISREG(about.st_mode) or about.st_size > MOST_BYTES or open_to_others:
                return {}
            content = json.loads(stream.read())
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _write(file: Path, content: Mapping[str, Any]) -> None:
    part = file.with_name(f"{file.name}.{os.getpid()}")
    with suppress(OSError):
        file.parent.mkdir(mode=0o700, exist_ok=True)
        if file.parent.is_symlink():
            return
        part.unlink(missing_ok=True)
        with os.fdopen(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as stream:
            json.dump(content, stream)
        os.replace(part, file)
