"""`hexcite run`: executes a program and writes a recording."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, print_json, status
from planner.precision import share_text

if TYPE_CHECKING:
    from identification.limit import LimitKind
    from planner.runs.running import RunOutcome

ANSWERED = (
    "controller", "samples", "planned_s", "path_error_mm", "d_efficiency", "d_efficiency_planned",
    "peak_acceleration_of_limit", "peaks_of_limit", "remark", "payload", "disturbances",
)  # fmt: skip


def run(
    program: Annotated[Path, typer.Argument(help="Program file.")],
    case: Annotated[str, typer.Option(help="Built-in name, folder or case file.")],
    on: Annotated[str, typer.Option(help="Controller: virtual or linuxcnc.")] = "virtual",
    seed: Annotated[int, typer.Option(help="Seed of the simulated sensors' noise.")] = 0,
    payload: Annotated[int, typer.Option(help="How many of the case's weights are mounted on the machine.")] = 0,
    disturbed: Annotated[
        bool,
        typer.Option("--disturbed", help="With the case's disturbances: vibration, ripple, pose-dependent errors."),
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write; PROGRAM-recording by default.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Execute a program and write a recording.

    Sensors and encoders are simulated for the motion that the controller executed.
    """
    from cases.files import RUN, check_folder, output_place
    from cases.loading import find_case, load_case
    from identification.loaded import circumstances
    from planner.runs.running import execute, require_controller, require_seed
    from planner.runs.written import read_for

    require_seed(seed)
    require_controller(on)
    folder = output_place(output, Path(f"{program.stem}-recording"), overwrite)
    check_folder(folder, RUN, [program, find_case(case)], overwrite)
    loaded = load_case(case)
    around = circumstances(loaded, payload, disturbed)
    with status(f"running {program.name} on {on}", json):
        outcome = execute(read_for(loaded, program), loaded, on, seed, around)
        outcome.recording.save(folder, overwrite)
    answer = answer_of_run(outcome, folder)
    if json:
        print_json(answer)
    else:
        show_run(answer, outcome)


def answer_of_run(outcome: "RunOutcome", folder: Path) -> dict[str, Any]:
    """The JSON answer of a run that was written."""
    about = outcome.recording.record
    answer = {"recording": str(folder), "duration_s": about["executed_s"]} | {key: about[key] for key in ANSWERED}
    return answer | {"poses": len(about["poses_m_rad"]), "simulated": True}


def show_run(answer: dict[str, Any], outcome: "RunOutcome") -> None:
    """Prints a run for people."""
    around = outcome.around
    mounted = f", {len(around.weights)} weights of {around.load:.4g} kg mounted" if around.weights else ""
    disturbances = ", with the case's disturbances" if around.disturbances is not None else ""
    print(f"executed on {answer['controller']}; sensors and encoders simulated{mounted}{disturbances}")
    if answer["poses"]:
        print(
            f"{answer['poses']} poses measured in {answer['duration_s']:.2f} s ({answer['planned_s']:.2f} s "
            f"planned), home to home; stood within {answer['path_error_mm']:.4f} mm of them"
        )
    else:
        print(_rated(answer))
    peaks = ", ".join(f"{name} {share_text(share, 0)}" for name, share in outcome.rating.peaks.items())
    print(f"reached of the limits in the whole run: {peaks}")
    for sentence in exceeded_sentence(outcome.rating.peaks, outcome):
        print(sentence)
    if answer["remark"]:
        print(answer["remark"])
    print(f"recording written: {answer['recording']} ({answer['samples']} samples)")


def exceeded_sentence(peaks: Mapping["LimitKind", float], outcome: "RunOutcome") -> Iterator[str]:
    """Limits that were exceeded: by the controller that ran, which is not always the one that the program is for."""
    exceeded = {kind for kind, share in peaks.items() if share > 1.01}
    enforced = frozenset() if outcome.run.real else outcome.guarantees.enforced
    safe = {kind for kind in exceeded if kind.family in enforced}
    if exceeded - safe:
        yield (
            f"EXCEEDED BY THE CONTROLLER, which does not enforce them: {', '.join(sorted(exceeded - safe))}; know what "
            "the drives bear before a real machine runs this (what is above the evaluation's filter does not reach the "
            "estimate)"
        )
    if safe:
        yield (
            f"exceeded by the built-in controller only: {', '.join(sorted(safe))}; {outcome.guarantees.controller} "
            "keeps it itself, as the case says (controller_keeps), and will take longer there"
        )


def _rated(answer: dict[str, Any]) -> str:
    return (
        f"excitation took {answer['duration_s']:.3f} s of {answer['planned_s']:.3f} s planned, strayed "
        f"{answer['path_error_mm']:.3f} mm from the path, D-efficiency {answer['d_efficiency']:.3f} as executed, "
        f"behind the evaluation's filter ({answer['d_efficiency_planned']:.3f} as programmed, by the controller's law)"
    )
