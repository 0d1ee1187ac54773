"""`hexcite post` and `hexcite check`: programs out, and programs back in."""

from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import LIMIT_COLUMNS, Json, Overwrite, Stale, limit_rows, print_json, print_table, status

SLOWEST = 0.01  # share of the planned speed; slower, a run of seconds takes half an hour


Accept = Annotated[
    list[str] | None,
    typer.Option(help="A limit that the controller does not enforce and that you answer for, as in: --accept jerk."),
]


def post(
    plan: Annotated[Path | None, typer.Argument(help="Plan folder.")] = None,
    dialect: Annotated[
        str | None,
        typer.Option(
            help="The controller's language; by default that of the controller that the plan was made for, else "
            "linuxcnc; without a plan, all are listed."
        ),
    ] = None,
    speed: Annotated[float, typer.Option(help="Share of the planned speed, for a first try.")] = 1.0,
    accept: Accept = None,
    ptp_struts: Annotated[
        bool,
        typer.Option("--ptp-struts", help="Moves straight in the struts (PTP, #PTP ON): another path than planned."),
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Program to write; by default the plan's name.")
    ] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a plan as a program for the machine's controller.

    It is read back and proven before it is written.
    """
    from postprocessors.dialects import DIALECTS

    if plan is None:
        rows = [[d.name, " ".join(d.suffixes), d.description] for d in DIALECTS.values()]
        if json:
            print_json({"dialects": [d.name for d in DIALECTS.values()]})
        else:
            print_table("Dialects", ("name", "files", "controller"), rows, right=False)
        return
    answer = make_program(plan, dialect, speed, accept or (), output, json, ptp_struts, overwrite, stale)
    if json:
        print_json(answer)


def make_program(
    plan: Path,
    dialect_name: str | None,
    speed: float,
    accepted: Collection[str],
    output: Path | None,
    quiet: bool,
    in_struts: bool = False,
    overwrite: bool = False,
    stale: bool = False,
) -> dict[str, Any]:
    """Writes, prints unless `quiet`; returns the JSON answer."""
    from importlib.metadata import version

    from cases.errors import HexciteError
    from cases.files import atomic_file, check_file, output_place
    from planner.controlled import fits_law, usual_dialect
    from planner.runs.fingerprints import case_line, plan_line
    from planner.saved_plan import load_plan
    from postprocessors.dialects import DIALECTS, dialect
    from postprocessors.files import ProgramFile
    from postprocessors.writing import proven_program

    if not SLOWEST <= speed <= 1.0:
        raise HexciteError(f"speed {speed:g} is outside {SLOWEST:g} to 1; choose 0.1 for a first try")
    saved = None
    if dialect_name is None:
        saved = load_plan(plan, stale=stale)
        dialect_name = usual_dialect(saved.data)
    language = dialect(dialect_name)
    if in_struts and not language.in_struts:
        able = ", ".join(d.name for d in DIALECTS.values() if d.in_struts)
        raise HexciteError(f"{dialect_name} has no moves straight in the struts; leave out --ptp-struts, or use {able}")
    file = output_place(output, Path(f"{plan.resolve().name}{language.suffix}"), overwrite)
    check_file(file, language.suffixes, [plan, *plan.glob("*")] if plan.is_dir() else [plan], overwrite)
    saved = saved or load_plan(plan, stale=stale)
    told = fits_law(plan, saved.data, saved.motion, dialect_name, saved.case)
    header = (
        f"hexcite {version('hexcite')}: excitation for identification of model {saved.data['model']}",
        case_line(saved.case),
        f"plan {plan.resolve().name}: {saved.data['family']}, {saved.motion.duration:g} s at speed {speed:g}",
        plan_line(plan),
        *saved.stale,
        language.start,
        *(["point-to-point moves are straight in the struts: another path than planned"] if in_struts else []),
    )
    with status(f"writing and proving {file.name}", quiet):
        written = proven_program(
            saved.motion, saved.case, language.load(file.suffix.lower()), str(file), header, speed, accepted, in_struts
        )
        changed = {}
        if in_struts:
            from planner.runs.in_struts import changed_motion

            guarantees = language.load().guarantees(written.reading, saved.case)
            read = ProgramFile(file, language, written.content, written.reading, guarantees)
            changed = changed_motion(read, saved.case, saved.data["model"])
    with atomic_file(file) as part:
        part.write_bytes(written.content)
    proof = written.proof
    forecast = language.load().forecast(written.reading, saved.case)
    answer = {
        "program": str(file),
        "dialect": dialect_name,
        "blocks": written.reading.blocks,
        "duration_s": proof.duration,
        "excitation_s": proof.excitation,
        "verdict": proof.verdict,
        "relies_on": list(proof.relies_on),
        "predicted_stretch": forecast.stretch,
        "remarks": [*told, *forecast.remarks, *saved.stale],
        "limits": proof.limits.to_json(),
        **changed,
    }
    if not quiet:
        unit = "rows" if dialect_name == "setpoints" else "blocks"
        print(f"program written: {file} ({written.reading.blocks} {unit}, {proof.duration:.2f} s, read back)")
        print(f"limits: {proof.verdict}{' (accepted)' if proof.relies_on else ''}")
        for remark in answer["remarks"]:
            print(remark)
        if in_struts:
            print(_sentence_of(answer, saved.data.get("d_efficiency")))
    return answer


def _sentence_of(answer: dict[str, Any], planned: float | None) -> str:
    where = f"up to {answer['off_path_mm']:.2g} mm and {answer['off_path_deg']:.2g} deg from the planned path"
    if answer["d_efficiency"] is None:
        return f"moves straight in the struts lead {where}"
    return (
        f"moves straight in the struts lead {where}; the excitation takes {answer['excitation_s']:.2f} s, D-efficiency "
        f"{answer['d_efficiency']:.3f} (planned {planned:.3f})"
    )


def check(
    program: Annotated[Path, typer.Argument(help="Program file.")],
    case: Annotated[str, typer.Option(help="Built-in name, folder or case file.")],
    dialect: Annotated[
        str | None, typer.Option(help="The program's language; by default the one that its suffix names.")
    ] = None,
    json: Json = False,
) -> None:
    """Read a program back, independently of its writer, and prove it."""
    answer, reason = check_program(program, case, dialect, quiet=json)
    if json:
        print_json(answer)
    else:
        show_check(answer)
    if reason is not None:
        raise reason


def check_program(
    program: Path, case: str, dialect: str | None, quiet: bool
) -> tuple[dict[str, Any], Exception | None]:
    """The JSON answer, and the error where a limit is exceeded."""
    from cases.errors import ProgramError
    from cases.loading import load_case
    from planner.runs.fingerprints import written_for_another
    from postprocessors.files import read_program
    from postprocessors.proving.proof import prove_program

    loaded = load_case(case)
    with status(f"proving {program.name}", quiet):
        read = read_program(program, loaded, dialect)
        proof = prove_program(read.reading, loaded, read.guarantees)
    other = written_for_another(read.content, loaded)
    reason = None
    try:
        proof.require()
    except ProgramError as error:
        reason = error
    answer = {
        "ok": proof.ok,
        "verdict": proof.verdict,
        "relies_on": list(proof.relies_on),
        "violations": [{"line": v.line, "sentence": v.check.sentence()} for v in proof.violations],
        "duration_s": proof.duration,
        "remarks": [*proof.remarks, *([other] if other else [])],
        "limits": proof.limits.to_json(),
    }
    return answer, reason


def show_check(answer: dict[str, Any]) -> None:
    """Prints a proof for people."""
    print_table("Limits of the program as read back", LIMIT_COLUMNS, limit_rows(answer["limits"]))
    for violation in answer["violations"]:
        print(f"line {violation['line']}: {violation['sentence']}")
    for remark in answer["remarks"]:
        print(f"note: {remark}")
    print(f"{answer['verdict']} ({answer['duration_s']:.2f} s)")
