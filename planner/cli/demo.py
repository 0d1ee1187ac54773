"""`hexcite demo`: the whole chain on one case, from its description to a report."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, print_json, print_table

ACCEPTED = ("jerk", "strut velocity", "strut acceleration", "sensor force")  # no metal moves in a demo


def demo(
    case: Annotated[
        str, typer.Option(help="Built-in name, folder or case file, with a simulated machine.")
    ] = "hexapod",
    on: Annotated[
        str | None, typer.Option(help="Controller: virtual or linuxcnc; by default LinuxCNC if installed.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the starts and of the sensors' noise.")] = 0,
    starts: Annotated[int, typer.Option(help="Number of random starts; one is enough for a demo.")] = 1,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for everything; hexcite-demo by default.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Plan, program, prove, execute, identify and report, end to end."""
    answer = run_demo(case, on, seed, starts, output, quiet=json, overwrite=overwrite)
    if json:
        print_json(answer)


def run_demo(
    case: str, on: str | None, seed: int, starts: int, output: Path | None, quiet: bool, overwrite: bool = False
) -> dict[str, Any]:
    """All steps; prints unless `quiet`; returns each step's JSON answer."""
    from cases.files import DEMO, check_folder, output_place, write_text
    from cases.loading import load_case
    from identification.identify import identifiability
    from identification.runs.residuals import residuals_of
    from planner.cli.identified import make_result
    from planner.cli.plan import make_plan
    from planner.cli.post import check_program, make_program, show_check
    from planner.cli.run import make_recording
    from planner.comparison.truth import truth_rows
    from planner.reports.demo import demo_page
    from planner.reports.page import render
    from planner.request import Request
    from planner.runs.running import best_controller

    def step(number: int, text: str) -> None:
        if not quiet:
            print(f"\n[{number}/6] {text}", flush=True)

    loaded = load_case(case)
    loaded.need_simulation("the demo")
    output = output_place(output, Path("hexcite-demo"), overwrite)
    check_folder(output, DEMO, overwrite=overwrite)
    step(1, "plan: the most informative moves inside the limits, with the time law of LinuxCNC")
    plan = make_plan(Request(case, controller="linuxcnc", seed=seed, starts=starts), output / "plan", quiet, overwrite)
    step(2, f"post: as a program for LinuxCNC, which does not enforce {', '.join(ACCEPTED)}: accepted here by name")
    program = make_program(
        output / "plan", "linuxcnc", 1.0, ACCEPTED, output / "excitation.ngc", quiet, overwrite=overwrite
    )
    step(3, "check: the text read back, independently of its writer")
    check, reason = check_program(output / "excitation.ngc", case, None, quiet)
    if not quiet:
        show_check(check)
    if reason is not None:
        raise reason
    controller, why = best_controller() if on is None else (on, "as asked")
    step(4, f"run: on {controller} ({why})")
    run, outcome = make_recording(
        output / "excitation.ngc", case, controller, seed, output / "recording", quiet, overwrite=overwrite
    )
    step(5, "identify: model 9 from the recording alone")
    result, estimate = make_result(output / "recording", None, 9, output / "result", quiet, overwrite=overwrite)
    rows = truth_rows(loaded, estimate)
    if not quiet:
        _show_truth(rows)
    step(6, "report")
    answer = {"plan": plan, "post": program, "check": check, "run": run, "identify": result, "truth": rows}
    report = output / "report.html"
    found = identifiability(estimate)
    left = residuals_of(estimate)
    write_text(report, render(demo_page(loaded, answer, outcome, estimate, found, left)))
    worst = max(abs(row["error"]) / row["std"] for row in rows)
    summary = {"report": str(report), "controller": run["controller"], "worst_error_in_std": worst}
    if not quiet:
        print(f"largest error: {worst:.2f} reported standard deviations")
        print(f"report written: {report}")
    return summary | answer


def _show_truth(rows: list[dict[str, Any]]) -> None:
    from planner.reports.demo import truth_cells

    print_table(
        "Truth of the simulated machine against the estimate",
        ("parameter", "truth", "estimate", "std", "error", "error/std", "unit"),
        [truth_cells(row) for row in rows],
    )
