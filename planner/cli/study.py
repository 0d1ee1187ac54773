"""`hexcite study`: grids of plans, runs and identifications on a Dask cluster, resumable."""

from pathlib import Path
from typing import Annotated, Any

from planner.cli.console import Json, Workers, answered, argument, option, out, print_table, progress


def study(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    spec: Annotated[str, option("TOML file of the study, or a built-in one: paper, validation.")],
    scheduler: Annotated[
        str | None, option("Running Dask scheduler, tcp://host:port; by default this computer's cores.")
    ] = None,
    workers: Workers = None,
    output: Annotated[Path | None, out("Study folder; continued if it is there.")] = None,
    json: Json = False,
) -> None:
    """Plan, run and identify every cell of a grid of settings.

    It can be stopped at any time: the same command goes on.
    """
    import os
    import time

    from cases.errors import HexciteError, Interrupted
    from cases.files import read_json, write_text
    from cases.loading import load_case
    from planner.study import ABOUT, DONE, PLANNED, check_study, load_spec, read_rows
    from planner.study.cluster import local_client, remote_client, require_dask
    from planner.study.study_run import about_study, cells_of, missing, run_study
    from planner.study.summary import best_groups, groups, study_page

    loaded, asked = load_case(case), load_spec(spec)
    loaded.need_motion("a study")
    if asked.execute is not None:
        loaded.need_simulation("a study that executes its plans")
    if scheduler is not None and workers is not None:
        raise HexciteError("--workers counts processes on this computer, --scheduler names another cluster; drop one")
    if workers is not None and not 1 <= workers <= 1000:
        raise HexciteError(f"{workers} workers; choose --workers 1 to 1000, by default one a core")
    require_dask()
    folder = output if output is not None else Path(f"{loaded.name}-{asked.name}-study")
    cells = cells_of(asked, loaded)
    check_study(folder, about_study(asked, loaded, len(cells)))
    number = len(missing(cells, asked, folder))
    start, busy = time.perf_counter(), 0.0
    threads = workers or os.cpu_count() or 1
    computed = 0
    if number or not (folder / ABOUT).exists():
        context = local_client(workers, asked.cells.memory_GB) if scheduler is None else remote_client(scheduler)
        try:
            with context as client, progress("cells", number, json) as count:
                start = time.perf_counter()
                threads = sum(client.nthreads().values())
                if not json:
                    print(f"Study {asked.name} of {loaded.name}: {number} of {len(cells)} cells to do, in {folder}")

                def on_end(end: Any) -> None:
                    nonlocal busy
                    busy += end.seconds
                    count("" if end.reason is None else "(the last one failed)", 1)

                computed = run_study(client, asked, loaded, folder, on_end)
        except Interrupted:
            raise Interrupted(f"what is done is kept in {folder}, the same command goes on") from None
    seconds = time.perf_counter() - start
    table = read_rows(folder)
    best = best_groups(groups(table))
    report = folder / "report.html"
    write_text(report, study_page(read_json(folder / ABOUT, "hexcite study"), table))
    plans = [
        s for s, n in zip(table["status"].to_pylist(), table["noise_seed"].to_pylist(), strict=True) if n == PLANNED
    ]
    answer = {
        "study": str(folder),
        "cells": len(cells),
        "computed": computed,
        "done": plans.count(DONE),
        "failed": len(plans) - plans.count(DONE),
        "rows": len(table),
        "seconds": seconds,
        "overhead": seconds * threads / busy if busy else None,
        "best": {letter: {**group.settings, "score": group.best} for letter, group in best.items()},
        "report": str(report),
    }
    if not answered(answer, json):
        _show(answer, best, case)


def _show(answer: dict[str, Any], best: dict[str, Any], case: str) -> None:
    from planner.study.summary import command_of

    rows = [
        [letter, command_of(group.settings, case), f"{group.best:.4g}", f"{group.median:.4g}", f"{group.done}"]
        for letter, group in sorted(best.items())
    ]
    print_table(
        "Best settings of each criterion", ("criterion", "command", "best", "median", "plans"), rows, right=False
    )
    print(f"{answer['done']} cells done, {answer['failed']} failed, {answer['computed']} of them now")
    if answer["overhead"] is not None:
        print(f"study time x cores / time in cells: {answer['overhead']:.2f}")
    print(f"report written: {answer['report']}")
