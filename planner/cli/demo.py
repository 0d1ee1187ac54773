"""`hexcite demo`: the whole chain on one case, from its description to a report."""

from pathlib import Path
from typing import Annotated, Any

import hexcite as hx
from cases.files import DEMO, check_folder, output_place, write_text
from planner.cli.console import Json, Overwrite, answered, option, out, print_table


def demo(
    case: Annotated[str, option("Built-in name, folder or case file, with a simulated machine.")] = "hexapod",
    on: Annotated[str | None, option("Controller: virtual or linuxcnc; by default LinuxCNC if installed.")] = None,
    seed: Annotated[int, option("Seed of the starts and of the sensors' noise.")] = 0,
    starts: Annotated[int, option("Number of random starts; one is enough for a demo.")] = 1,
    output: Annotated[Path | None, out("Folder for everything; hexcite-demo by default.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Plan, program, prove, execute, identify and report, end to end."""
    from cases.controller import ControllerName
    from identification.model import full_model
    from planner.cli.identification import answer_of_result
    from planner.cli.plan import answer_of_plan
    from planner.cli.programs import answer_of_program, answer_of_proof, answer_of_run
    from planner.demonstration import accepted
    from planner.execution import best_controller
    from planner.plan_program import usual_dialect
    from planner.reports.demo import demo_page, truth_cells
    from postprocessors.dialects import dialect as dialect_named

    loaded = hx.load_case(case)
    place = output_place(output, Path("hexcite-demo"), overwrite)
    check_folder(place, DEMO, overwrite=overwrite)
    loaded.need_simulation("the demo")  # before anything is said
    answer: dict[str, Any] = {}
    dialect = dialect_named(usual_dialect(loaded))
    table, controller = dialect.name == ControllerName.SETPOINTS, dialect.description.partition(":")[0]

    def say(line: str) -> None:
        if not json:
            print(line, flush=True)

    def step(text: str) -> None:
        say(f"[{len(answer) + 1}/6] {text}")

    def done(value: "hx.Plan | hx.Program | hx.Recording | hx.Result") -> None:
        if isinstance(value, hx.Plan):
            plan = answer["plan"] = answer_of_plan(value, place / "plan")
            hx.report(value, place / "plan" / "report.html")
            kind = f"{plan['settings']['moves']} moves" if "moves" in plan["settings"] else "a spline"
            moves = f"{kind}, {plan['duration_s']:.3g} s"
            bound = "certified" if plan["bound"]["certified"] else "estimated"
            line = f"{moves}, D-efficiency {plan['d_efficiency']:.3f} against the {bound} bound, "
            line += f"found in {plan['solve_s']:.0f} s"
            say(f"      {line}")
            own = f"for {controller}; what it does not enforce of {', '.join(accepted(value))} is accepted here by name"
            step(f"post: {'a table of set points, one row a cycle' if table else own}")
        elif isinstance(value, hx.Program):
            written = answer["post"] = answer_of_program(value)
            unit = "rows" if table else "blocks"
            line = f"{written['blocks']} {unit}, {written['duration_s']:.2f} s with the way to the first pose and home"
            say(f"      {line}")
            step("check: the text read back, independently of its writer")
            checked = answer["check"] = answer_of_proof(value)
            say(f"      {checked['verdict']}")
            name, reason = (on, "as asked") if on else best_controller(dialect.name)
            step(f"run: on {name} ({reason})")
        elif isinstance(value, hx.Recording):
            run = answer["run"] = answer_of_run(value, place / "recording")
            line = f"{run['controller']}: {run['duration_s']:.3f} s of {run['planned_s']:.3f} s planned, "
            line += f"{run['path_error_mm']:.3f} mm from the path, D-efficiency {run['d_efficiency']:.3f} as executed"
            say(f"      {line}")
            step(f"identify: model {full_model(loaded)} from the recording alone")
        else:
            data = answer["identify"] = answer_of_result(value, place / "result")
            hx.report(value, place / "result" / "report.html")
            line = f"{len(data['parameters'])} parameters from {data['samples']} samples, residuals {data['s0']:.3g} N"
            say(f"      {line}")

    law = " of limited jerk" if table else f" of {controller}"
    step(f"plan: the most informative moves inside the limits, with the time law{law}")
    chain = hx.demo(loaded, place, on, seed=seed, starts=starts, done=done)
    step("compare with the truth of the simulated machine")
    answer["truth"] = list(chain.truth)
    if not json:
        cells = [truth_cells(row) for row in chain.truth]
        print_table(
            "Identified, beside the truth",
            ("parameter", "identified", "+-", "unit", "truth", "error / +-"),
            [(name, estimate, std, unit, truth, ratio) for name, truth, estimate, std, _, ratio, unit in cells],
        )
    file = place / "report.html"
    write_text(file, demo_page(chain, answer))
    summary = {"report": str(file), "controller": answer["run"]["controller"], "worst_error_in_std": chain.worst}
    if answered(summary | answer, json):
        return
    print(f"largest error: {chain.worst:.2f} reported standard deviations")
    print(f"report written: {file}")
