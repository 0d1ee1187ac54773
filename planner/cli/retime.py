"""`hexcite retime`: the pace at which a controller, or the limits of the machine, let a motion run."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from planner.cli.console import LIMIT_COLUMNS, Json, Overwrite, Stale, limit_rows, print_json, print_table, status_text

if TYPE_CHECKING:
    from cases.schema import Case
    from identification.motion import Trajectory
    from planner.request import Request
    from planner.retiming.retimed import PaceRating


def retime(
    source: Annotated[Path, typer.Argument(help="Plan folder, or a table of poses over time as motion.csv.")],
    case: Annotated[str | None, typer.Option(help="Built-in name, folder or case file; a plan knows its own.")] = None,
    method: Annotated[
        str | None,
        typer.Option(
            help="ruckig: moves as a jerk-limited controller times them; ipopt: paths under every limit; toppra: paths "
            "under every limit but that of jerk. By default what fits."
        ),
    ] = None,
    fastest: Annotated[
        bool, typer.Option("--fastest", help="ipopt, toppra: as fast as the limits allow, not only as slow as needed.")
    ] = False,
    model: Annotated[int | None, typer.Option(help="Identification model; a plan's own by default, else 9.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Plan folder of the re-timed motion; or NAME.csv for its table at 1 kHz."),
    ] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Make a plan of the same path at another pace.

    Tells criteria and limits before and after; without -o nothing is written.
    """
    answer = make_retimed(source, case, method, fastest, model, output, quiet=json, overwrite=overwrite, stale=stale)
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
    overwrite: bool = False,
    stale: bool = False,
) -> dict[str, Any]:
    """Re-times, writes, prints unless `quiet`; returns the JSON answer."""
    from time import perf_counter

    from cases.errors import HexciteError
    from cases.files import PLAN, write_text
    from cases.units import DEG, MM
    from identification.model import identification_model
    from identification.motion import sample
    from planner.cli.console import save_with_page
    from planner.plans import SAMPLE_RATE, motion_csv
    from planner.retiming.retimed import RetimingMethod, retimed
    from planner.retiming.retimed_plan import method_of, retimed_plan

    table = _checked(source, output, overwrite)
    given = _given(source, case, model, stale)
    chosen = method_of(method, given.motion, fastest)
    if output is not None and not table and chosen is RetimingMethod.TOPPRA:
        raise HexciteError(
            f"{output}: toppra's accelerations step, without limit of jerk, and make no plan; use --method ipopt, or "
            "name a table (-o after.csv)"
        )
    began = perf_counter()
    with status_text(f"re-timing with {chosen}", quiet) as told:
        wanted = identification_model(given.case, given.request.model)
        found = retimed(given.motion, given.case, wanted, chosen, fastest, told)
        seconds = perf_counter() - began
        if output is not None and table:
            write_text(output, motion_csv(sample(found.motion, SAMPLE_RATE), given.case))
        elif output is not None:
            told("writing")
            made = retimed_plan(found, given.request, given.case, source, seconds, given.stale)
            save_with_page(made, PLAN, output, overwrite, plots=False)
    answer = {
        "source": str(source),
        "method": str(found.method),
        "model": given.request.model,
        "before": _rating(found.before),
        "after": _rating(found.after),
        "jerk_limited": found.method is not RetimingMethod.TOPPRA,
        "off_path_mm": found.off_path[0] / MM,
        "off_path_deg": found.off_path[1] / DEG,
        "remarks": [*found.remarks, *given.stale],
        "solve_s": seconds,
        "output": str(output) if output is not None else None,
        "plan": str(output) if output is not None and not table else None,
    }
    if not quiet:
        _show(answer)
    return answer


class _Given(NamedTuple):
    """What is to be re-timed, and for whom."""

    motion: "Trajectory"
    case: "Case"
    request: "Request"
    stale: tuple[str, ...] = ()


def _checked(source: Path, output: Path | None, overwrite: bool) -> bool:
    """Whether a table is to be written; refuses a place that cannot be written before the work starts."""
    from cases.files import PLAN, check_file, check_folder

    if output is None:
        return False
    inputs = [source, *source.glob("*")] if source.is_dir() else [source]
    if output.suffix and not output.is_dir():
        check_file(output, [".csv"], inputs, overwrite)
        return True
    check_folder(output, PLAN, [source], overwrite)
    return False


def _given(source: Path, case: str | None, model: int | None, stale: bool) -> _Given:
    from cases.errors import HexciteError
    from cases.loading import load_case
    from planner.families.settings import Manual
    from planner.plans import Plan
    from planner.request import Request
    from planner.retiming.retimed_plan import read_motion

    if not source.exists():
        raise HexciteError(
            f"{source}: cannot be read (No such file or directory); name a plan folder, or a table of poses"
        )
    if source.is_dir():
        plan = Plan.load(source, None if case is None else load_case(case), stale)
        if len(plan.poses):
            raise HexciteError(f"{source}: is a plan of poses; its moves are as fast as the limits allow already")
        number = plan.model if model is None else model
        request = replace(plan.of_motion[0], model=number, targets=())
        return _Given(plan.motion, plan.case, request, plan.stale)
    if case is None:
        raise HexciteError(f"{source}: a table does not know its machine; name it with --case")
    request = Request(Manual(), model=9 if model is None else model)
    return _Given(read_motion(source), load_case(case), request)


def _rating(rating: "PaceRating") -> dict[str, Any]:
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
    rows.append(["limits exceeded", str(len(before["violations"])), str(len(after["violations"]))])
    print_table(f"Re-timed with {answer['method']}, model {answer['model']}", ("", "before", "after"), rows)
    for when, rating in (("before", before), ("after", after)):
        for sentence in rating["violations"]:
            print(f"{when}: {sentence}")
    print_table("Limits after re-timing", LIMIT_COLUMNS, limit_rows(after["limits"]))
    for remark in answer["remarks"]:
        print(f"note: {remark}")
    if answer["off_path_mm"] or answer["off_path_deg"]:
        print(f"up to {answer['off_path_mm']:.2g} mm and {answer['off_path_deg']:.2g} deg from the planned path")
    if answer["output"] is not None:
        print(f"{'motion' if answer['plan'] is None else 'plan'} written: {answer['output']}")
