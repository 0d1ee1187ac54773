"""`hexcite study`: grids of plans, runs and identifications on a Dask cluster, resumable."""

from pathlib import Path
from typing import Annotated

import hexcite as hx
from cases.base.options import default_of
from hexcite.cli.console import Json, answered, argument, option, out, status
from hexcite.cli.declared import takes
from hexcite.options import Certificates, Insecure, OneProcess, Scheduler
from planner.options import Workers


@takes()
def study(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    spec: Annotated[str, option("TOML file of the study, or a built-in one: paper, validation.")],
    scheduler: Scheduler = default_of(Scheduler),
    certificates: Certificates = default_of(Certificates),
    insecure: Insecure = default_of(Insecure),
    workers: Workers = default_of(Workers),
    one_process: OneProcess = default_of(OneProcess),
    output: Annotated[Path | None, out("Study folder; continued if it is there.")] = None,
    json: Json = False,
) -> None:
    """Plan, run and identify every cell of a grid of settings.

    It can be stopped at any time: the same command goes on.
    """
    from hexcite.studies.spec import load_spec

    loaded, specification = hx.load_case(case), load_spec(spec)
    with status(f"study {specification.name} of {loaded.name}", json) as remark:
        result = hx.study(
            loaded,
            specification,
            output,
            workers=workers,
            scheduler=scheduler,
            certificates=certificates,
            insecure=insecure,
            one_process=one_process,
            progress=remark,
        )
    answer = {**result.to_json(), "report": str(result.write_page())}
    answered(answer, json, result, f"report written: {answer['report']}")
