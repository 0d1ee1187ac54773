"""What `recording.json` in a folder of `hexcite run` says of its run."""

from pathlib import Path
from typing import Any

from cases.files import read_json


def about_recording(path: Path) -> dict[str, Any]:
    """What the folder says; nothing where `path` is no such folder.

    Raises:
        FileProblem: recording.json is damaged.
    """
    file = path / "recording.json"
    return read_json(file, "hexcite run") if path.is_dir() and file.is_file() else {}
