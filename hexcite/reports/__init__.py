"""Pages, and pictures in files: `report` writes the page of a value."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.base.atomic import write_text
from cases.base.errors import Code, HexciteError
from cases.base.output_places import check_file

if TYPE_CHECKING:
    from hexcite.comparison.comparison import Comparison
    from hexcite.comparison.validation import Validation
    from identification.results.force import ExternalForce
    from identification.results.history import History
    from identification.results.payload import Payload
    from identification.results.result import Result
    from planner.plans.plan import Plan

PAGES = (".html", ".htm")
"""Suffixes of pages."""


def report(
    value: "Plan | Result | Comparison | Validation | ExternalForce | History | Payload", file: Path | str
) -> None:
    """Writes the page of a value, one HTML file that needs no network; an earlier page is replaced.

    >>> hx.report(hx.Result.load("empty-result"), "empty.html")

    Args:
        file: ends in .html or .htm.

    Raises:
        FileProblem: it ends otherwise, or cannot be written.
    """
    check_file(place := Path(file), PAGES, overwrite=True)
    write_text(place, page_of(value))


def page_of(value: Any) -> str:
    """The page of a value as HTML."""
    match type(value).__name__:  # to import the types of all takes a second
        case "Plan":
            from hexcite.reports.plan import plan_page

            return plan_page(value)
        case "Result":
            from hexcite.reports.identify import identify_page

            return identify_page(value)
        case "Comparison":
            from hexcite.reports.compare import compare_page

            return compare_page(value)
        case "History":
            from hexcite.reports.history import history_page

            return history_page(value)
        case "ExternalForce":
            from hexcite.reports.force import force_page

            return force_page(value)
        case "Payload":
            from hexcite.reports.payload import payload_page

            return payload_page(value)
        case "Validation":
            from hexcite.reports.validation import validation_page

            return validation_page(value)
        case kind:
            raise HexciteError(
                place=kind,
                problem="has no page",
                remedy="give a plan, result, comparison, validation, force, history or payload",
                code=Code.WRONG_KIND,
            )
