"""`hexcite retime`: the pace at which a controller, or the limits of the struts, let a motion run."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import LIMIT_COLUMNS, Json, limit_rows, print_json, print_table, status

if TYPE_CHECKING:
    from planner.retiming import Rating


def retime(
    source: Annotated[Path, typer.Argument(help="Plan folder, or a table of poses over time as motion.csv.")],
    case: Annotated[str | None, typer.Option(help="Built-in name, folder or case file; a plan knows its own.")] = None,
    method: Annotated[
        str | None,
        typer.Option(help="ruckig: moves as a jerk-limited controller times them; toppra: paths under strut limits."),
    ] = None,
    fastest: Annotated[bool, typer.Option("--fastest", help="toppra: as fast as the limits allow.")] = False,
    model: Annotated[int | None, typer.Option(help="Identification model; a plan's own by default, else 9.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Table of the re-timed motion, 1 kHz.")] = None,
    json: Json = False,
) -> None:
    """Re-time a motion; tell criteria and limits before and after."""
    answer = make_retimed(source, case, method, fastest, model, output, quiet=json)
    if json:
        print_json(answer)


def make_retimed(
    source: Path,
    case: str | None,
    method: str | None,
    fastest: bool,
    model: int | None,
    output: Path | None,
    quiet: bool,
) -> dict[str, Any]:
    """Re-times, writes, prints unless `quiet`; returns the JSON answer."""
    from cases.errors import HexciteError
    from cases.files import check_file, write_text
    from cases.loading import load_case
    from identification.model import identification_model
    from identification.motion import Trajectory, sample
    from planner.plan import SAMPLE_RATE, load_plan, motion_csv
    from planner.retiming import Method, fitting_method, read_motion, retimed

    if method is not None and method not in list(Method):
        raise HexciteError(f"method {method!r} is unknown; choose {' or '.join(Method)}")
    if output is not None:
        check_file(output, [".csv"], [source, *source.glob("*")] if source.is_dir() else [source])
    motion: Trajectory
    if source.is_dir():
        saved = load_plan(source)
        loaded = saved.case if case is None else load_case(case)
        if saved.data["family"] == "poses":
            raise HexciteError(f"{source}: is a plan of poses; its moves are as fast as the limits allow already")
        motion, number = saved.motion, int(saved.data["model"])
    else:
        if case is None:
            raise HexciteError(f"{source}: a table does not know its machine; name it with --case")
        loaded, motion, number = load_case(case), read_motion(source), 9
    chosen = Method(method) if method is not None else fitting_method(motion)
    if fastest and chosen is not Method.TOPPRA:
        raise HexciteError("--fastest belongs to --method toppra; a controller's moves are as fast as its limits allow")
    number = number if model is None else model
    with status(f"re-timing with {chosen}", quiet):
        found = retimed(motion, loaded, identification_model(loaded, number), chosen, fastest)
    if output is not None:
        write_text(output, motion_csv(sample(found.motion, SAMPLE_RATE)))
    answer = {
        "source": str(source),
        "method": str(found.method),
        "model": number,
        "before": _rating(found.before),
        "after": _rating(found.after),
        "jerk_limited": found.method is Method.RUCKIG,
        "output": str(output) if output is not None else None,
    }
    if not quiet:
        _show(answer)
    return answer


def _rating(rating: "Rating") -> dict[str, Any]:
    return {
        "duration_s": rating.duration,
        "criteria": rating.criteria,
        "d_efficiency": rating.d_efficiency,
        "violations": [check.sentence() for check in rating.limits.violations],
        "limits": rating.limits.to_json(),
    }


def _show(answer: dict[str, Any]) -> None:
    before, after = answer["before"], answer["after"]
    rows = [["duration", f"{before['duration_s']:.4f} s", f"{after['duration_s']:.4f} s"]]
    rows += [[f"criterion {k}", f"{before['criteria'][k]:.5g}", f"{after['criteria'][k]:.5g}"] for k in "ADKN"]
    rows.append(["D-efficiency against the box", f"{before['d_efficiency']:.4f}", f"{after['d_efficiency']:.4f}"])
    rows.append(["limits passed", str(len(before["violations"])), str(len(after["violations"]))])
    print_table(f"Re-timed with {answer['method']}, model {answer['model']}", ("", "before", "after"), rows)
    for when, rating in (("before", before), ("after", after)):
        for sentence in rating["violations"]:
            print(f"{when}: {sentence}")
    print_table("Limits after re-timing", LIMIT_COLUMNS, limit_rows(after["limits"]))
    if not answer["jerk_limited"]:
        print(
            "toppra knows no jerk limit: accelerations step, and the jerk there has no bound; the table shows a slope"
        )
    if answer["output"] is not None:
        print(f"motion written: {answer['output']}")
