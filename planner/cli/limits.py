"""`hexcite bound` and `hexcite retime`: the information limit of motions, and the pace at which limits let one run."""

from pathlib import Path
from typing import Annotated, Any

import hexcite as hx
from cases.files import PLAN, check_file, check_folder, json_text, write_text
from planner.cli import console
from planner.cli.console import argument, option, out


def bound(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    model: Annotated[int | None, option("Identification model; by default the largest of the machine.")] = None,
    time_limit: Annotated[
        float, option("Stop after this many seconds of computing; the answer is an estimate.")
    ] = 120.0,
    output: Annotated[Path | None, out("File for the JSON answer as well.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Compute how much information any motion inside the limits has.

    No motion passes it: the answer comes with its certificate.
    """
    from time import perf_counter

    from identification.model import full_model

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
    if not console.answered(answer, json):
        _show_bound(answer)


def _show_bound(answer: dict[str, Any]) -> None:
    parameters, method = answer["certificate"]["p"], answer["certificate"]["method"]
    limit, design = answer["logdet_bound"], answer["logdet_design"]
    print(f"{answer['case']}, model {answer['model']}, {parameters} parameters: log det in reference scaling, W = 1")
    print(f"best distribution found over the {answer['over']}: {design:.4f}, by: {method}")
    kind = "proven" if answer["certified"] else "an ESTIMATE; a longer --time-limit may prove it"
    print(
        f"no motion exceeds log det {limit:.4f} ({kind}, {100 * (limit - design) / parameters:.2g} % of an efficiency "
        f"above the best that was found; {answer['solve_s']:.1f} s)"
    )


def retime(
    source: Annotated[Path, argument("Plan folder.")],
    case: console.OwnCase = None,
    output: Annotated[Path | None, out("Plan folder of the re-timed motion.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Make a plan of the same path at another pace.

    Moves are timed as a jerk-limited controller times them, other paths slowed until they satisfy every limit. Prints
    figures before and after; without -o nothing is written.
    """
    if output is not None:
        check_folder(output, PLAN, [source], overwrite)
    plan = hx.Plan.load(source, None if case is None else hx.load_case(case), stale)
    with console.status("re-timing", json) as report:
        result = hx.retime(plan)
        if output is not None:
            report("writing")
            console.save_with_page(result, PLAN, output, overwrite)
    answer = {
        "source": str(source),
        "method": result.settings["retimed_with"],
        "model": result.model,
        "before": _figures(plan),
        "after": _figures(result),
        "limits": result.limits.to_json(),
        "remarks": list(plan.stale),
        "solve_s": result.solve_s,
        "plan": str(output) if output is not None else None,
    }
    if not console.answered(answer, json):
        rows = [(key, f"{value:.5g}", f"{answer['after'][key]:.5g}") for key, value in answer["before"].items()]
        console.print_table(f"Re-timed with {answer['method']}, model {result.model}", ("", "before", "after"), rows)
        console.print_table("Limits after re-timing", console.LIMIT_COLUMNS, console.limit_rows(result.limits.checks))
        for remark in plan.stale:
            print(f"note: {remark}")
        if output is not None:
            print(f"plan written: {output}")


def _figures(plan: "hx.Plan") -> dict[str, float]:
    worth = plan.of_motion[1]
    figures = {"criterion_value": worth.criterion_value, "d_efficiency": worth.d_efficiency}
    return {"duration_s": plan.duration, **figures, "condition": worth.condition}
