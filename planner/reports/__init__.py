"""Pages, and pictures in files: `report` writes the page of a value."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.files import write_text

if TYPE_CHECKING:
    from identification.outcome import Result
    from planner.comparison.comparison import Comparison
    from planner.comparison.validation import Validation
    from planner.plans import Plan


def report(value: "Plan | Result | Comparison | Validation", file: Path | str) -> None:
    """Writes the page of a value, one HTML file that needs no network."""
    write_text(Path(file), page_of(value))


def page_of(value: Any) -> str:
    """The page of a value as HTML."""
    match type(value).__name__:  # to import the types of all takes a second
        case "Plan":
            from planner.reports.plan import plan_page

            return plan_page(value)
        case "Result":
            from planner.reports.identify import identify_page

            return identify_page(value)
        case "Comparison":
            from planner.reports.compare import compare_page

            return compare_page(value)
        case _:
            from planner.reports.validation import validation_page

            return validation_page(value)
