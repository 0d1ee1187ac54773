"""`hexcite plan`: optimises an excitation and writes a plan folder."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import LIMIT_COLUMNS, Json, limit_rows, print_json, print_table, progress, status

Out = Annotated[Path | None, typer.Option("-o", "--output", help="Folder to write; named after the case by default.")]


def plan(
    case: Annotated[str, typer.Argument(help="Built-in name, folder or case file.")],
    family: Annotated[str, typer.Option(help="Family of motions: fourier.")] = "fourier",
    criterion: Annotated[str, typer.Option(help="What to optimise: D.")] = "D",
    order: Annotated[int, typer.Option(help="Harmonics of the Fourier series.")] = 5,
    period: Annotated[float, typer.Option(help="Period of the Fourier series in s.")] = 3.0,
    duration: Annotated[float, typer.Option(help="Whole duration in s, a multiple of the period.")] = 12.0,
    model: Annotated[int, typer.Option(help="Identification model, 0 to 9.")] = 9,
    starts: Annotated[int, typer.Option(help="Random starts.")] = 8,
    seed: Annotated[int, typer.Option(help="Seed of the random starts.")] = 0,
    output: Out = None,
    json: Json = False,
) -> None:
    """Find the most informative motion inside the machine's limits."""
    from cases.errors import HexciteError
    from planner.planning import Request

    if family != "fourier":
        raise HexciteError(f"family {family!r} is not available; choose fourier")
    request = Request(case, criterion, order, period, duration, model, starts, seed)
    answer = make_plan(request, output, quiet=json)
    if json:
        print_json(answer)


def make_plan(request: Any, output: Path | None, quiet: bool) -> dict[str, Any]:
    """Plans, saves, prints unless `quiet`; returns the JSON answer."""
    from cases.loading import find_case, load_case
    from planner.plan import save_plan
    from planner.planning import plan_fourier
    from planner.solving import REFINED, Start

    loaded = load_case(request.case_file)
    loaded.need_machine("planning")
    folder = output if output is not None else Path(f"{loaded.name}-fourier")
    case_file = request.case_file
    if find_case(case_file).is_relative_to(Path.cwd()) or Path(case_file).exists():
        case_file = str(find_case(case_file).resolve())  # found again from any folder
    total = request.starts + min(REFINED, request.starts)
    best = -float("inf")
    if not quiet:
        print(
            f"Planning for {loaded.name}: order {request.order}, {request.duration:g} s, model {request.model}, D",
            flush=True,
        )
    with progress("optimising", total, quiet) as count:

        def done(start: Start) -> None:
            nonlocal best
            best = max(best, start.objective)
            count(f"best log det {best:.2f}")

        result = plan_fourier(request, loaded, case_file, done)
    with status("writing", quiet):
        save_plan(result, folder)
    answer = {"plan": str(folder)} | result.to_json()
    if not quiet:
        _show(answer)
    return answer


def _show(answer: dict[str, Any]) -> None:
    rows = [
        [str(s["seed"]), s["stage"], f"{s['start_logdet']:.3f}", f"{s['logdet']:.3f}", str(s["iterations"]),
         f"{s['seconds']:.1f} s", s["solver"].replace("_", " ").lower()]
        for s in answer["starts"]
    ]  # fmt: skip
    print_table("Starts, best first (log det of the mean information, reference scaling)",
                ("seed", "stage", "at start", "at end", "iterations", "time", "solver"), rows)  # fmt: skip
    print_table("Limits, proven at 10 kHz in NumPy", LIMIT_COLUMNS, limit_rows(answer["limits"]))
    kind = "certified" if answer["bound"]["certified"] else "an estimate"
    print(f"D-efficiency {answer['d_efficiency']:.3f} against the box bound ({kind})")
    print(f"condition {answer['condition']:.3g} in reference scaling, found in {answer['solve_s']:.1f} s")
    print(f"plan written: {answer['plan']}")
