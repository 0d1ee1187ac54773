"""`hexcite poses`: chooses poses for quasi-static identification and writes a plan folder."""

from pathlib import Path
from typing import Annotated

import hexcite as hx
from cases.base.files import PLAN, check_folder, output_place
from hexcite.cli import console
from hexcite.cli.console import argument, option, out
from identification.texts import aligned


def poses(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    criterion: console.Criterion = "D",
    count: Annotated[int | None, option("Poses; by default 30.")] = None,
    at: Annotated[Path | None, option("CSV of poses of one's own: what they are worth beside chosen ones.")] = None,
    method: Annotated[str, option("backward (Algorithm 1), backward-change, refine, or all.")] = "refine",
    model: Annotated[int | None, option("Identification model, 0 to 5; by default the largest of the machine.")] = None,
    candidates: Annotated[
        int | None, option("Quasi-random candidates; by default the grid of the case, of a chain 2048.")
    ] = None,
    seed: Annotated[int, option("Seed of the sample.")] = 0,
    known: Annotated[
        list[Path] | None,
        option(
            "Result folder of earlier standstills of the machine. Repeatable. Deviations then hold for all of them."
        ),
    ] = None,
    without: Annotated[
        str | None,
        option(
            "jerk, which linuxcnc and urscript do not limit: moves with steps of acceleration, if the machine bears "
            "them."
        ),
    ] = None,
    least: Annotated[
        bool,
        option("Say the fewest poses of each criterion (Algorithm 1 until rank is lost) and write nothing.", "--least"),
    ] = False,
    output: Annotated[Path | None, out("Folder to write; named after the case by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Choose the most informative poses to stand still at.

    They are visited in a short order.
    """
    from cases.tables import find_case
    from identification.model.model import static_model
    from planner.known import load_known

    loaded = hx.load_case(case)
    if least:
        _say_least(loaded, static_model(loaded) if model is None else model, candidates, seed, json)
        return
    folder = output_place(output, Path(f"{loaded.name}-poses"), overwrite)
    check_folder(folder, PLAN, [find_case(case)], overwrite)
    earlier = load_known(known or (), loaded)
    number = static_model(loaded) if not earlier else earlier[0].record.model
    with console.status("choosing poses", json) as remark:
        plan = hx.plan_poses(
            loaded,
            at,
            progress=lambda rest: remark(f"{rest} poses"),
            criterion=criterion,
            count=count,
            method=method,
            model=number if model is None else model,
            candidates=candidates,
            seed=seed,
            without=without,
            known=earlier,
        )
    with console.status("writing", json):
        console.save_with_page(plan, PLAN, folder, overwrite)
    answer = {"plan": str(folder), "report": str(folder / "report.html")} | plan.to_json()
    answer.pop("moves")
    answer["identifiability"] = (told := hx.identifiability(plan)).to_json()
    texts = (f"identifiability: {told.words}",) if told.sentences else ()
    console.answered(answer, json, f"plan written: {folder}, with its report {folder}/report.html", plan, *texts)


def _say_least(case: "hx.Case", model: int, candidates: int | None, seed: int, json: bool) -> None:
    """Prints the fewest poses of each criterion."""
    from planner.poses.planned_poses import least_poses
    from planner.request import PoseRequest

    with console.status("removing poses", json) as remark:
        found = least_poses(
            PoseRequest(model=model, candidates=candidates, seed=seed), case, lambda rest: remark(f"{rest} poses")
        )
    rows = [(each.criterion, each.method, str(each.poses), f"{each.condition:.4g}") for each in found]
    answer = {"model": model, "least": [each._asdict() for each in found]}
    console.answered(answer, json, *aligned(("criterion", "method", "fewest poses", "condition"), *rows))
