"""Methods of a validation and its options; nothing heavy is imported, for `hexcite --help` shows them."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import cases
from cases.base.options import Option
from planner.options import Workers

METHOD_TABLES = tomllib.loads((Path(cases.__file__).parent / "hexapod" / "validation.toml").read_text(encoding="utf-8"))
"""The methods of a validation as their file states them, by name."""


@dataclass(frozen=True, slots=True)
class ValidationOptions:
    """What may be asked of a validation, beside its methods and its weights."""

    on: Annotated[str, Option("Controller: virtual or linuxcnc.")] = "virtual"
    starts: Annotated[int, Option("Random starts of the optimised methods.")] = 2
    seed: Annotated[int, Option("Seed of the starts and of the sensors' noise.")] = 0
    workers: Workers = None
