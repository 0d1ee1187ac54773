"""Pages and figures of values, for people."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.files import write_text
from planner.reports.page import Page, render

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from identification.identifiability import Identifiability
    from identification.model import Model
    from identification.outcome import Result
    from planner.comparison.advising import Comparison
    from planner.plans import Plan
    from planner.validation.validation import Validation

    Shown = Plan | Result | Comparison | Validation

# What only one kind of value needs is imported for that: SciPy and Matplotlib take a second.


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


def figures(value: "Shown", folder: Path) -> None:
    """Writes figures for papers as SVG and PNG into a folder."""
    from planner.reports.plots import save_figure

    for name, figure in _figures(value):
        save_figure(figure, folder, name)


def _figures(value: "Shown") -> "Iterator[tuple[str, Figure]]":
    from identification.outcome import Result
    from planner.comparison.advising import Comparison
    from planner.plans import Plan
    from planner.reports.plots import identifiability_figure, residual_figure

    if isinstance(value, Result):
        if value.estimate is not None:
            yield "residuals", residual_figure(value.estimate)
        if value.identifiability is not None:
            yield "identifiability", identifiability_figure(value.identifiability)
    elif isinstance(value, Comparison):
        from planner.reports.compare import compare_figure

        yield "standard_deviations", compare_figure(value.groups)
    elif isinstance(value, Plan):
        yield from _figures_of_plan(value)
    else:
        from planner.reports.validation import std_figure

        yield "standard_deviations", std_figure(value.steps)


def _figures_of_plan(plan: "Plan") -> "Iterator[tuple[str, Figure]]":
    from identification.motion import sample
    from planner.plans import SAMPLE_RATE
    from planner.poses.planned_poses import candidates_of
    from planner.poses.pose_plots import density_figure, pose_figure
    from planner.poses.pose_request import PoseRequest
    from planner.reports.plots import identifiability_figure, trajectory_figure
    from planner.worth import PoseWorth

    if isinstance(plan.request, PoseRequest) and isinstance(plan.worth, PoseWorth):
        model, found = _of_poses(plan)
        yield "poses", pose_figure(plan.case, candidates_of(plan.request, plan.case, plan.poses).poses, plan.poses)
        yield "densities", density_figure(plan.case, model, plan.predicted_std, dict(plan.worth.std_of_all))
        yield "identifiability", identifiability_figure(found)
    else:
        yield "trajectory", trajectory_figure(sample(plan.motion, SAMPLE_RATE), plan.case)


def _of_poses(plan: "Plan") -> "tuple[Model, Identifiability]":
    """The model of a plan of poses, and what its poses determine."""
    from identification.identifiability import analyse
    from planner.noise import standing_model
    from planner.poses.pose_criteria import pose_regressors

    model = standing_model(plan.case, plan.model)
    return model, analyse(pose_regressors(model, plan.poses), model.names)
