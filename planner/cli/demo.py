"""`hexcite demo`: the whole chain on one case, from its description to a report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, print_json, print_table

if TYPE_CHECKING:
    from identification.outcome import Result


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
    from cases.files import DEMO, check_folder, output_place, write_text
    from cases.loading import load_case
    from planner.cli.identified import answer_of_result, show_result
    from planner.cli.plan import answer_of_plan, show_plan
    from planner.cli.post import answer_of_program, answer_of_proof, show_check, show_program
    from planner.cli.run import answer_of_run, show_run
    from planner.demo import ACCEPTED
    from planner.demo import demo as whole_chain
    from planner.plan import Plan
    from planner.reports.demo import demo_page
    from planner.reports.page import render
    from planner.reports.report import report
    from planner.runs.running import Outcome, best_controller
    from postprocessors.files import Program

    loaded = load_case(case)
    place = output_place(output, Path("hexcite-demo"), overwrite)
    check_folder(place, DEMO, overwrite=overwrite)
    answer: dict[str, Any] = {}

    def step(text: str) -> None:
        if not json:
            print(f"\n[{len(answer) + 1}/6] {text}", flush=True)

    def done(value: "Plan | Program | Outcome | Result") -> None:
        if isinstance(value, Plan):
            answer["plan"] = answer_of_plan(value, place / "plan")
            report(value, place / "plan" / "report.html")
            if not json:
                show_plan(answer["plan"], value)
            step(f"post: for LinuxCNC, which does not enforce {', '.join(ACCEPTED)}: accepted here by name")
        elif isinstance(value, Program):
            answer["post"] = answer_of_program(value)
            if not json:
                show_program(answer["post"])
            step("check: the text read back, independently of its writer")
            answer["check"] = answer_of_proof(value)
            if not json:
                show_check(answer["check"])
            step(f"run: on {on or best_controller()[0]} ({'as asked' if on else best_controller()[1]})")
        elif isinstance(value, Outcome):
            answer["run"] = answer_of_run(value, place / "recording")
            if not json:
                show_run(answer["run"], value)
            step("identify: model 9 from the recording alone")
        else:
            answer["identify"] = answer_of_result(value, place / "result")
            report(value, place / "result" / "report.html")
            if not json:
                show_result(answer["identify"])

    step("plan: the most informative moves inside the limits, with the time law of LinuxCNC")
    chain = whole_chain(loaded, place, on, seed=seed, starts=starts, done=done)
    answer["truth"] = list(chain.truth)
    if not json:
        _show_truth(answer["truth"])
    file = place / "report.html"
    write_text(file, render(demo_page(chain, answer)))
    summary = {"report": str(file), "controller": answer["run"]["controller"], "worst_error_in_std": chain.worst}
    if json:
        print_json(summary | answer)
        return
    print(f"largest error: {chain.worst:.2f} reported standard deviations")
    print(f"report written: {file}")


def _show_truth(rows: list[dict[str, Any]]) -> None:
    from planner.reports.demo import truth_cells

    print_table(
        "Truth of the simulated machine against the estimate",
        ("parameter", "truth", "estimate", "std", "error", "error/std", "unit"),
        [truth_cells(row) for row in rows],
    )
