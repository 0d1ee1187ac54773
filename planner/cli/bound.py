"""`hexcite bound`: how much information any motion inside the limits of a case can carry."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, print_json, status


def bound(
    case: Annotated[str, typer.Argument(help="Built-in name, folder or case file.")],
    model: Annotated[
        int | None, typer.Option(help="Identification model; by default the largest of the machine.")
    ] = None,
    tight: Annotated[
        bool, typer.Option("--tight", help="Count on rest at both ends and limited jerk; minutes.")
    ] = False,
    time_limit: Annotated[
        float, typer.Option(help="Stop after this many seconds of computing; the answer is an estimate.")
    ] = 120.0,
    renew: Annotated[bool, typer.Option("--renew", help="With --tight: compute it again; the tighter counts.")] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File for the JSON answer as well.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Compute how much information any motion inside the limits has.

    No motion passes it: the answer comes with its certificate.
    """
    from time import perf_counter

    from cases.files import check_file, json_text, write_text
    from cases.loading import load_case
    from identification.model import full_model
    from identification.noise.pose_field import PoseField
    from planner.bounds.kept import bound as information_limit
    from planner.bounds.kept import require_time

    require_time(time_limit)
    if output is not None:
        check_file(output, [".json"], overwrite=overwrite)
    loaded = load_case(case)
    start = perf_counter()
    model = full_model(loaded) if model is None else model
    with status(f"information limit of {loaded.name}, model {model}", json) as report:
        limit = information_limit(
            loaded, model, tight, time_limit=time_limit, renew=renew or not tight, progress=report
        )
    answer = {
        "case": loaded.name,
        "case_hash": loaded.hash,
        "model": model,
        "over": "motions from rest to rest in the motion box" if tight else "motion box",
        "tight": tight,
        "weights": "equal",
        "pose_errors": None if (field := PoseField.of(loaded.sensors)) is None else field.keys,
        "logdet_bound": limit.logdet,
        "logdet_design": limit.design_logdet,
        "logdet_proven": limit.proven_logdet,
        "certified": limit.certified,
        "certificate": {"dmax": limit.dmax, "p": limit.parameters, "method": limit.method},
        "solve_s": perf_counter() - start,
    }
    if output is not None:
        write_text(output, json_text(answer))
    if json:
        print_json(answer)
    else:
        _show(answer)


def _show(answer: dict[str, Any]) -> None:
    certificate, parameters = answer["certificate"], answer["certificate"]["p"]
    gap = answer["logdet_bound"] - answer["logdet_design"]
    print(
        f"{answer['case']}, model {answer['model']}, {parameters} parameters. A motion is worth log det of its mean "
        "information matrix (reference scaling, W = 1)."
    )
    print(f"best distribution found over the {answer['over']}: {answer['logdet_design']:.4f}")
    if answer["logdet_proven"] is None:
        print(f"of such a machine no limit is proven, the largest derivative is searched for: {certificate['method']}")
    else:
        print(f"proven limit for all of them: {answer['logdet_proven']:.4f}, by: {certificate['method']}")
    if answer["logdet_proven"] is not None and not answer["certified"]:
        print("time ran out before the proof closed the gap; a longer --time-limit closes it")
    if answer["pose_errors"] is not None:
        print("white noise alone counts here: errors that depend on the pose, which [sensors] states, leave less")
    print(
        f"`hexcite plan` rates motions against {answer['logdet_bound']:.4f}: D-efficiency = exp((log det - "
        f"{answer['logdet_bound']:.4f}) / {parameters})"
    )
    kind = "proven" if answer["certified"] else "an ESTIMATE"
    print(
        f"no motion exceeds log det {answer['logdet_bound']:.4f} ({kind}, {100 * gap / parameters:.2g} % of an "
        f"efficiency above the best that was found; {answer['solve_s']:.1f} s)"
    )
