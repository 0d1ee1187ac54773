"""Motions of each family at another pace: what time and information it gains or costs, and what it would pass else."""

from cases.schema import Case, load_case
from identification.limit_proof import prove
from identification.model import identification_model
from identification.motion import Trajectory
from planner.cli.console import print_table
from planner.families.manual import manual_motion, sequence_file
from planner.families.settings import Fourier, PointToPoint, Spline
from planner.planning import search
from planner.request import Request
from planner.retiming.retimed import retimed
from planner.search.parallel import run_here, silent

SPLINE = ("ipopt",)
MOVES = ("ruckig", "ipopt")


def motions(case: Case) -> dict[str, tuple[Trajectory, tuple[str, ...]]]:
    """A motion of each family, and the methods that it can be re-timed with."""
    fourier = search(Request(Fourier(), criterion="N", starts=2), case, silent, run_here).motion
    ptp = search(Request(PointToPoint(moves=12), duration=4.0, starts=1), case, silent, run_here).motion
    spline = search(Request(Spline(knots=40), duration=4.0, starts=1), case, silent, run_here).motion
    return {
        "manual, 23 s": (manual_motion(case, sequence_file(case)), MOVES),
        "fourier, order 5, for N": (fourier, SPLINE),
        "ptp, 12 moves": (ptp, MOVES),
        "spline, 40 knots": (spline, SPLINE),
    }


def retiming_table() -> None:
    """Prints both: as fast as every limit allows, criterion D before and after."""
    case = load_case("hexapod")
    model = identification_model(case, 9)
    rows = []
    for name, (motion, methods) in motions(case).items():
        for method in methods:
            found = retimed(motion, case, model, method, fastest=method != "ruckig")
            before, after = found.before, found.after
            passed = ", ".join(f"{c.name.split(' (')[0]} {c.ratio:.2f}" for c in prove(found.motion, case).violations)
            rows.append(
                [
                    name,
                    method,
                    f"{before.duration:.2f} s",
                    f"{after.duration:.2f} s",
                    f"{before.criteria['D']:.2f}",
                    f"{after.criteria['D']:.2f}",
                    f"{before.d_efficiency:.3f}",
                    f"{after.d_efficiency:.3f}",
                    f"{1e3 * found.off_path[0]:.2g} mm",
                    passed or "-",
                ]
            )
    columns = (
        "motion",
        "method",
        "before",
        "after",
        "D before",
        "D after",
        "d_eff",
        "after",
        "off path",
        "passed after",
    )
    print_table("Motions of the hexapod re-timed, as fast as the method allows; model 9", columns, rows)
