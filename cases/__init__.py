"""The case: one machine, its sensors and its limits, as data."""

from typing import TYPE_CHECKING

from cases.base.doors import door

if TYPE_CHECKING:
    from cases.base.errors import HexciteError as HexciteError
    from cases.scaffold import new_case as new_case
    from cases.schema import Case as Case
    from cases.schema import load_case as load_case

PUBLIC = {
    "HexciteError": "cases.base.errors",
    "new_case": "cases.scaffold",
    "Case": "cases.schema",
    "load_case": "cases.schema",
}
"""Public names, and the modules that they are imported from when they are first used."""
__getattr__, __dir__ = door(__name__, PUBLIC)
