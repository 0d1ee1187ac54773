"""What a result was computed from: files with their SHA-256 and date, and versions of programs."""

import hashlib
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

_TOOLS = ("hexcite", "numpy", "scipy", "casadi", "pyarrow")


def provenance(files: Sequence[Path]) -> dict[str, Any]:
    """Origin of what was computed from files: `inputs`, each with its SHA-256, and `versions`."""
    return {"inputs": [{"file": str(f), "sha256": sha256_of(f)} for f in files], "versions": _versions()}


def date_of(files: Sequence[Path]) -> str:
    """When the first of files was written, as its folder says, in ISO 8601 with its zone, to the second."""
    first = min(file.stat().st_mtime for file in files)
    return datetime.fromtimestamp(first).astimezone().isoformat(timespec="seconds")


def sha256_of(file: Path) -> str:
    """SHA-256 of what a file holds, read piece by piece."""
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _versions() -> dict[str, str]:
    from importlib.metadata import PackageNotFoundError, version  # which `hexcite --help` does without

    versions = {}
    for name in _TOOLS:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:  # run from a folder that was never installed
            versions[name] = "unknown"
    return versions
