"""The page of a plan: what it promises, the machine along it, and how close it comes to its limits."""

from markupsafe import Markup

from cases.files import provenance
from identification.motion import sample
from planner.plans import Plan
from planner.reports.figures import limits_chart, motion_blocks
from planner.reports.machine import pictured
from planner.reports.page import note, page, section, table, tiles

DRAWN_RATE = 500.0  # [1/s]


def plan_page(plan: Plan) -> str:
    """The page of `hexcite plan` and `hexcite poses`."""
    case = plan.case
    entries = {"criterion": plan.request.criterion, "model": plan.model, **plan.settings}
    inputs = [(name, str(value)) for name, value in entries.items() if not isinstance(value, list | dict)]
    notes = [f"{text[0].upper()}{text[1:]}." for text in plan.remarks]
    deviations = table(("parameter", "predicted std", "unit"), plan.deviation_rows())
    return page(
        f"Plan: {case.title}",
        f"{plan.headline}. Every limit is proven at 10 kHz.",
        (("case", f"{case.name} (hash {case.hash})"), *inputs, *provenance([])["versions"].items()),
        plan.doubts,
        section("What the plan promises", _headline(plan), deviations, *map(note, notes)),
        *pictured(case, plan.motion, plan.poses),
        section("How close it comes to each limit", limits_chart(plan.limits)),
        section("The motion and its limits", *motion_blocks(case, sample(plan.motion, DRAWN_RATE))),
    )


def _headline(plan: Plan) -> Markup:
    efficiency, measure = plan.rating
    return tiles(
        (f"{plan.duration:.2f} s", "duration, from rest to rest"),
        (f"{efficiency:.3f}", f"D-efficiency {measure}"),
        (f"{plan.worth.condition:.3g}", "condition in reference scaling"),
        (f"{plan.limits.worst_ratio * 100:.1f} %", "most that is used of any limit"),
    )
