"""Where a result comes from: hashes of the files that went in, and versions of what computed it."""

import hashlib
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

_TOOLS = ("hexcite", "numpy", "scipy", "casadi", "pyarrow")


def provenance(files: Sequence[Path]) -> dict[str, Any]:
    """What `result.json` says of its origin: `inputs`, each with its SHA-256, and `versions`.

    Args:
        files: that were read; they are read once more, piece by piece.
    """
    return {"inputs": [{"file": str(f), "sha256": _sha256(f)} for f in files], "versions": _versions()}


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _versions() -> dict[str, str]:
    found = {}
    for name in _TOOLS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # run from a folder that was never installed
            found[name] = "unknown"
    return found
