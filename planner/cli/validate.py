"""`hexcite validate`: known weights mounted one after the other, identified by each method (section 8, Table 7)."""

import shutil
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, print_json, print_table
from planner.cli.validate_runs import Settings, carry_out, unfinished

if TYPE_CHECKING:
    from cases.schema import Case
    from identification.recording import Recording
    from planner.validation.verdict import Finding


def validate(
    case: Annotated[str, typer.Argument(help="Built-in name, folder or case file, with payloads.")],
    methods: Annotated[
        str | None,
        typer.Option(help="Methods, separated by commas, by default all: Q5M, Q5N, D9M, D9N, ptp, spline."),
    ] = None,
    recordings: Annotated[
        Path | None,
        typer.Option(help="Instead: a real machine's runs, METHOD/0, METHOD/1, .. named after the weights mounted."),
    ] = None,
    weights: Annotated[
        str | None, typer.Option(help="How many weights are mounted: 0,3,5; by default none, and each up to all.")
    ] = None,
    plans: Annotated[
        Path | None, typer.Option(help="Folder of an earlier validation: take its plans instead of new ones.")
    ] = None,
    on: Annotated[str, typer.Option(help="Controller: virtual or linuxcnc.")] = "virtual",
    starts: Annotated[int, typer.Option(help="Random starts of the optimised methods.")] = 2,
    seed: Annotated[int, typer.Option(help="Seed of the starts and of the sensors' noise.")] = 0,
    undisturbed: Annotated[
        bool, typer.Option("--undisturbed", help="Without the disturbances of the simulated structure.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write; hexcite-validation by default.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Identify known weights by each method; compare with theory.

    They are mounted one after the other. Without --recordings the case's simulated machine is used, and the answer says
    what it models. Interrupted, the same command goes on with what is missing.
    """
    settings = Settings(on, starts, seed, plans)
    answer = run_validation(
        case, methods, weights, recordings, settings, undisturbed, output, quiet=json, overwrite=overwrite
    )
    if json:
        print_json(answer)


def run_validation(
    name: str,
    methods: str | None,
    weights: str | None,
    recordings: Path | None,
    settings: Settings,
    undisturbed: bool,
    output: Path | None,
    quiet: bool,
    overwrite: bool = False,
) -> dict[str, Any]:
    """The whole experiment; returns the JSON answer.

    Args:
        name: of the case.
        methods: separated by commas; None: all, or with recordings all that were recorded.
        weights: numbers of weights to mount, separated by commas; None: none, and each up to all.
        recordings: folder of a real machine's runs, or None.
        settings: how methods are carried out.
        undisturbed: simulate an ideal structure.
        output: folder to write.
        quiet: print nothing.
        overwrite: replace an earlier validation.
    """
    from cases.files import VALIDATION, atomic_folder, check_folder, json_text, output_place
    from cases.loading import load_case
    from planner.reports.page import render
    from planner.reports.plots import save_figure
    from planner.reports.validation import std_figure, validation_page
    from planner.validation.experiment import chosen, mounted_weights
    from planner.validation.verdict import findings

    if recordings is not None:
        _only_recordings(weights, settings, undisturbed)
    wanted = chosen(methods) if recordings is None else []
    case = load_case(name)
    if case.payloads is None:
        case.missing("payloads", "a validation with payloads")
    mounted = mounted_weights(case, weights)
    read = [folder for folder in (recordings, settings.plans) if folder is not None]
    output = output_place(output, Path("hexcite-validation"), overwrite)
    check_folder(output, VALIDATION, read, overwrite)
    disturbances = None
    if recordings is None:
        disturbances = _disturbances(case, settings, undisturbed)
    found: list[Any] = []
    columns: dict[int, Any] = {}
    failed: dict[str, str] = {}
    helped: list[Any] = []
    executed: dict[str, str] = {}
    with ExitStack() as kept:
        work = None
        if recordings is not None:
            found = _recorded(case, recordings, methods)
        else:
            work = kept.enter_context(unfinished(output, case, settings, overwrite))
            carried = carry_out(name, case, wanted, mounted, disturbances, settings, work, quiet)
            failed, found = carried.failed, [kept.step for kept in carried.steps]
            executed = {kept.step.method: kept.controller for kept in carried.steps}
            columns = {number: one for step in found for number, one in step.columns.items()}
            helped = [kept.remedy for kept in carried.steps if kept.remedy is not None]
        verdict = findings(case, found, columns)
        answer = _answer(case, found, verdict, columns, disturbances, recordings, settings, failed)
        answer |= {"executed": executed, "remedies": [remedy.to_json() for remedy in helped]}
        page = validation_page(case, found, verdict, columns, answer["machine"], failed, helped)
        with atomic_folder(output, VALIDATION, overwrite) as part:
            if work is not None:
                shutil.copytree(work / "plans", part / "plans")
                shutil.copytree(work / "programs", part / "programs")
            (part / "report.html").write_text(render(page), encoding="utf-8")
            (part / "validation.json").write_text(json_text(answer), encoding="utf-8")
            save_figure(std_figure(found), part / "plots", "standard_deviations")
    answer = {"report": str(output / "report.html")} | answer
    if not quiet:
        _show(answer, found, verdict, helped)
    return answer


def _disturbances(case: "Case", settings: Settings, undisturbed: bool) -> Any:
    """What disturbs the simulated machine; refused where it cannot be run."""
    from planner.runs.running import require_controller

    require_controller(settings.on)
    found = case.need_simulation("a validation without recordings").disturbances
    if found is None and not undisturbed:
        case.missing("simulation.disturbances", "a validation (or --undisturbed)")
    return None if undisturbed else found


def _only_recordings(weights: str | None, settings: Settings, undisturbed: bool) -> None:
    """Refuses what says how to simulate beside recordings of a machine."""
    from cases.errors import HexciteError

    given = {
        "--weights": weights is not None,
        "--plans": settings.plans is not None,
        "--on": settings.on != "virtual",
        "--undisturbed": undisturbed,
    }
    for option in (name for name, wanted in given.items() if wanted):
        raise HexciteError(f"{option}: nothing is simulated with --recordings; leave out one of both")


def _recorded(case: "Case", recordings: Path, methods: str | None) -> list[Any]:
    """Steps of a real machine's recordings, a folder a method, of all or of some."""
    from cases.errors import HexciteError
    from identification.recording import read_recording
    from identification.runs.rates import on_one_clock
    from planner.runs.recorded import standing_of
    from planner.validation.experiment import recorded_steps

    folders = sorted(p for p in recordings.iterdir() if p.is_dir()) if recordings.is_dir() else []
    if not folders:
        raise HexciteError(f"{recordings}: holds no folder of runs; name the folder that holds one for each method")
    if methods is not None:
        named = [name.strip() for name in methods.split(",")]
        for name in named:
            if name not in (folder.name for folder in folders):
                there = ", ".join(folder.name for folder in folders)
                raise HexciteError(f"method {name!r}: {recordings} holds no folder of that name, but {there}")
        folders = [folder for folder in folders if folder.name in named]

    def read(file: Path) -> "Recording":
        return standing_of(on_one_clock(read_recording(file, case), case), case, file)[0]

    return [step for folder in folders for step in recorded_steps(case, folder, read)]


def _answer(
    case: "Case",
    found: list[Any],
    verdict: "list[Finding]",
    columns: dict[int, Any],
    disturbances: Any,
    recordings: Path | None,
    settings: Settings,
    failed: dict[str, str],
) -> dict[str, Any]:
    from planner.validation.verdict import to_json

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
        where = "LinuxCNC" if settings.on == "linuxcnc" else "the built-in virtual controller"
        machine += f"; programs executed on {where}"
        if settings.on == "linuxcnc":
            machine += ", which limits no jerk: its steps of acceleration make the structure vibrate"
    return {
        "case": case.name,
        "case_hash": case.hash,
        "machine": machine,
        "simulated": recordings is None,
        "controller": None if recordings is not None else settings.on,
        "disturbances": None if disturbances is None else disturbances.model_dump(),
        "not_run": failed,
        "rows": [step.to_json() for step in found],
        "findings": to_json(verdict),
        "models": {str(n): {k: v._asdict() for k, v in e.physical.items()} for n, e in columns.items()},
    }


def _show(answer: dict[str, Any], found: list[Any], verdict: "list[Finding]", helped: list[Any]) -> None:
    from planner.reports.validation import TABLE_7, table_7
    from planner.validation.remedy import REMEDY_COLUMNS
    from planner.validation.verdict import OFF_COLUMNS, off_rows

    print(f"machine: {answer['machine']}")
    for method, told in answer["executed"].items():
        if ";" in told:
            print(f"{method}: executed on {told}")
    for method, why in answer["not_run"].items():
        print(f"NOT RUN: {method}: {why}")
    for method in dict.fromkeys(s.method for s in found):
        print_table(f"{method}", TABLE_7, table_7([s for s in found if s.method == method]))
    if rows := off_rows(found):
        title = "Off by more than 3 reported standard deviations; parts of the error in these"
        print_table(title, OFF_COLUMNS, rows)
    if rows := [row for remedy in helped for row in remedy.rows()]:
        print_table("The same recordings with the mode estimated too (identify --flexible)", REMEDY_COLUMNS, rows)
    for finding in verdict:
        print(finding.sentence())
    print(f"report written: {answer['report']}")
