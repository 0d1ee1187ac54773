"""Pages of values, for people."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.files import write_text
from planner.reports.page import Page, render

if TYPE_CHECKING:
    from identification.identifiability import Identifiability
    from identification.model import Model
    from identification.outcome import Result
    from planner.comparison.advising import Comparison
    from planner.plans import Plan
    from planner.validation.validation import Validation

    Shown = Plan | Result | Comparison | Validation

# What only one kind of value needs is imported for that: SciPy takes a second.


def report(value: "Shown", file: Path | str) -> None:
    """Writes the page of a value, one HTML file that needs no network.

    Args:
        value: a plan, a result, a comparison, a validation.
        file: file to write.
    """
    write_text(Path(file), render(page(value)))


def page(value: "Shown") -> Page:
    """The page of a value."""
    return _PAGES[type(value).__name__](value)


def _page_of_result(result: "Result") -> Page:
    from planner.reports.identify import identify_page

    return identify_page(result)


def _page_of_comparison(comparison: "Comparison") -> Page:
    from planner.reports.compare import compare_page

    return compare_page(comparison.groups, comparison.advice)


def _page_of_validation(validation: "Validation") -> Page:
    from planner.reports.validation import validation_page

    v = validation
    return validation_page(v.case, v.steps, v.findings, v.columns, v.machine, v.failed, v.remedies)


def _page_of_plan(plan: "Plan") -> Page:
    if len(plan.poses):
        from planner.reports.poses import poses_page

        return poses_page(plan, _of_poses(plan)[1])
    from planner.comparison.beside_manual import beside_manual
    from planner.reports.plan import plan_page

    return plan_page(plan, beside_manual(plan))


_PAGES: "dict[str, Callable[[Any], Page]]" = {  # by name: to import the types of all takes a second
    "Plan": _page_of_plan,
    "Result": _page_of_result,
    "Comparison": _page_of_comparison,
    "Validation": _page_of_validation,
}


def _of_poses(plan: "Plan") -> "tuple[Model, Identifiability]":
    """The model of a plan of poses, and what its poses determine."""
    from identification.identifiability import analyse
    from planner.noise import standing_model
    from planner.poses.pose_criteria import pose_regressors

    model = standing_model(plan.case, plan.model)
    return model, analyse(pose_regressors(model, plan.poses), model.names)
