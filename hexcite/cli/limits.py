"""`hexcite bound` and `hexcite retime`: the information limit of motions, and the pace at which limits let one run."""

from pathlib import Path
from typing import Annotated

import hexcite as hx
from cases.base.atomic import write_text
from cases.base.folder_kinds import PLAN
from cases.base.options import default_of
from cases.base.output_places import check_file, check_folder
from cases.base.text_formats import json_text
from hexcite.cli import console
from hexcite.cli.console import argument, out
from hexcite.cli.declared import takes
from identification.texts import aligned, limit_lines
from planner.options import Model, Pace, PaceWithout, TimeLimit


@takes()
def bound(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    model: Model = default_of(Model),
    time_limit: TimeLimit = default_of(TimeLimit),
    output: Annotated[Path | None, out("File for the JSON answer as well.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Compute how much any motion inside the limits can tell.

    No motion passes it: the answer comes with its certificate.
    """
    from time import perf_counter

    from identification.model.model import full_model

    if output is not None:
        check_file(output, [".json"], overwrite=overwrite)
    loaded = hx.load_case(case)
    start = perf_counter()
    model = full_model(loaded) if model is None else model
    with console.status(f"information limit of {loaded.name}, model {model}", json) as report:
        limit = hx.bound(loaded, model, time_limit=time_limit, progress=report)
    answer = {
        "case": loaded.name,
        "case_hash": loaded.hash,
        "model": model,
        "over": "motion box",
        "logdet_bound": limit.logdet,
        "logdet_design": limit.design_logdet,
        "certified": limit.certified,
        "certificate": {"dmax": limit.dmax, "p": limit.parameters, "method": limit.method},
        "solve_s": perf_counter() - start,
    }
    if output is not None:
        write_text(output, json_text(answer))
    console.answered(answer, json, limit)


@takes()
def retime(
    source: Annotated[Path, argument("Plan folder.")],
    method: Pace = default_of(Pace),
    without: PaceWithout = default_of(PaceWithout),
    case: console.OwnCase = None,
    output: Annotated[Path | None, out("Plan folder of the re-timed motion.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Make a plan of the same path at another pace.

    With ruckig, moves are timed as a jerk-limited controller times them, other paths slowed until they satisfy every
    limit. With toppra, any path runs as fast as all limits but jerk allow, for controllers that do not limit jerk.
    Prints figures before and after; without -o nothing is written.
    """
    from planner.families.plan_settings import RetimedSettings

    if output is not None:
        check_folder(output, PLAN, [source], overwrite)
    plan = hx.Plan.load(source, None if case is None else hx.load_case(case), stale)
    with console.status("re-timing", json) as report:
        result = hx.retime(plan, method, without)
        if output is not None:
            report("writing")
            console.save_with_page(result, PLAN, output, overwrite)
    before, after = _figures(plan), _figures(result)
    assert isinstance(result.settings, RetimedSettings)
    answer = {
        "source": str(source),
        "method": result.settings.retimed_with,
        "model": result.model,
        "before": before,
        "after": after,
        "limits": result.limits.to_json(),
        "remarks": list(plan.stale),
        "solve_s": result.solve_s,
        "plan": str(output) if output is not None else None,
    }
    rows = [(key, f"{value:.5g}", f"{after[key]:.5g}") for key, value in before.items()]
    notes = (f"note: {remark}" for remark in plan.stale)
    written = () if output is None else (f"plan written: {output}",)
    table = aligned(("", "before", "after"), *rows)
    console.answered(answer, json, *limit_lines(result.limits.checks), *table, *notes, *written)


def _figures(plan: "hx.Plan") -> dict[str, float]:
    worth = plan.of_motion[1]
    figures = {"criterion_value": worth.criterion_value, "d_efficiency": worth.d_efficiency}
    return {"duration_s": plan.duration, **figures, "condition": worth.condition}
