"""`hexcite validate`: known weights mounted one after the other, identified by each method (section 8, Table 7)."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import Json, print_json, print_table, progress

if TYPE_CHECKING:
    from cases.schema import Case
    from planner.validation import Excitation

# LinuxCNC has no limits for these, and no metal moves: the machine is simulated. Programs for the virtual controller
# are SINUMERIK's, whose point-to-point moves limit jerk as the paper's machine does.
ACCEPTED = ("acceleration", "jerk", "strut acceleration")


def validate(
    case: Annotated[str, typer.Argument(help="Built-in name, folder or case file, with payloads.")],
    methods: Annotated[
        str, typer.Option(help="Methods, separated by commas: Q5M, Q5N, D9M, D9N, ptp, spline.")
    ] = "Q5M,Q5N,D9M,D9N,ptp,spline",
    recordings: Annotated[
        Path | None,
        typer.Option(help="Instead: a real machine's runs, METHOD/0, METHOD/1, .. named after the weights mounted."),
    ] = None,
    on: Annotated[str, typer.Option(help="Controller: virtual or linuxcnc.")] = "virtual",
    starts: Annotated[int, typer.Option(help="Random starts of the optimised methods.")] = 2,
    seed: Annotated[int, typer.Option(help="Seed of the starts and of the sensors' noise.")] = 0,
    undisturbed: Annotated[
        bool, typer.Option("--undisturbed", help="Without the disturbances of the simulated structure.")
    ] = False,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write.")] = Path("hexcite-validation"),
    json: Json = False,
) -> None:
    """Mount known weights, identify them by each method, and compare with theory.

    Without --recordings the case's simulated machine is used, and the answer says what it models.
    """
    answer = run_validation(case, methods, recordings, (on, starts, seed), undisturbed, output, quiet=json)
    if json:
        print_json(answer)


def run_validation(
    name: str,
    methods: str,
    recordings: Path | None,
    settings: tuple[str, int, int],
    undisturbed: bool,
    output: Path,
    quiet: bool,
) -> dict[str, Any]:
    """The whole experiment; returns the JSON answer.

    Args:
        name: of the case.
        methods: separated by commas.
        recordings: folder of a real machine's runs, or None.
        settings: controller, starts and seed.
        undisturbed: simulate an ideal structure.
        output: folder to write.
        quiet: print nothing.
    """
    from cases.errors import HexciteError
    from cases.files import VALIDATION, atomic_folder, check_folder, json_text
    from cases.loading import load_case
    from planner.plots import save_figure
    from planner.report import render
    from planner.report_validation import std_figure, validation_page
    from planner.running import require_controller
    from planner.validation import causes, chosen, models, recorded_steps, steps

    wanted = chosen(methods)
    case = load_case(name)
    if case.payloads is None:
        case.missing("payloads", "a validation with payloads")
    check_folder(output, VALIDATION, [] if recordings is None else [recordings])
    folders = []
    if recordings is not None:
        folders = sorted(p for p in recordings.iterdir() if p.is_dir()) if recordings.is_dir() else []
        if not folders:
            raise HexciteError(f"{recordings}: holds no folder of runs; name the folder that holds one for each method")
    else:
        require_controller(settings[0])
        if case.need_simulation("a validation without recordings").disturbances is None and not undisturbed:
            case.missing("simulation.disturbances", "a validation (or --undisturbed)")
    disturbances = None if undisturbed or recordings is not None else case.need_simulation("").disturbances
    found: list[Any] = []
    why: list[Any] = []
    columns: dict[int, Any] = {}
    with atomic_folder(output, VALIDATION) as part:
        if recordings is not None:
            for folder in folders:
                found += recorded_steps(case, folder)
        else:
            with progress("planning", len(wanted), quiet) as count:
                excitations = []
                for method in wanted:
                    excitations.append(_excitation(name, case, method, settings, part))
                    count(method)
            total = len(excitations) * (len(case.payloads.weights) + 1)
            with progress("identifying", total, quiet) as count:
                for excitation in excitations:
                    for step in steps(case, excitation, disturbances):
                        found.append(step)
                        count(f"{step.method} {step.load:.0f} kg")
                    if disturbances is not None:
                        own = [s for s in found if s.method == excitation.name]
                        why += causes(case, excitation, own, disturbances)
                    if excitation.name == "D9M":
                        columns = models(case, excitation, disturbances)
        answer = _answer(case, found, why, columns, disturbances, recordings)
        page = validation_page(case, found, why, columns, answer["machine"])
        (part / "report.html").write_text(render(page), encoding="utf-8")
        (part / "validation.json").write_text(json_text(answer), encoding="utf-8")
        save_figure(std_figure(found), part / "plots", "standard_deviations")
    answer = {"report": str(output / "report.html")} | answer
    if not quiet:
        _show(answer, found, why)
    return answer


def _excitation(name: str, case: "Case", method: str, settings: tuple[str, int, int], folder: Path) -> "Excitation":
    """Plans a method and carries it out: a motion as a proven program on the controller, poses as they are planned."""
    import numpy as np

    from identification.motion import Joined, Measurement
    from planner.cli.plan import make_plan
    from planner.cli.poses import make_poses
    from planner.cli.post import make_program
    from planner.plan import load_plan
    from planner.poses.request import Method, PoseRequest
    from planner.request import Request
    from planner.running import execute
    from planner.validation import METHODS, dynamic, static

    on, starts, seed = settings
    plan = folder / "plans" / method
    if method in ("Q5M", "Q5N"):
        request = (
            PoseRequest(name, method=Method.ALL)
            if method == "Q5M"
            else PoseRequest(name, criterion="N", count=30, method=Method.BACKWARD)
        )
        make_poses(request, plan, quiet=True)
        motion = load_plan(plan).motion
        assert isinstance(motion, Joined)
        poses = [part.pose for part in motion.parts if isinstance(part, Measurement)]
        return static(case, method, METHODS[method], motion.duration, np.array(poses), seed)
    requests = {
        "D9M": Request(name, family="manual"),
        "D9N": Request(name, criterion="N", order=3, period=4.0, starts=starts, seed=seed),
        "ptp": Request(name, family="ptp", starts=starts, seed=seed),
        "spline": Request(name, family="spline", starts=starts, seed=seed),
    }
    make_plan(requests[method], plan, quiet=True)
    dialect, suffix, accepted = ("linuxcnc", "ngc", ACCEPTED) if on == "linuxcnc" else ("sinumerik", "mpf", ())
    program = folder / "programs" / f"{method}.{suffix}"
    make_program(plan, dialect, 1.0, accepted, program, quiet=True)
    outcome = execute(program, case, on, seed)
    run = (outcome.run.execution, outcome.run.trigger)
    return dynamic(case, method, METHODS[method], outcome.run.excitation, run, seed)


def _answer(
    case: "Case", found: list[Any], why: list[Any], columns: dict[int, Any], disturbances: Any, recordings: Path | None
) -> dict[str, Any]:
    simulation = case.simulation
    if recordings is not None:
        machine = f"recordings of a machine in {recordings}"
    else:
        assert simulation is not None
        machine = f"a simulated machine ({simulation.source})"
        if disturbances is not None:
            machine += (
                f", with a structural mode at {disturbances.mode_Hz:g} Hz that falls with the load, ripple of the "
                f"struts and force errors that depend on the pose ({disturbances.source})"
            )
    return {
        "case": case.name,
        "case_hash": case.hash,
        "machine": machine,
        "simulated": recordings is None,
        "disturbances": None if disturbances is None else disturbances.model_dump(),
        "rows": [step.to_json() for step in found],
        "causes": [cause.to_json() for cause in why],
        "models": {str(n): {k: v._asdict() for k, v in e.physical.items()} for n, e in columns.items()},
    }


def _show(answer: dict[str, Any], found: list[Any], why: list[Any]) -> None:
    from planner.report_validation import TABLE_7, table_7

    print(f"machine: {answer['machine']}")
    for method in dict.fromkeys(s.method for s in found):
        print_table(f"{method}", TABLE_7, table_7([s for s in found if s.method == method]))
    for cause in why:
        print(cause.sentence())
    print(f"report written: {answer['report']}")
