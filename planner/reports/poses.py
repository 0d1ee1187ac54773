"""The page of a pose set: the machine in each pose, what the set promises, and what its poses determine."""

from cases.files import provenance
from identification.criteria import analyse
from planner.noise import standing_model
from planner.plans import Plan
from planner.poses.planned_poses import candidates_of
from planner.poses.pose_criteria import pose_regressors
from planner.poses.space import places
from planner.reports.charts import Chart, plain
from planner.reports.figures import COLOURS, GREY, identifiability_items
from planner.reports.machine import posing_machine
from planner.reports.page import Item, Note, Page, Plot, Section, Table, Tiles
from planner.request import PoseRequest


def poses_page(plan: Plan) -> Page:
    """The page of `hexcite poses`."""
    model = standing_model(plan.case, plan.model)
    found = analyse(pose_regressors(model, plan.poses), model.names)
    about = plan.to_json()
    case, settings = plan.case, about["settings"]
    tiles = (
        (str(about["count"]), f"poses of {about['candidates']} candidates"),
        (f"{about['duration_s']:.1f} s", f"measuring time, of it {about['travel_s']:.1f} s of travel"),
        (f"{about['efficiency']:.3f}", "D-efficiency of the best design over the candidates (lower bound)"),
        (f"{about['condition']:.3g}", "condition in reference scaling"),
    )
    words = (
        f"chosen by {about['method']}, criterion {about['criterion']}, for model {about['model']}: {about['remark']}."
    )
    inputs = [("case", f"{case.name} (hash {case.hash})"), *((k, str(v)) for k, v in settings.items())]
    return Page(
        title=f"Poses: {case.title}",
        lead=f"{about['count']} poses {words}",
        inputs=(*inputs, *provenance([])["versions"].items()),
        warnings=(),
        sections=(
            Section("What the set promises", (Tiles(tiles), *_deviations(plan))),
            *_pictures(plan),
            Section("Where the poses are", (_places(plan),)),
            Section("What the poses determine", identifiability_items(found)),
        ),
    )


def _pictures(plan: Plan) -> tuple[Section, ...]:
    """The machine in each pose; of a chain there is no picture yet."""
    if plan.case.chain is not None:
        return ()
    return (Section("The machine in each pose", (posing_machine(plan.case, plan.poses, "In the order of visit."),)),)


def _deviations(plan: Plan) -> tuple[Item, ...]:
    note = Note(
        f"Predicted for averaged forces that scatter by {plan.assumed_noise:.3g} N, independently from pose to pose."
    )
    return (Table(("parameter", "predicted std", "unit"), plan.deviation_rows()), note)


def _places(plan: Plan) -> Plot:
    assert isinstance(plan.request, PoseRequest)
    figure = Chart()
    for poses, name, size, colour in (
        (candidates_of(plan.request, plan.case, plan.poses).poses, "candidates", 5, GREY),
        (plan.poses, "chosen", 10, COLOURS[1]),
    ):
        at = places(plan.case, poses)
        marker = {"size": size, "color": colour}
        figure.add_scatter(x=at[:, 0] * 1e3, y=at[:, 1] * 1e3, mode="markers", name=plain(name), marker=marker)
    figure.update_xaxes(title="x [mm]", constrain="domain")
    figure.update_yaxes(title="y [mm]", scaleanchor="x", constrain="domain")
    return Plot("places", figure.update_layout(height=460), "Seen from above; several orientations share a place.")
