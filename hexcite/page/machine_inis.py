"""INI files of LinuxCNC machines in the root folder, which programs are compared with."""

import re
from pathlib import Path

from hexcite.page.forms import chosen
from hexcite.page.refusals import Unfit
from hexcite.page.security import Outside, inside

MOST = 100  # files that are shown
_INCLUDE = re.compile(rb"^\s*#INCLUDE\s+(.+?)\s*$", re.MULTILINE)


def inis(root: Path) -> list[str]:
    """Names of the INI files in the root folder."""
    files = (path for path in root.glob("*.ini") if not path.name.startswith(".") and path.is_file())
    return sorted(path.name for path in files if path.resolve().is_relative_to(root))[:MOST]


def includes_beyond(root: Path, name: str) -> bool:
    """Whether an INI file includes one that is not in the root folder, where nobody's browser is to look."""
    for include in _INCLUDE.findall((root / name).read_bytes()):
        try:
            inside(root, include.decode("utf-8", "replace"))
        except Outside:
            return True
    return False


def ini_of(root: Path, name: str) -> str:
    """The INI file that a form names, empty where it names none; raises Unfit where there is none, or not all of it."""
    ini = chosen({"ini": [name]}, "ini", ["", *inis(root)], "")
    if ini and includes_beyond(root, ini):
        raise Unfit("ini_includes", place=ini)
    return ini
