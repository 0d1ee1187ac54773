"""`hexcite plan`: optimises an excitation and writes a plan folder."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

import hexcite as hx
from cases.base.errors import Code
from cases.base.files import PLAN, check_folder, output_place
from hexcite.cli import console
from hexcite.cli.console import argument, option, out

SEARCHED = (
    "duration",
    "target",
    "starts",
    "seconds",
    "seed",
    "solver",
    "workers",
)  # options of families that are optimised
OPTIONS = {"controller": "for"}  # options whose names differ from those of their parameters


def plan(
    context: typer.Context,
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    family: Annotated[
        str | None,
        option("Family of motions: manual, fourier, ptp, spline; by default the best of the last three, by trying."),
    ] = None,
    criterion: console.Criterion = "D",
    duration: Annotated[
        float | None,
        option(
            "Whole duration in s, by default 12; a multiple of --period where that is given. With --target the longest "
            "that is tried, by default 60."
        ),
    ] = None,
    target: Annotated[
        list[str] | None,
        option(
            "Standard deviation to reach: m=5g, xC=0.02mm. Repeatable. Plans the shortest motion whose predicted "
            "deviations reach all."
        ),
    ] = None,
    known: Annotated[
        list[Path] | None,
        option(
            "Result folder of an earlier run of the machine with the same load. Repeatable. Deviations and --target "
            "then hold for these results and the run together."
        ),
    ] = None,
    order: Annotated[int, option("fourier: harmonics, 1 to 7; 1 is ellipses, with ways in and out.")] = 5,
    period: Annotated[float | None, option("fourier: period in s; by default about 2, to fit --duration.")] = None,
    free_order: Annotated[bool, option("fourier: search the best order, 2 to 7.", "--free-order")] = False,
    free_period: Annotated[
        bool,
        option("fourier: optimise the period too; as many whole ones as fit into --duration.", "--free-period"),
    ] = False,
    centred: Annotated[bool, option("fourier: keep x0 in the middle of the motion box.", "--centred")] = False,
    equal_start: Annotated[
        bool, option("fourier: begin with all coefficients alike, to study solvers.", "--equal-start")
    ] = False,
    moves: Annotated[
        int | None,
        option("ptp: point-to-point moves, 8 to 64; by default the best of a few numbers, by trying."),
    ] = None,
    controller: Annotated[
        str | None,
        option(
            "ptp: plan with the time law of linuxcnc, virtual, sinumerik, twincat, setpoints, urscript or ros2; "
            "by default as the case says, else with limited jerk.",
            "--for",
        ),
    ] = None,
    without: Annotated[
        str | None,
        option(
            "ptp: jerk, which linuxcnc and urscript do not limit: moves with steps of acceleration, if the machine "
            "bears them."
        ),
    ] = None,
    knots: Annotated[int | None, option("spline: intervals, 20 to 150; by default ten a second, 150 at most.")] = None,
    sequence: Annotated[
        Path | None,
        option(
            "manual: TOML file of steps or CSV of poses; by default the case's manual.toml, else "
            "each coordinate in turn, then all at once."
        ),
    ] = None,
    model: Annotated[int | None, option("Identification model, 0 to 9; by default the largest of the machine.")] = None,
    payload: Annotated[
        str, option("How many of the case's payloads are mounted: a number, or a range such as 0-5.")
    ] = "0",
    starts: Annotated[
        int | None, option("Number of random starts, of that many choices at most; by default as many as pay.")
    ] = None,
    seconds: Annotated[
        float | None, option("How long to search in s, then to keep the best; by default as long as it pays.")
    ] = None,
    seed: Annotated[int, option("Seed of the random starts.")] = 0,
    solver: Annotated[
        str | None,
        option(
            "What optimises a start: ipopt (interior point), sqp, or active-set (quasi-Newton); by default active-set "
            "where few unknowns are explored (fourier), ipopt else."
        ),
    ] = None,
    workers: console.Workers = None,
    output: Annotated[Path | None, out("Folder to write; named after case and family by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
    progress: Annotated[
        bool, option("With --json: say on stderr how the search gets on, a JSON object a line.", "--progress")
    ] = False,
) -> None:
    """Find the most informative motion inside the machine's limits.

    Ctrl-C ends the search and keeps the best motion found so far; a second one gives up.
    """
    from identification.estimation.criteria import Criterion
    from identification.model.model import full_model
    from planner._plan import planned
    from planner.families.settings import Best, family_class
    from planner.known import Known, load_known
    from planner.plans.making import require_plannable
    from planner.request import DURATION, LONGEST_WANTED, OWNERS, Request, Solver
    from planner.search.parallel import first_ctrl_c

    options = context.params
    sources = {name: context.get_parameter_source(name) for name in (*SEARCHED, *OWNERS)}
    given = [o for o, source in sources.items() if source and source.name != "DEFAULT"]
    if family is None and (owners := [OWNERS[o] for o in given if o in OWNERS]):
        family = owners[0]  # to whom the first option belongs
    kind = Best if family is None else family_class(family)
    if family is not None:
        refuse_foreign(given, family)
    most, fewest = read_payloads(payload)
    loaded = hx.load_case(case)
    earlier = Known.of(load_known(known, loaded), loaded, most, standing=False) if known else None
    usual = full_model(loaded) if earlier is None else earlier.model
    number = usual if model is None else model
    targets = targets_of(target or (), loaded, number)
    if duration is None:
        duration = LONGEST_WANTED if targets else DURATION
    request = Request(
        kind(**{option: options[option] for option, owner in OWNERS.items() if owner == family}),
        duration=duration,
        criterion=Criterion(criterion),
        model=number,
        payload=most,
        payload_from=fewest,
        starts=starts,
        seed=seed,
        solver=None if solver is None else Solver(solver),
        workers=workers,
        seconds=seconds,
        target=targets,
        known=earlier,
    )
    optimised = request.family.optimised
    folder = output_place(output, Path(f"{loaded.name}-{family or 'plan'}"), overwrite)
    check_folder(folder, PLAN, overwrite=overwrite)
    require_plannable(request, loaded)  # before anything is said
    if not json:
        text = f"{'up to ' if targets else ''}{duration:g} s, criterion {criterion}, " if optimised else ""
        console.say(f"Planning for {loaded.name}: {family or 'any family'}, {text}model {request.model}")
    with console.status("searching" if optimised else "timing", json) as remark:
        result = planned(request, loaded, console.as_lines() if json and progress else remark)
    with console.status("writing", json), first_ctrl_c():  # this takes a short time
        console.save_with_page(result, PLAN, folder, overwrite)
    written = f"plan written: {folder}, with its report {folder}/report.html"
    told = hx.identifiability(result)
    answer = answer_of_plan(result, folder) | {"identifiability": told.to_json()}
    console.answered(answer, json, written, result, *([f"identifiability: {told.words}"] if told.sentences else []))


def read_payloads(text: str) -> tuple[int, int | None]:
    """The most payloads that may be mounted, and the fewest of a range such as 0-5; raises HexciteError."""
    match = re.fullmatch(r"(?:(\d{1,4})-)?(\d{1,4})", text.strip())
    if match is None:
        raise hx.HexciteError(
            problem=f"payload {text!r} is neither a number of payloads nor a range of them",
            remedy="give 2, or 0-5",
            code=Code.UNKNOWN,
        )
    return int(match[2]), None if match[1] is None else int(match[1])


def targets_of(texts: Sequence[str], case: "hx.Case", model: int) -> dict[str, float]:
    """Deviations to reach by parameter [SI]; raises HexciteError where one is not understood or stands twice."""
    from identification.model.model import identification_model
    from identification.model.parameters import physical_form
    from planner.request import read_value

    units = {p.name: p.unit for p in physical_form(identification_model(case, model)).parameters} if texts else {}
    targets: dict[str, float] = {}
    for text in texts:
        typed = read_value(text, units, "--target", "m=5g", model)
        if typed.std is not None:
            raise hx.HexciteError(
                place=f"--target {text}",
                problem="a deviation to reach has none of its own",
                remedy="write --target m=5g",
                code=Code.MISSING,
            )
        if typed.name in targets:
            raise hx.HexciteError(
                place=f"--target {text}",
                problem=f"{typed.name} has a target already",
                remedy="give one of them",
                code=Code.CONTRADICTION,
            )
        targets[typed.name] = typed.value
    return targets


def refuse_foreign(given: Sequence[str], family: str) -> None:
    """Refuses options of another family, and those that fix a setting which another option leaves free."""
    from planner.families.settings import FAMILIES
    from planner.request import OWNERS

    optimised = [name for name, kind in FAMILIES.items() if kind.optimised]
    for given_option in given:
        name = OPTIONS.get(given_option, given_option.replace("_", "-"))
        owners = optimised if given_option in SEARCHED else [OWNERS[given_option]]
        if family not in owners:
            raise hx.HexciteError(
                problem=f"--{name} does nothing with --family {family}",
                remedy=f"leave it out, or choose --family {', '.join(owners)}",
                code=Code.CONTRADICTION,
            )
        if given_option.startswith("free_") and (fixed := given_option.removeprefix("free_")) in given:
            raise hx.HexciteError(
                problem=f"--{fixed} does nothing with --free-{fixed}",
                remedy="leave out one of them",
                code=Code.CONTRADICTION,
            )


def answer_of_plan(plan: "hx.Plan", folder: Path) -> dict[str, Any]:
    """The JSON answer of a plan that was written."""
    return {"plan": str(folder), "report": str(folder / "report.html")} | plan.to_json()
