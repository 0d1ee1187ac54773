"""`hexcite plan`: optimises an excitation and writes a plan folder."""

import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Annotated, Any

import typer

import hexcite as hx
from cases.base.errors import Code
from cases.base.folder_kinds import PLAN
from cases.base.options import options_of
from cases.base.output_places import check_folder, output_place
from hexcite.cli import console
from hexcite.cli.advice import advice
from hexcite.cli.console import argument, option, out
from hexcite.cli.declared import takes
from planner.options import FAMILY_WORDS, OF_FAMILIES, Duration, PlanOptions

if TYPE_CHECKING:
    from planner.plans.progress import Standing

SEARCHED = (
    "duration",
    "target",
    "starts",
    "seconds",
    "seed",
    "solver",
    "workers",
)  # options of families that are optimised
FLAGS = {"duration": "duration"} | {
    each.name: each.flag for kind in (PlanOptions, *OF_FAMILIES.values()) for each in options_of(kind)
}
"""Names on the command line, without dashes, by those of the library."""


@takes(PlanOptions, families=OF_FAMILIES, but=("payload_from",))
def plan(
    context: typer.Context,
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    family: Annotated[
        str | None,
        option("Family of motions: manual, fourier, ptp, spline; by default the best of the last three, by trying."),
    ] = None,
    duration: Duration = None,
    output: Annotated[Path | None, out("Folder to write; named after case and family by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
    progress: Annotated[
        bool, option("With --json: say on stderr how the search gets on, a JSON object a line.", "--progress")
    ] = False,
    **options: Any,
) -> None:
    """Find the most informative motion inside the machine's limits.

    Ctrl-C ends the search and keeps the best motion found so far; a second one gives up.
    """
    began = time.monotonic()  # before what follows is loaded
    from identification.model.model import full_model
    from planner._plan import planned, request_of
    from planner.families.settings import Best, family_class
    from planner.known import load_known
    from planner.plans.making import require_plannable
    from planner.request import OWNERS
    from planner.search.parallel import first_ctrl_c

    sources = {name: context.get_parameter_source(name) for name in (*SEARCHED, *OWNERS)}
    typed_options = [o for o, source in sources.items() if source and source.name != "DEFAULT"]
    if family is None and (owners := [OWNERS[o] for o in typed_options if o in OWNERS]):
        family = owners[0]  # to whom the first option belongs
    kind = Best if family is None else family_class(family)
    if family is not None:
        refuse_foreign(typed_options, family)
    of_families = {name: options.pop(name) for name in OWNERS}
    family_settings = kind(**{name: value for name, value in of_families.items() if OWNERS[name] == family})
    options["payload"], options["payload_from"] = read_payloads(options["payload"])
    loaded = hx.load_case(case)
    options["known"] = load_known(options["known"] or (), loaded)
    if options["model"] is None:
        options["model"] = options["known"][0].record.model if options["known"] else full_model(loaded)
    options["target"] = targets_of(options["target"] or (), loaded, options["model"])
    request = request_of(loaded, family_settings, duration, **options)
    folder = output_place(output, Path(f"{loaded.name}-{family or 'plan'}"), overwrite)
    check_folder(folder, PLAN, overwrite=overwrite)
    require_plannable(request, loaded)  # before anything is said
    optimised = family_settings.optimised
    if not json:
        words = FAMILY_WORDS.get(family or "", "any family")
        motion = f"{'up to ' if request.target else ''}{request.duration:g} s, criterion {request.criterion}, "
        console.say(f"Planning for {loaded.name}: {words}, {motion if optimised else ''}model {request.model}")
    with console.status("searching" if optimised else "timing", json) as remark:
        shown = with_page_at_hand(console.as_lines() if json and progress else remark)
        result = planned(request, loaded, shown, began)
    with console.status("writing", json), first_ctrl_c():  # this takes a short time
        console.save_with_page(result, PLAN, folder, overwrite)
    written = f"plan written: {folder}, with its report {folder}/report.html"
    identifiable = hx.identifiability(result)
    answer = answer_of_plan(result, folder) | {"identifiability": identifiable.to_json()}
    determined = [f"identifiability: {identifiable.words}"] if identifiable.sentences else []
    console.answered(answer, json, written, result, *advice(answer), *determined)


def with_page_at_hand(remark: "Callable[[Standing], None]") -> "Callable[[Standing], None]":
    """A remark that also loads what pages need, beside the refinements: a processor is idle in the last of them."""

    def load() -> None:
        from hexcite.reports import plan
        from hexcite.reports.drawing import still

        del plan, still  # that they are loaded is all

    loading = Thread(target=load, daemon=True)

    def shown(standing: "Standing") -> None:
        if standing.refining and loading.ident is None:
            loading.start()
        remark(standing)

    return shown


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
        name = FLAGS[given_option]
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
