"""`hexcite poses`: chooses poses for quasi-static identification and writes a plan folder."""

from pathlib import Path
from typing import Annotated, Any

import hexcite as hx
from cases.base.folder_kinds import PLAN
from cases.base.output_places import check_folder, output_place
from hexcite.cli import console
from hexcite.cli.console import argument, option, out
from hexcite.cli.declared import takes
from identification.texts import aligned
from planner.options import PoseOptions


@takes(PoseOptions)
def poses(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    at: Annotated[Path | None, option("CSV of poses of one's own: what they are worth beside chosen ones.")] = None,
    least: Annotated[
        bool,
        option("Say the fewest poses of each criterion (Algorithm 1 until rank is lost) and write nothing.", "--least"),
    ] = False,
    output: Annotated[Path | None, out("Folder to write; named after the case by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
    **options: Any,
) -> None:
    """Choose the most informative poses to stand still at.

    They are visited in a short order.
    """
    from cases.tables import find_case
    from identification.model.model import static_model
    from planner.known import load_known

    loaded = hx.load_case(case)
    if least:
        model = static_model(loaded) if options["model"] is None else options["model"]
        _say_least(loaded, model, options["candidates"], options["seed"], json)
        return
    folder = output_place(output, Path(f"{loaded.name}-poses"), overwrite)
    check_folder(folder, PLAN, [find_case(case)], overwrite)
    options["known"] = load_known(options["known"] or (), loaded)
    with console.status("choosing poses", json) as remark:
        plan = hx.plan_poses(loaded, at, progress=lambda rest: remark(f"{rest} poses"), **options)
    with console.status("writing", json):
        console.save_with_page(plan, PLAN, folder, overwrite)
    answer = {"plan": str(folder), "report": str(folder / "report.html")} | plan.to_json()
    answer.pop("moves")
    answer["identifiability"] = (identifiable := hx.identifiability(plan)).to_json()
    texts = (f"identifiability: {identifiable.words}",) if identifiable.sentences else ()
    console.answered(answer, json, f"plan written: {folder}, with its report {folder}/report.html", plan, *texts)


def _say_least(case: "hx.Case", model: int, candidates: int | None, seed: int, json: bool) -> None:
    """Prints the fewest poses of each criterion."""
    from planner.poses.planned_poses import least_poses
    from planner.request import PoseRequest

    with console.status("removing poses", json) as remark:
        counts = least_poses(
            PoseRequest(model=model, candidates=candidates, seed=seed), case, lambda rest: remark(f"{rest} poses")
        )
    rows = [(each.criterion, each.method, str(each.poses), f"{each.condition:.4g}") for each in counts]
    answer = {"model": model, "least": [each._asdict() for each in counts]}
    console.answered(answer, json, *aligned(("criterion", "method", "fewest poses", "condition"), *rows))
