"""Identifies as a user wishes, saves the result and prints it for people."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cases.basis import KEPT, result_basis
from cases.errors import IdentificationError
from cases.files import RESULT, atomic_folder, check_folder, json_text, output_place
from cases.schema import Case
from identification.finding import Kind, warning
from identification.force import external_force
from identification.hexapod import StrutsDoNotClose
from identification.identifiability import Identifiability
from identification.identify import default_model, identifiability
from identification.identify import identify as estimate_parameters
from identification.model import identification_model
from identification.provenance import provenance
from identification.recording import files_of, read_recording, read_run
from identification.result import Estimate, Value
from identification.runs.rates import on_one_clock
from identification.runs.residuals import residuals_of
from identification.saved import load_result
from planner.cli.console import print_table, status
from planner.cli.wishes import Wish, method_of
from planner.precision import std_text, value_text
from planner.reports.identify import about_inputs, identify_page
from planner.reports.page import render
from planner.runs.recorded import UNSAID, Still, about_run, case_of, fitting_case, shorter_than_planned, standing_of

PARAMETER_COLUMNS = ("parameter", "value", "+-", "std (28)", "std robust", "unit")


def make_result(
    paths: Path | Sequence[Path],
    case: str | None,
    wish: int | Wish | None,
    output: Path | None,
    quiet: bool,
    still: Still = UNSAID,
    overwrite: bool = False,
    stale: bool = False,
    plots: bool = False,
) -> tuple[dict[str, Any], Estimate]:
    """Identifies, saves, prints unless `quiet`; returns the JSON answer and the estimate.

    Args:
        paths: one recording, or the files of one run.
        case: its name, or None where a recording folder knows.
        wish: a model's number or all that can be asked.
        output: folder to write.
        quiet: print nothing.
        still: what is said about standstills.
        overwrite: replace an earlier result.
        stale: go on although the recording's case has changed since.
        plots: whether to write figures for papers too.
    """
    paths = [paths] if isinstance(paths, Path) else list(paths)
    wish = wish if isinstance(wish, Wish) else Wish(wish)
    loaded, remarks = case_of(paths[0], case, stale)
    folder = output_place(output, Path(f"{paths[0].resolve().stem}-result"), overwrite)
    check_folder(folder, RESULT, paths, overwrite)
    with status("identifying", quiet):
        recording, standing = standing_of(on_one_clock(read_run(paths, loaded), loaded), loaded, paths[0], still)
        number = default_model(recording) if wish.model is None else wish.model
        how = method_of(wish, identification_model(loaded, number, wish.terms), loaded)
        try:
            estimate = estimate_parameters(recording, loaded, number, how, wish.terms, wish.conditioning)
        except StrutsDoNotClose as error:
            if other := fitting_case(error.lengths, loaded, case):
                raise IdentificationError(f"{error}; they fit the case {other}, name it with --case") from error
            raise
        found = identifiability(estimate)
        changed = [warning(Kind.CASE, remark) for remark in remarks]
        more = (*shorter_than_planned(paths[0], recording), *changed)
        estimate = replace(estimate, findings=(*estimate.findings, *more))
        content: dict[str, Any] = {KEPT: result_basis(loaded), **({"stale": list(remarks)} if remarks else {})}
        content = (
            estimate.to_json() | content | provenance(files_of(paths)) | about_run(paths[0], case, recording, estimate)
        )
        answer = {"result": str(folder), "report": str(folder / "report.html")} | content
        if standing is not None:
            content["standstills"] = answer["standstills"] = standing
        answer["strongest_correlations"] = [{"pair": [a, b], "value": v} for a, b, v in found.strongest()]
        with atomic_folder(folder, RESULT, overwrite) as part:
            (part / "result.json").write_text(json_text(content), encoding="utf-8")
            (part / "identifiability.json").write_text(json_text(found.to_json()), encoding="utf-8")
            if plots:
                _save_plots(estimate, found, part / "plots")
            left = residuals_of(estimate)
            page = identify_page(loaded, estimate, found, left, about_inputs(paths[0], content))
            (part / "report.html").write_text(render(page), encoding="utf-8")
    if not quiet:
        show_result(answer)
    return answer, estimate


def _save_plots(estimate: Estimate, found: Identifiability, folder: Path) -> None:
    from planner.reports.plots import identifiability_figure, residual_figure, save_figure  # Matplotlib takes a second

    save_figure(residual_figure(estimate), folder, "residuals")
    save_figure(identifiability_figure(found), folder, "identifiability")


def verify_result(path: Path, case: Case, result: Path, quiet: bool) -> dict[str, Any]:
    """How well the parameters predict another run: what is left of force and moment, and of each channel."""
    found = external_force(on_one_clock(read_recording(path, case), case), case, load_result(result), whole=False)
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


def parameter_rows(parameters: dict[str, Any]) -> list[list[str]]:
    """Rows of a parameter table, lengths in mm: value, the larger standard deviation, and both of them."""
    rows = []
    for name, p in parameters.items():
        scale, unit = (1e3, "mm") if p["unit"] == "m" else (1.0, p["unit"])
        known = Value(p["value"], p["std"], p["std_robust"], p["unit"])
        deviations = (known.reported, known.std, known.std_robust)
        given = deviations[0] <= 1e-9 * abs(p["value"])  # of what is given only rounding is left
        shown = ["given", "-", "-"] if given else [std_text(d * scale) for d in deviations]
        value = f"{p['value'] * scale:.6g}" if given else value_text(p["value"] * scale, deviations[0] * scale)
        rows.append([name, value, *shown, unit])
    return rows


def show_residuals(answer: dict[str, Any]) -> None:
    """Prints s0 and what the model leaves of the recorded forces; a filter lets s0 see the smaller part only."""
    equal = answer["weights"] == "equal"
    left = f"recorded forces less the model: {answer['s0_N']:.3g} N rms"
    if equal and answer["delay_s"] is not None and answer["s0_N"] > 2.0 * answer["s0"]:
        left += ", most of it above the evaluation's filter, where the estimate does not look"
    print(f"s0 = {answer['s0']:.3g}{' N' if equal else ''}, weights {answer['weights']}; {left}")


def show_noise(answer: dict[str, Any]) -> None:
    """Prints what s0 consists of and what noise draws the parameters by, where the case states noise."""
    sources = answer["noise_sources"]
    if sources is None:
        return
    stated = {"force sensors": sources["force_sensors"], "accelerations": sources["accelerations"]}
    parts = [f"{name} {100 * share:.3g} %" for name, share in stated.items() if share is not None]
    left = "unexplained" if len(parts) == 2 else "anything else"
    print(f"s0^2 consists of: noise of {', of '.join(parts)}, {left} {100 * sources['unexplained']:.3g} %")
    drawn = {n: a for n, a in (answer["attenuation"] or {}).items() if a["of_std"] is not None}
    if drawn:
        worst = max(drawn, key=lambda name: abs(drawn[name]["of_std"]))
        bias, unit = drawn[worst], answer["parameters"][worst]["unit"]
        scale, unit = (1e3, "mm") if unit == "m" else (1.0, unit)
        print(
            f"noise of the accelerations draws parameters by at most {abs(bias['of_std']):.2g} of their +- "
            f"(attenuation, not taken out; vibration would draw nothing): {worst} by {bias['bias'] * scale:+.2g} {unit}"
        )


def show_result(answer: dict[str, Any]) -> None:
    """Prints a result for people."""
    rows = parameter_rows(answer["parameters"])
    terms = f" with {', '.join(answer['error_terms'])}" if answer["error_terms"] else ""
    title = f"Model {answer['model']}{terms}, {answer['estimator']}: {answer['samples']} samples"
    print_table(title, PARAMETER_COLUMNS, rows)
    print(
        "+- is the larger of std by (28), right for white noise, and of std robust, which allows for noise that is not"
    )
    print(f"rank {answer['rank']}, condition {answer['condition']:.3g}")
    show_residuals(answer)
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
    show_noise(answer)
    for note in answer["notes"]:
        print(note)
    felt = answer["accelerometer"]
    if felt is not None:
        values = ", ".join(f"{b:.4f} +- {s:.4f}" for b, s in zip(felt["bias_m_s2"], felt["std_m_s2"], strict=True))
        turn = ", ".join(f"{1e3 * t:.1f}" for t in felt["turn_rad"])
        print(f"accelerometer: biases {values} m/s^2, turned by {turn} mrad; {felt['rms_m_s2']:.2g} m/s^2 rms are left")
    if answer["biases"] is not None:
        also = " and of the accelerometer" if answer["biases"]["accelerometer"] is not None else ""
        print(f"offsets of the forces{also} are those of {answer['biases']['result']}, with their uncertainty")
    if "standstills" in answer:
        found = answer["standstills"]
        which = "the poses of the program" if found["matched_to_poses"] else "found where the machine stands"
        print(f"{found['count']} averaged standstills, {which}, by the {found['found_by']}; weighted by their scatter")
        if found["restless"]:
            print(f"restless, and weighted less: {', '.join(map(str, found['restless']))}")
    for sentence in answer["warnings"]:
        print(f"warning: {sentence}")
    print(f"result written: {answer['result']}, with its report {answer['report']}")
