"""Finished steps of a validation in files, so that an interrupted one does only what is missing."""

from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from cases.files import write_text
from planner.validation.remedy import Remedy
from planner.validation.step import Step


@dataclass(frozen=True, slots=True)
class Kept:
    """A finished step.

    Args:
        key: fingerprint of all that it follows from, but for what the whole validation has in common.
        controller: that executed the method, and what to know about the run.
        step: as found.
        remedy: the same with the structural mode, where that was the cause of an error.
    """

    key: str
    controller: str
    step: Step
    remedy: Remedy | None


_JSON = TypeAdapter(Kept)


def keep(folder: Path, done: Kept) -> None:
    """Writes a finished step."""
    write_text(_file(folder, done.step.method, done.step.weights), _JSON.dump_json(done).decode())


def kept_step(folder: Path, method: str, weights: int, key: str) -> Kept | None:
    """A step that was finished before; None where there is none that follows from the same."""
    file = _file(folder, method, weights)
    if not file.is_file():
        return None
    try:
        found = _JSON.validate_json(file.read_bytes())
    except ValidationError:  # of another version of this program
        return None
    return found if found.key == key else None


def _file(folder: Path, method: str, weights: int) -> Path:
    return folder / "steps" / f"{method}-{weights}.json"
