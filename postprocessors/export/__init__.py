"""The calibrated model in the languages of controllers."""

from typing import TYPE_CHECKING

from cases.base.doors import door

if TYPE_CHECKING:
    from postprocessors.export.targets import export as export
    from postprocessors.export.targets import preview as preview

PUBLIC = {
    "export": "postprocessors.export.targets",
    "preview": "postprocessors.export.targets",
}
"""Public names, and the modules that they are imported from when they are first used."""
__getattr__, __dir__ = door(__name__, PUBLIC)
