"""Pages and figures of values, for people."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from cases.files import write_text
from identification.identifiability import Identifiability, analyse
from identification.model import Model, identification_model
from identification.motion import sample
from identification.outcome import Result
from planner.comparison.beside_manual import beside_manual
from planner.comparison.compare import Comparison
from planner.plan import SAMPLE_RATE, Plan
from planner.poses.plan import candidates_of
from planner.poses.regressors import pose_regressors
from planner.poses.request import PoseRequest
from planner.reports.identify import identify_page
from planner.reports.page import Page, render
from planner.reports.plan import plan_page
from planner.reports.poses import poses_page
from planner.validation.validate import Validation
from planner.worth import PoseWorth

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Shown = Plan | Result | Comparison | Validation


def report(value: Shown, file: Path | str) -> None:
    """Writes the page of a value, one HTML file that needs no network.

    Args:
        value: a plan, a result, a comparison, a validation.
        file: to write.
    """
    write_text(Path(file), render(page(value)))


def page(value: Shown) -> Page:
    """The page of a value."""
    if isinstance(value, Result):
        return identify_page(value)
    if isinstance(value, Comparison):
        from planner.reports.compare import compare_page  # Matplotlib takes a second

        return compare_page(value.groups, value.advice)
    if isinstance(value, Validation):
        from planner.reports.validation import validation_page

        return validation_page(
            value.case, value.steps, value.findings, value.columns, value.machine, value.failed, value.remedies
        )
    if not len(value.poses):
        return plan_page(value, beside_manual(value))
    return poses_page(value, _of_poses(value)[1])


def figures(value: Shown, folder: Path) -> None:
    """Writes figures for papers as SVG and PNG into a folder."""
    from planner.reports.plots import save_figure  # Matplotlib takes a second

    for name, figure in _figures(value):
        save_figure(figure, folder, name)


def _figures(value: Shown) -> "Iterator[tuple[str, Figure]]":
    from planner.poses.plots import density_figure, pose_figure
    from planner.reports.plots import identifiability_figure, residual_figure, trajectory_figure

    if isinstance(value, Result):
        if value.estimate is not None:
            yield "residuals", residual_figure(value.estimate)
        if value.identifiability is not None:
            yield "identifiability", identifiability_figure(value.identifiability)
    elif isinstance(value, Comparison):
        from planner.reports.compare import compare_figure

        yield "standard_deviations", compare_figure(value.groups)
    elif isinstance(value, Validation):
        from planner.reports.validation import std_figure

        yield "standard_deviations", std_figure(value.steps)
    elif isinstance(value.request, PoseRequest) and isinstance(value.worth, PoseWorth):
        case, (model, found) = value.case, _of_poses(value)
        yield "poses", pose_figure(case, candidates_of(value.request, case).poses, value.poses)
        yield "densities", density_figure(case, model, value.predicted_std, dict(value.worth.std_of_all))
        yield "identifiability", identifiability_figure(found)
    else:
        yield "trajectory", trajectory_figure(sample(value.motion, SAMPLE_RATE), value.case)


def _of_poses(plan: Plan) -> tuple[Model, Identifiability]:
    """The model of a plan of poses, and what its poses determine."""
    model = identification_model(plan.case, plan.model)
    return model, analyse(pose_regressors(model, plan.poses), model.names)
