"""Plans, runs and results side by side, which excitation to prefer, and what known weights say of each method."""

import tomllib
from pathlib import Path

import cases

METHOD_TABLES = tomllib.loads((Path(cases.__file__).parent / "hexapod" / "validation.toml").read_text(encoding="utf-8"))
"""The methods of a validation as their file states them, by name."""
