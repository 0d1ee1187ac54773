"""`hexcite identify`: parameters with error bars from a recording."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import Json, print_json, print_table, status


def identify(
    recordings: Annotated[list[Path], typer.Argument(help="The run: a CSV file, or a folder of hexcite run.")],
    case: Annotated[
        str | None, typer.Option(help="Built-in name, folder or file; a recording folder knows its own.")
    ] = None,
    model: Annotated[
        int | None, typer.Option(help="Identification model, 0 to 9; by default what the run can carry.")
    ] = None,
    verify: Annotated[
        Path | None, typer.Option(help="Predict this second run with the parameters of the first.")
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder to write.")] = None,
    json: Json = False,
) -> None:
    """Identify parameters from a recorded run."""
    from cases.errors import RecordingError

    if len(recordings) > 1:
        raise RecordingError(f"{recordings[1]}: one file of one run is read so far; join the files and name one")
    answer, _ = make_result(recordings[0], case, model, output, quiet=json)
    if verify is not None:
        answer["verify"] = verify_result(verify, case_of(recordings[0], case), Path(answer["result"]), quiet=json)
    if json:
        print_json(answer)


def make_result(
    path: Path, case: str | None, model: int | None, output: Path | None, quiet: bool
) -> tuple[dict[str, Any], Any]:
    """Identifies, saves, prints unless `quiet`; returns the JSON answer and the estimate."""
    from cases.files import RESULT, atomic_folder, check_folder, json_text
    from identification.identify import identifiability
    from identification.identify import identify as estimate_parameters
    from identification.recording import read_recording
    from planner.plots import identifiability_figure, residual_figure

    loaded = case_of(path, case)
    folder = output if output is not None else Path(f"{path.resolve().stem}-result")
    check_folder(folder, RESULT, [path])
    with status("identifying", quiet):
        recording = read_recording(path, loaded)
        estimate = estimate_parameters(recording, loaded, model)
        found = identifiability(recording, loaded, estimate)
        answer = {"result": str(folder)} | estimate.to_json()
        answer["strongest_correlations"] = [{"pair": [a, b], "value": v} for a, b, v in found.strongest()]
        with atomic_folder(folder, RESULT) as part:
            (part / "result.json").write_text(json_text(estimate.to_json()), encoding="utf-8")
            (part / "plots").mkdir()
            (part / "identifiability.json").write_text(json_text(found.to_json()), encoding="utf-8")
            residual_figure(estimate).savefig(part / "plots" / "residuals.svg")
            identifiability_figure(found).savefig(part / "plots" / "identifiability.svg")
    if not quiet:
        show_result(answer)
    return answer, estimate


def verify_result(path: Path, case: Any, result: Path, quiet: bool) -> dict[str, Any]:
    """How well the parameters predict another run: what is left of force and moment, and of each channel."""
    from identification.force import external_force
    from identification.recording import read_recording
    from identification.saved import load_result

    found = external_force(read_recording(path, case), case, load_result(result), whole=False)
    deviation = found.wrench.std(axis=0)
    answer = {
        "recording": str(path),
        "samples": len(found.t),
        "force_3s_N": (3 * deviation[:3]).tolist(),
        "moment_3s_Nm": (3 * deviation[3:]).tolist(),
        "mean_force_N": found.wrench[:, :3].mean(axis=0).tolist(),
        "mean_moment_Nm": found.wrench[:, 3:].mean(axis=0).tolist(),
        "channel_rms": ((found.residuals**2).mean(axis=0) ** 0.5).tolist(),
    }
    if not quiet:
        force, moment = (
            ", ".join(f"{v:.3g}" for v in answer["force_3s_N"]),
            ", ".join(f"{v:.3g}" for v in answer["moment_3s_Nm"]),
        )
        print(f"verified on {path}: left of the force +- {force} N (3 s), of the moment +- {moment} N m (3 s)")
    return answer


def case_of(path: Path, case: str | None) -> Any:
    """The case that was named, or the one that a recording folder was made for and that has not changed since."""
    from cases.errors import RecordingError
    from cases.files import read_json
    from cases.loading import load_case

    if case is not None:
        return load_case(case)
    if not (path.is_dir() and (path / "recording.json").is_file()):
        raise RecordingError(f"{path}: does not say which machine it is from; name it with --case")
    about = read_json(path / "recording.json", "hexcite run")
    loaded = load_case(str(about.get("case_file")))
    if about.get("case_hash") != loaded.hash:
        raise RecordingError(
            f"{path}: case {about.get('case_file')} has changed since the recording; name the right one with --case"
        )
    return loaded


def parameter_rows(parameters: dict[str, Any]) -> list[list[str]]:
    """Rows of a parameter table, lengths in mm."""
    rows = []
    for name, p in parameters.items():
        scale, unit = (1e3, "mm") if p["unit"] == "m" else (1.0, p["unit"])
        rows.append([name, *(f"{p[key] * scale:.6g}" for key in ("value", "std", "std_robust")), unit])
    return rows


def show_result(answer: dict[str, Any]) -> None:
    """Prints a result for people."""
    rows = parameter_rows(answer["parameters"])
    title = f"Model {answer['model']}: {answer['samples']} samples, rank {answer['rank']}"
    title += f", condition {answer['condition']:.3g}"
    print_table(title, ("parameter", "value", "std (28)", "std robust", "unit"), rows)
    print(f"s0 = {answer['s0']:.4g}, force residual {answer['s0_N']:.4g} N rms, weights {answer['weights']}")
    strongest = ", ".join(
        f"{a}~{b} {v:+.2f}" for (a, b), v in ((c["pair"], c["value"]) for c in answer["strongest_correlations"][:3])
    )
    print(f"strongest correlations of columns: {strongest}")
    if answer["delay_s"] is not None:
        delay = answer["delay_s"]
        print(
            f"forces lag the motion by {delay['value'] * 1e3:.3f} +- {delay['std'] * 1e3:.3f} ms "
            "(estimated and compensated)"
        )
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
    print(f"result written: {answer['result']}")
