"""`hexcite identify`: parameters with error bars from a recording."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from identification.conditioning import USUAL, Conditioning
from planner.cli.console import Json, print_json, print_table, status


def identify(
    recordings: Annotated[
        list[Path],
        typer.Argument(help="One run: a file, several files of it in any order, or a folder of hexcite run."),
    ],
    case: Annotated[
        str | None, typer.Option(help="Built-in name, folder or file; a recording folder knows its own.")
    ] = None,
    model: Annotated[
        int | None, typer.Option(help="Identification model, 0 to 9; by default what the run can carry.")
    ] = None,
    estimator: Annotated[
        str,
        typer.Option(
            help="gauss-markov, robust (gross errors), full (covariance of the channels), consistent "
            "(inertia of a real body) or nonlinear (physical parameters)."
        ),
    ] = "gauss-markov",
    weights: Annotated[
        str | None,
        typer.Option(
            help="W: equal, per_channel or per_unit (from the residuals), stated (from the noise of forces and "
            "accelerations in the case, through the model); by default the case's."
        ),
    ] = None,
    fix: Annotated[
        list[str] | None, typer.Option(help="A known value, taken as exact: m=93.1kg, xC=0mm. Repeatable.")
    ] = None,
    drop: Annotated[
        list[str] | None, typer.Option(help="A parameter to leave out, as if it were zero: k3. Repeatable.")
    ] = None,
    symmetric: Annotated[
        bool, typer.Option("--symmetric", help="Symmetric platform: xC, yC and moments of deviation are zero.")
    ] = False,
    prior: Annotated[list[str] | None, typer.Option(help="An uncertain value: m=33+-0.5kg. Repeatable.")] = None,
    biases: Annotated[
        Path | None,
        typer.Option(
            help="Result of standstills: take the offsets of forces and accelerometer from it, with their uncertainty."
        ),
    ] = None,
    terms: Annotated[str | None, typer.Option(help="Error terms instead of the model's, of K1 to K5: K1,K4.")] = None,
    poses: Annotated[
        Path | None,
        typer.Option(help="Plan of poses: average the run's standstills, which must be those of this plan."),
    ] = None,
    standstills: Annotated[
        bool, typer.Option("--standstills", help="Average the run's standstills, wherever they are.")
    ] = False,
    period: Annotated[
        str | None,
        typer.Option(
            help="A run that repeats itself: average its periods, differentiate and filter by a Fourier series. "
            "auto finds the period, or give it in seconds."
        ),
    ] = None,
    harmonics: Annotated[
        int | None, typer.Option(help="Of that series; by default as many as stand out of the struts' noise.")
    ] = None,
    accelerated: Annotated[
        str | None,
        typer.Option(
            help="Evaluate the samples of highest strut acceleration only: a share of them, 30%, or those above a "
            "threshold, 3m/s^2; the standard deviations are compared with those of all samples."
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            help="Plan folder or program that the run followed: tells where its feed was another, as by an override. "
            "A folder of hexcite run knows its program."
        ),
    ] = None,
    flexible: Annotated[
        bool,
        typer.Option(
            "--flexible",
            help="The structure yields: estimate its lowest mode with the parameters, behind a low-pass at half of it.",
        ),
    ] = False,
    verify: Annotated[
        Path | None, typer.Option(help="Predict this second run with the parameters of the first.")
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder to write.")] = None,
    json: Json = False,
) -> None:
    """Identify parameters from a recorded run.

    Standard deviations: `std` by (28), right where noise is white; `std_robust` allows for noise that is not. The
    larger of the two is what to report.
    """
    from planner.cli.conditioning import read_conditioning

    wanted = Wish(
        model, estimator, tuple(fix or ()), tuple(drop or ()), symmetric, tuple(prior or ()),
        tuple(t.strip() for t in terms.split(",")) if terms else (), weights, biases,
        read_conditioning(period, harmonics, accelerated, flexible),
    )  # fmt: skip
    answer, _ = make_result(recordings, case, wanted, output, quiet=json, still=Still(poses, standstills), plan=plan)
    if verify is not None:
        answer["verify"] = verify_result(verify, case_of(recordings[0], case), Path(answer["result"]), quiet=json)
    if json:
        print_json(answer)


class Wish(NamedTuple):
    """What a user asks of an identification, as typed.

    Args:
        model: number in Table 2; None: what the run can carry.
        estimator: its name.
        fix: known values.
        drop: names to leave out.
        symmetric: whether the platform is symmetric.
        prior: uncertain values.
        terms: error terms instead of the model's.
        weights: instead of the case's.
        biases: result whose offsets are taken.
        conditioning: what is to be done to a moving run beforehand.
    """

    model: int | None = None
    estimator: str = "gauss-markov"
    fix: tuple[str, ...] = ()
    drop: tuple[str, ...] = ()
    symmetric: bool = False
    prior: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()
    weights: str | None = None
    biases: Path | None = None
    conditioning: Conditioning = USUAL


class Still(NamedTuple):
    """What a user says about standstills in a run that was recorded with a clock.

    Args:
        plan: of poses, whose standstills the run holds.
        asked: average standstills without knowing the poses.
    """

    plan: Path | None = None
    asked: bool = False


def make_result(
    paths: Path | Sequence[Path],
    case: str | None,
    wish: "int | Wish | None",
    output: Path | None,
    quiet: bool,
    still: Still = Still(),  # noqa: B008
    plan: Path | None = None,
) -> tuple[dict[str, Any], Any]:
    """Identifies, saves, prints unless `quiet`; returns the JSON answer and the estimate.

    Args:
        paths: one recording, or the files of one run.
        case: its name, or None where a recording folder knows.
        wish: a model's number or all that can be asked.
        output: folder to write.
        quiet: print nothing.
        still: what is said about standstills.
        plan: that the run followed; a recording folder knows its program.
    """
    from cases.files import RESULT, atomic_folder, check_folder, json_text
    from identification.identify import default_model, identifiability
    from identification.identify import identify as estimate_parameters
    from identification.model import identification_model
    from identification.provenance import provenance
    from identification.rates import on_one_clock
    from identification.recording import files_of, read_run
    from identification.residuals import residuals_of
    from identification.streaming import identify_long, is_long
    from planner.fingerprints import plan_of_recording
    from planner.plots import identifiability_figure, residual_figure, save_figure
    from planner.report import render
    from planner.report_identify import about_inputs, identify_page

    paths = [paths] if isinstance(paths, Path) else list(paths)
    wish = wish if isinstance(wish, Wish) else Wish(wish)
    loaded = case_of(paths[0], case)
    folder = output if output is not None else Path(f"{paths[0].resolve().stem}-result")
    check_folder(folder, RESULT, paths)
    with status("identifying", quiet):
        standing = None
        if len(paths) == 1 and wish == Wish(wish.model) and is_long(paths[0]) and not knows_poses(paths[0], still):
            estimate, recording = identify_long(paths[0], loaded, wish.model)
        else:
            recording, standing = standing_of(on_one_clock(read_run(paths, loaded), loaded), loaded, paths[0], still)
            number = default_model(recording) if wish.model is None else wish.model
            how = method_of(wish, identification_model(loaded, number, wish.terms), loaded)
            estimate = estimate_parameters(recording, loaded, number, how, wish.terms, wish.conditioning)
            estimate = with_feed(estimate, recording, loaded, paths[0], plan)
        found = identifiability(recording, loaded, estimate)
        content = estimate.to_json() | provenance(files_of(paths)) | {"plan_hash": plan_of_recording(paths[0])}
        answer = {"result": str(folder), "report": str(folder / "report.html")} | content
        if standing is not None:
            content["standstills"] = answer["standstills"] = standing
        answer["strongest_correlations"] = [{"pair": [a, b], "value": v} for a, b, v in found.strongest()]
        with atomic_folder(folder, RESULT) as part:
            (part / "result.json").write_text(json_text(content), encoding="utf-8")
            (part / "identifiability.json").write_text(json_text(found.to_json()), encoding="utf-8")
            save_figure(residual_figure(estimate), part / "plots", "residuals")
            save_figure(identifiability_figure(found), part / "plots", "identifiability")
            left = residuals_of(recording, loaded, estimate)
            page = identify_page(loaded, estimate, found, left, about_inputs(paths[0], content))
            (part / "report.html").write_text(render(page), encoding="utf-8")
    if not quiet:
        show_result(answer)
    return answer, estimate


def with_feed(estimate: Any, recording: Any, case: Any, path: Path, plan: Path | None) -> Any:
    """The estimate with a warning where the run went at another feed than its plan or program.

    Args:
        estimate: of the recording.
        recording: the run.
        case: its case.
        path: where it was read.
        plan: that it followed, as the user says; else what the folder of `hexcite run` says counts.

    Raises:
        HexciteError: a plan that was named and cannot be compared, or is not of this run.
    """
    from dataclasses import replace

    from cases.errors import RecordingError
    from identification.feed import about_feed, against_plan
    from identification.identify import placed
    from planner.followed import followed_by_recording, followed_plan

    followed = followed_plan(plan, case) if plan is not None else followed_by_recording(path, case)
    if followed is None or (plan is None and (recording.t is None or recording.struts is None)):
        return estimate
    try:
        stretches = against_plan(recording, case, followed.motion, followed.name)
    except RecordingError as error:
        if plan is not None:
            raise RecordingError(placed(recording.source, error)) from error
        return replace(estimate, warnings=(*estimate.warnings, str(error)))
    sentences, entries = about_feed(recording, stretches, f"comparison with {followed.name}")
    if plan is not None and not stretches:
        entries = {"feed": {"found_by": f"comparison with {followed.name}", "stretches": []}}
    return replace(estimate, warnings=(*estimate.warnings, *sentences), told={**estimate.told, **entries})


def knows_poses(path: Path, still: Still) -> bool:
    """Whether a run is said to stand at poses, by its folder or by the user."""
    from planner.poses.expected import poses_of_recording

    return still.asked or still.plan is not None or poses_of_recording(path) is not None


def standing_of(recording: Any, case: Any, path: Path, still: Still) -> tuple[Any, dict[str, Any] | None]:
    """The run's averaged standstills with what is to be told of them, where it was recorded at poses; else the run.

    A folder of hexcite run knows the poses of its program; `still` names others, or says that there are standstills.

    Raises:
        StandstillMismatch: a pose was not measured, or a standstill is none of the poses.
        RecordingError: no standstills, though there should be some.
    """
    from cases.errors import RecordingError
    from identification.standing import average, find_standstills, match, stands_only
    from planner.poses.expected import poses_of_plan, poses_of_recording

    expected = poses_of_plan(still.plan) if still.plan is not None else poses_of_recording(path)
    if recording.t is None:
        if still.plan is None and not still.asked:
            return recording, None
        raise RecordingError(f"{recording.source}: its rows are averaged already; leave --poses and --standstills out")
    if expected is None and not still.asked and not stands_only(recording):
        return recording, None
    settle = case.poses.settle_s if case.poses is not None else 0.5
    standing = average(recording, find_standstills(recording, settle))
    if expected is not None:
        standing = match(standing, case, expected, recording.source)
    told = {
        "count": len(standing.windows),
        "matched_to_poses": expected is not None,
        "found_by": "trigger" if recording.trigger is not None and recording.trigger.any() else "motion",
        "restless": [k for k, s in enumerate(standing.scatter, 1) if s > RESTLESS],
    }
    return standing.averages, told


RESTLESS = 3.0  # times the usual scatter of an averaged force


def method_of(wish: Wish, model: Any, case: Any) -> Any:
    """The method that a user asks for.

    Raises:
        HexciteError: a value that is not understood, a name that the model does not have, an unknown estimator, a
            result that is none or belongs to another case.
    """
    from identification.estimators import method
    from identification.parameters import physical_form
    from identification.priors import Prior
    from identification.saved import biases_of
    from identification.selection import symmetric_platform
    from planner.cli.quantities import read_uncertain, read_values

    units = {p.name: p.unit for p in (*model.parameters, *physical_form(model).parameters)}
    known = read_values(wish.fix, units, "--fix")
    if wish.symmetric:
        known = symmetric_platform(model) | known
    priors = [Prior(*values) for values in read_uncertain(wish.prior, units, "--prior")]
    biases = None if wish.biases is None else biases_of(wish.biases, case)
    return method(wish.estimator, known, wish.drop, priors, wish.weights, biases)


def verify_result(path: Path, case: Any, result: Path, quiet: bool) -> dict[str, Any]:
    """How well the parameters predict another run: what is left of force and moment, and of each channel."""
    from identification.force import external_force
    from identification.rates import on_one_clock
    from identification.recording import read_recording
    from identification.saved import load_result

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


def case_of(path: Path, case: str | None) -> Any:
    """The case that was named, or the one that a recording folder was made for and that has not changed since."""
    from cases.errors import RecordingError
    from cases.files import another_kind, read_json
    from cases.loading import load_case

    recorded = any((path / f"recording.{suffix}").is_file() for suffix in ("json", "csv", "parquet"))
    if not recorded and (other := another_kind(path, "recording.json")):
        raise RecordingError(f"{path}: {other}; here a recording is wanted, such as hexcite run writes")
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
    """Rows of a parameter table, lengths in mm: value, the larger standard deviation, and both of them."""
    rows = []
    for name, p in parameters.items():
        scale, unit = (1e3, "mm") if p["unit"] == "m" else (1.0, p["unit"])
        deviations = (max(p["std"], p["std_robust"]), p["std"], p["std_robust"])
        given = deviations[0] <= 1e-9 * abs(p["value"])  # of what is given only rounding is left
        shown = ["given", "-", "-"] if given else [f"{d * scale:.3g}" for d in deviations]
        rows.append([name, f"{p['value'] * scale:.6g}", *shown, unit])
    return rows


PARAMETER_COLUMNS = ("parameter", "value", "+-", "std (28)", "std robust", "unit")


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
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
    print(f"result written: {answer['result']}, with its report {answer['report']}")
