"""The case: one machine, its sensors and its limits, as data, and the errors that every package raises."""

from typing import TYPE_CHECKING

from cases.door import door

if TYPE_CHECKING:
    from cases.errors import HexciteError as HexciteError
    from cases.loading import load_case as load_case
    from cases.schema import Case as Case

__getattr__, __dir__ = door(
    __name__, {"cases.errors": "HexciteError", "cases.loading": "load_case", "cases.schema": "Case"}
)
