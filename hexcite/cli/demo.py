"""`hexcite demo`: the whole chain on one case, from its description to a report."""

from pathlib import Path
from typing import Annotated, Any

import hexcite as hx
from cases.base.atomic import write_text
from cases.base.folder_kinds import DEMO
from cases.base.options import default_of
from cases.base.output_places import check_folder, output_place
from hexcite.cli.console import Json, Overwrite, answered, option, out, say
from hexcite.cli.declared import takes
from hexcite.options import DemoController, DemoSeed, DemoStarts
from identification.texts import aligned


@takes()
def demo(
    case: Annotated[str, option("Built-in name, folder or case file, with a simulated machine.")] = "hexapod",
    on: DemoController = default_of(DemoController),
    seed: DemoSeed = default_of(DemoSeed),
    starts: DemoStarts = default_of(DemoStarts),
    output: Annotated[Path | None, out("Folder for everything; hexcite-demo by default.")] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Show the whole chain on a machine, from plan to report.

    A manual motion, a Fourier series and moves go the same way and are compared with the truth.
    """
    from hexcite.cli.method_options import answer_of_result
    from hexcite.cli.plan import answer_of_plan
    from hexcite.cli.programs import answer_of_program, answer_of_proof, answer_of_run
    from hexcite.reports.demo import MOTION_COLUMNS, TRUTH_COLUMNS, demo_page, motion_rows, truth_cells

    loaded = hx.load_case(case)
    place = output_place(output, Path("hexcite-demo"), overwrite)
    check_folder(place, DEMO, overwrite=overwrite)
    chain = hx.demo(
        loaded,
        place,
        on,
        seed=seed,
        starts=starts,
        overwrite=overwrite,
        progress=lambda line: None if json else say(line),
    )
    for each in chain.all:
        home = place if each is chain.moves else place / each.plan.family
        for value, folder in ((each.plan, "plan"), (each.result, "result")):
            hx.report(value, home / folder / "report.html")
    answer: dict[str, Any] = {
        "plan": answer_of_plan(chain.plan, place / "plan"),
        "post": answer_of_program(chain.program),
        "check": answer_of_proof(chain.program),
        "run": answer_of_run(chain.recording, place / "recording"),
        "identify": answer_of_result(chain.result, place / "result"),
        "truth": list(chain.truth),
        "comparison": chain.comparison.to_json(),
        "motions": [dict(zip(MOTION_COLUMNS, row, strict=True)) for row in motion_rows(chain)],
        "left_out": list(chain.left_out),
        "faster": list(chain.faster),
    }
    file = place / "report.html"
    write_text(file, demo_page(chain))
    summary = {"report": str(file), "controller": answer["run"]["controller"], "worst_error_in_std": chain.worst}
    table = aligned(TRUTH_COLUMNS, *map(truth_cells, chain.truth))
    error = f"largest error: {chain.worst:.2f} reported standard deviations"
    motions = aligned(MOTION_COLUMNS, *motion_rows(chain))
    answered(summary | answer, json, *table, error, *motions, f"report written: {file}")
