"""`hexcite identify`: parameters with error bars from a recording; `hexcite look`: what one of unknown format holds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict

import typer

import hexcite as hx
from cases.base.errors import Code, IdentificationError, RecordingError, printable
from cases.base.folder_kinds import RESULT
from cases.base.options import Option, default_of
from cases.base.output_places import check_file, check_folder, output_place
from cases.editing import Change
from hexcite.cli import console
from hexcite.cli.advice import advice
from hexcite.cli.cases import toml_shown
from hexcite.cli.console import argument, option, out
from hexcite.cli.declared import takes
from identification.options import (
    MODEL,
    PLAN,
    POSES,
    PRIORS,
    AverageStandstills,
    Dropped,
    Known,
    LoadFrame,
    TreatmentOptions,
    Weights,
)
from identification.texts import aligned, carries_rods, value_cells

if TYPE_CHECKING:
    from cases.base.units import Array


class MethodOptions(TypedDict, total=False):
    """What is known beforehand, and how residuals are weighed: fields of `Method`, and in their place two words."""

    weights: Weights
    known: Known
    dropped: Dropped
    priors: Annotated[Sequence[Any], PRIORS]
    symmetric: Annotated[
        bool, Option("A symmetric platform without accessories: xC = yC = 0, I12 = I13 = I23 = 0.", False)
    ]
    estimator: Annotated[
        str,
        Option(
            "linear (17)-(22), or nonlinear: the form (18) by its local Jacobian, where central inertia can be fixed "
            "too.",
            "linear",
        ),
    ]


@takes(MethodOptions, TreatmentOptions)
def identify(
    recordings: Annotated[
        list[Path],
        argument(
            "One run: a file, several files of it in any order (drives and forces, say), or a folder of hexcite run. "
            "With --runs each is a run of its own."
        ),
    ],
    case: console.OwnCase = None,
    model: Annotated[str | None, MODEL] = None,
    plan: Annotated[Path | None, PLAN] = None,
    poses: Annotated[Path | None, POSES] = None,
    average_standstills: AverageStandstills = default_of(AverageStandstills),
    runs: Annotated[
        bool,
        option(
            "Each recording is a whole run of the same thing: identify each with the same options, and pool them as "
            "hexcite pool does. Without it several files are pieces of one run.",
            "--runs",
        ),
    ] = False,
    frame: LoadFrame = default_of(LoadFrame),
    verify: Annotated[Path | None, option("Predict this second run with the parameters of the first.")] = None,
    output: Annotated[Path | None, out("Folder to write; RECORDING-result by default, pooled with --runs.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
    progress: Annotated[
        bool,
        option("With --json: say on stderr what a search for a cause tries, a JSON object a line.", "--progress"),
    ] = False,
    **options: Any,
) -> None:
    """Identify parameters from a recorded run.

    Standard deviations: `std` by (28), right where noise is white; `std_robust` allows for noise that is not. The
    larger of the two is what to report. Exit code 1 where the case states [accept] and the result fails it.
    """
    from hexcite.cli.method_options import method_of, treatment_of
    from identification.recording.formats.reading import files_of
    from identification.recording.formats.table import require_file
    from identification.results.frames import frame_named

    if verify is not None:
        require_file(files_of([verify])[0])  # before a result is written
    if runs:
        _require_runs(recordings, model, options["priors"])
    folder = output_place(output, Path("pooled" if runs else f"{recordings[0].resolve().stem}-result"), overwrite)
    check_folder(folder, RESULT, recordings, overwrite)
    with (
        console.remedies(json),
        console.status("identifying", json) as remark,
        console.causes_followed(remark, json and progress),
    ):
        treatment = treatment_of(**{field.name: options.pop(field.name) for field in fields(TreatmentOptions)})
        own_case = None if case is None else hx.load_case(case)
        named = None if plan is None else hx.Plan.load(plan, own_case, stale=True)
        how = partial(method_of, **options)
        evaluation = _Evaluation(own_case, named, poses, model, how, average_standstills, treatment, frame, stale)
        choice, single = None, dict[Path, hx.Result]()
        if runs:
            places = _places_of_runs(recordings)
            single = {place: _of_run(file, evaluation) for place, file in places.items()}
            result = hx.pool([*single.values()])
        else:
            result, choice = evaluation.result(recordings)
        body = None if frame is None else result.in_frame(frame_named(frame))
        console.save_with_page(result, RESULT, folder, overwrite, single)
    beside: dict[str, Any] = {} if body is None else {"in_frame": body}
    beside |= {} if choice is None else {"models": choice}
    beside |= {} if verify is None else {"verify": hx.verify(hx.read(verify, result.case), result)}
    _answer(result, folder, single, beside, json)


@dataclass(frozen=True, slots=True)
class _Evaluation:
    """How runs are evaluated, as it was typed."""

    case: "hx.Case | None"  # None: that of the plan or the run
    plan: "hx.Plan | None"  # None: the one at hand
    poses: Path | None
    model: str | None
    how: "Callable[[hx.Model], hx.Method]"
    average_standstills: bool
    treatment: "hx.Treatment | None"
    frame: str | None
    stale: bool

    def result(self, files: list[Path]) -> "tuple[hx.Result, hx.ModelChoice | None]":
        """The result of one run, and all models of it where they are asked for."""
        from hexcite.cli.method_options import number_of
        from planner.plans.at_hand import plans_at_hand

        run, choice = self._run(files), None
        poses = self._poses(run)
        if self.model == "all":
            choice = hx.identify_models(run, how=self.how, average_standstills=self.average_standstills, poses=poses)
        number = None if self.model is None else number_of(self.model) if choice is None else choice.best
        result = hx.identify(
            run,
            model=number,
            how=self.how,
            average_standstills=self.average_standstills,
            poses=poses,
            plan=plans_at_hand(run) if self.plan is None else self.plan,
            treatment=self.treatment,
        )
        return (result, None) if choice is None else (result.chosen_among(choice.to_json()), choice)

    def _run(self, files: list[Path]) -> "hx.Recording":
        """A run, which has the frame that the load is to be stated in."""
        from identification.recording.recording import record_of
        from identification.results.frames import place_of

        of_plan = self.plan.case if self.plan is not None and record_of(files[0]) is None else None
        run = hx.Recording.load(files, of_plan if self.case is None else self.case, self.stale)
        if self.frame is not None:
            place_of(run.machine_case(), self.frame)  # before anything is computed
        return run

    def _poses(self, run: "hx.Recording") -> "Array | None":
        """Poses of the plan that was named for them."""
        if self.poses is None:
            return None
        plan = hx.Plan.load(self.poses, run.case, stale=True)  # of a plan of poses only these are wanted
        if not len(plan.poses):
            raise hx.HexciteError(
                place=self.poses,
                problem=f"is a plan of family {plan.family}, not of poses",
                remedy="name one of hexcite poses",
                code=Code.WRONG_KIND,
            )
        return plan.poses


def _answer(
    result: "hx.Result", folder: Path, single: "Mapping[Path, hx.Result]", beside: Mapping[str, Any], json: bool
) -> None:
    """Prints a result that was written, with what was asked for beside it; ends with exit code 1 where it fails.

    Args:
        single: results of single runs, by their places in the folder.
        beside: values that were asked for, by their keys in JSON.
    """
    from hexcite.cli.method_options import answer_of_result

    answer = answer_of_result(result, folder)
    texts: list[object] = [f"result written: {folder}, with its report {folder}/report.html"]
    if single:
        answer["runs"] = [answer_of_result(of, folder / place) for place, of in single.items()]
        texts.extend(_lines_of_runs(folder, single))
    verdict = None if result.case.accept is None else hx.accept(result)
    if verdict is not None:
        answer["accept"] = verdict.to_json()
        texts.append(verdict)
    answer |= {key: value.to_json() for key, value in beside.items() if key != "models"}  # the result has these
    console.answered(answer, json, *texts, result, *beside.values(), *advice(answer))
    if verdict is not None and not verdict.passed:
        raise typer.Exit(1)


def _require_runs(recordings: Sequence[Path], model: str | None, prior: Sequence[str] | None) -> None:
    """Refuses, before anything is computed, what no runs can be pooled with."""
    if len(recordings) < 2:
        raise hx.HexciteError(
            place="--runs",
            problem="1 recording",
            remedy="name two runs or more, or leave --runs out",
            code=Code.TOO_FEW,
        )
    if model == "all":
        raise hx.HexciteError(
            place="--model all",
            problem="may keep another model of each run",
            remedy="give one number for all with --runs",
            code=Code.CONTRADICTION,
        )
    if prior:
        problem = "would be counted with each run"
        raise hx.HexciteError(
            place=f"--prior {prior[0]}",
            problem=problem,
            remedy="leave it out with --runs, or state an exact value by --fix",
            code=Code.CONTRADICTION,
        )


def _places_of_runs(recordings: Sequence[Path]) -> dict[Path, Path]:
    """Recordings by the folder that each one's result gets, in that of the pooled one; each name is there once."""
    places = dict[Path, Path]()
    for file in recordings:
        stem = file.resolve().stem
        names = (stem if k == 1 else f"{stem}-{k}" for k in count(1))
        places[next(place for name in names if (place := Path("runs", name)) not in places)] = file
    return places


def _of_run(file: Path, evaluation: _Evaluation) -> "hx.Result":
    """The result of one run of several; an error names it."""
    try:
        return evaluation.result([file])[0]
    except (RecordingError, IdentificationError) as error:
        raise error.at(str(file)) from error


def _lines_of_runs(folder: Path, single: Mapping[Path, "hx.Result"]) -> list[str]:
    """A table of the runs: mass, or of a model without one the first parameter, and where each result is."""
    rows = []
    for place, of in single.items():
        name = "m" if "m" in of.parameters else next(iter(of.parameters))
        words, value, deviation, *_, unit = value_cells(name, of.parameters[name], carries_rods(of.parameters))
        rows.append((of.source, f"{words} = {value} +- {deviation} {unit}", str(folder / place)))
    return aligned(("run", "by itself", "its result"), *rows)


def look(
    recordings: Annotated[
        list[Path],
        argument("File of unknown format, text or Parquet, the files of one run, or the folder of a ROS 2 bag."),
    ],
    case: Annotated[
        str | None, option("Built-in name, folder or file: by its machine units are known, and what is missing.")
    ] = None,
    write: Annotated[
        str | None,
        option(
            "Folder or file of a case, whose [recording] becomes the proposal; all else in it, comments too, stays."
        ),
    ] = None,
    output: Annotated[
        Path | None, out("Picture to write; RECORDING-look.svg by default, more pages beside it.")
    ] = None,
    overwrite: Annotated[
        bool, option("Replace earlier pictures, and with --write what the case states otherwise.", "--overwrite")
    ] = False,
    json: console.Json = False,
) -> None:
    """Propose how a file of unknown format is read, and try that.

    Compare the proposal with what you know, and paste it into the case file, or let --write do that. Exit code 1: the
    file is not read with the proposal.
    """
    if write is not None and case is not None and hx.load_case(write).origin != hx.load_case(case).origin:
        raise hx.HexciteError(
            place=write,
            problem=f"is not the case that --case names, {case}",
            remedy="name one of them",
            code=Code.OTHER_SOURCE,
        )
    named = case if write is None else write
    file = output_place(output, Path(f"{recordings[0].stem}-look.svg"), overwrite)
    check_file(file, (".svg", ".png", ".pdf"), recordings, overwrite)
    with console.status("looking", json):
        report = hx.look(recordings, None if named is None else hx.load_case(named))
        changes = () if write is None or not report.reads else report.write(write, overwrite)
        pictures = _draw(report, file, overwrite)
    answer = report.to_json() | {
        "picture": str(pictures[0]) if pictures else None,
        "pictures": [str(picture) for picture in pictures],
        "changes": [{"key": key, "before": before, "after": after} for key, before, after in changes],
    }
    rows = ([printable(c.name), c.ours or "-", f"{c.unit} (a guess)" if c.guessed else c.unit] for c in report.columns)
    table = aligned(("column", "meaning", "unit"), *rows) if report.columns else []
    texts = [*report.remarks, *table, report.toml, *(f"picture written: {picture}" for picture in pictures)]
    console.answered(answer, json, *texts, *_end_of_look(report, write, changes), *advice(answer))
    if not report.reads:
        raise typer.Exit(1)


def _end_of_look(report: "hx.Look", write: str | None, changes: Sequence[Change]) -> list[str]:
    """What to do next, or what was written."""
    if not report.reads:
        nothing = "nothing was written: " if write is not None else ""
        return [f"{nothing}the file is not read with this table yet; complete it as said above, then look again"]
    if write is not None and changes:
        lines = [f"{key}: {toml_shown(before)} -> {toml_shown(after)}" for key, before, after in changes]
        return [f"written into {write}:", *(f"  {line}" for line in lines)]
    if report.unchanged:
        return ["the [recording] of the case reads this file; nothing is to be changed"]
    return ["paste the table into case.toml in place of its [recording], or run this again with --write CASE"]


def _draw(report: "hx.Look", file: Path, overwrite: bool) -> list[Path]:
    """Writes the pictures of a look, a file a page, of PDF all pages in one; returns their paths."""
    if not any(len(column.values) for column in report.columns):
        return []
    from hexcite.reports.look import look_pages, save_pages

    return save_pages(look_pages(report), file, overwrite)
