"""The page of a plan: what it promises, the machine along it, and how close it comes to its limits."""

from markupsafe import Markup

from cases.base.phrases import enumerated, phrase
from cases.base.provenance import provenance
from hexcite._identifiability import identifiability_of_models
from hexcite.reports.drawing.figures import limits_table, motion_blocks
from hexcite.reports.drawing.scene import Scene, moving_machine, posing_machine, with_limits
from hexcite.reports.identifiability import identifiability_blocks
from hexcite.reports.page import Head, note, page, section, table, tiles
from identification.limits.limit import NAMED, TOLERANCE, Status
from identification.motion.motion import sample
from identification.texts import as_sentences
from planner.plans.plan import Plan

KEPT = "No limit of the case is exceeded: proven at 10 kHz"
DRAWN_RATE = 500.0  # [1/s]


def plan_page(plan: Plan) -> str:
    """The page of `hexcite plan` and `hexcite poses`."""
    case = plan.case
    entries = {"criterion": plan.request.criterion, "model": plan.model, **plan.settings.to_json()}
    inputs = [(name, str(value)) for name, value in entries.items() if not isinstance(value, list | dict)]
    notes = map(as_sentences, plan.remarks)
    first, *each = plan.deviation_rows()
    deviations = table(first, each)
    head, *rows = plan.budget_rows() or [()]
    parts = [table(head, rows)] if rows else []
    counted = [check for check in plan.limits.checks if check.status is not Status.LEFT_OUT]
    exceeded = [check.name for check in counted if check.ratio > 1.0 + TOLERANCE]
    words = phrase("limits_kept", KEPT)
    if exceeded:
        limits = enumerated("comma", [phrase(NAMED, name, name=name) for name in exceeded])
        words = phrase("limits_exceeded", "EXCEEDED, which its controller does not limit: {limits}", limits=limits)
    if plan.without:
        left_out = ", ".join(plan.without)
        words = phrase("without_as_planned", "{words}, without {left_out} as planned", words=words, left_out=left_out)
    verdict = as_sentences(words, *plan.doubts)
    scene = scene_of(plan)
    return page(
        phrase("page_of_plan", "Plan: {machine}", machine=case.heading_phrase),
        Head(verdict, not (plan.doubts or exceeded), case.name, (("plan", plan.headline),)),
        "What the motion is, how precise its run will make the parameters, and how close it comes to each limit.",
        (("case", f"{case.name} (hash {case.hash})"), *inputs, *provenance([])["versions"].items()),
        (),  # all doubts stand in the verdict
        section("What the plan promises", _headline(plan), deviations, *parts, *map(note, notes)),
        section(
            "Which parameters can be told apart", *identifiability_blocks(identifiability_of_models(plan), plan.model)
        ),
        section("The machine along the plan", scene),
        section("How close it comes to each limit", limits_table(plan.limits)),
        section("The motion and its limits", *motion_blocks(case, sample(plan.motion, DRAWN_RATE))),
    )


def scene_of(plan: Plan) -> Scene:
    """The machine along a plan, with how far each limit is used; or in one pose after the other."""
    if len(plan.poses):
        return posing_machine(plan.case, plan.poses)
    return with_limits(moving_machine(plan.case, plan.motion), plan.case, plan.motion, plan.without)


def _headline(plan: Plan) -> Markup:
    efficiency, measure = plan.rating
    most = max(check.ratio for check in plan.limits.checks if check.binding and check.room is None)
    return tiles(
        (f"{plan.duration:.2f} s", "duration, from rest to rest"),
        (f"{efficiency:.3f}", phrase("efficiency_measured", "D-efficiency {measure}", measure=measure)),
        (f"{plan.worth.condition:.3g}", "condition in reference scaling"),
        (f"{100 * most:.1f} %", "most that is used of any limit of position, speed or force"),
    )
