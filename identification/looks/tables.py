"""The look at tables of text or Parquet: the proposal for each file of a run, and for the run."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from cases.base.errors import Code, RecordingError
from cases.base.phrases import Phrase, phrase, said
from cases.base.units import Array
from cases.machine import POSE
from cases.orientation import ANGLES, QUATERNION, ROTATION
from cases.recording_format import CLOCK, DRIVES, TICKS, FileFormat, RecordingFormat
from cases.schema import Case
from identification.looks.look import Column, FileLook, Look
from identification.looks.trial import Trial, sentences_of, trial_of
from identification.recording.formats.layout import TextColumns, look_at_text
from identification.recording.formats.names.misnamed import ALIKE, SMOOTH
from identification.recording.formats.proposal import LAYOUT, Proposal, proposed, stated_of
from identification.recording.formats.proposal_of_run import missing_parts, proposal_of_run
from identification.recording.formats.reading import is_parquet
from identification.recording.formats.reasons import NO_REASON


def says_how(case: Case) -> bool:
    """Whether the case states more of its recordings than a filter and a rate."""
    return bool(case.recording.model_fields_set - {"filter_cutoff_Hz", "rate_Hz"})


def look_at_tables(files: Sequence[Path], case: Case | None, refusal: str | None) -> Look:
    """The look at tables of text or Parquet; `refusal`: why the [recording] of the case does not read them."""
    reads = case is not None and says_how(case) and refusal is None
    laid_out = None if reads or case is None else _as_laid_out(files, case)
    if laid_out is not None:
        proposals, settings, trial = laid_out
    else:
        read_files = [
            (file, *(_as_stated(file, case) if reads and case is not None else (_table(file), case))) for file in files
        ]
        proposals = [(file, table, proposed(table, its_case, reads)) for file, table, its_case in read_files]
        settings = proposal_of_run([(file.name, proposal) for file, _, proposal in proposals])
        if reads and case is not None and case.recording.files:
            settings = stated_of(case.recording)
        trial = trial_of(files, settings, case)
    problem = trial.problem
    whole = {ours for _, _, proposal in proposals for ours in proposal.places}
    doubts = [
        _in_file(file, doubt) if len(files) > 1 else doubt
        for file, _, proposal in proposals
        for doubt in (*proposal.doubts, *missing_parts(proposal.places, whole, proposal.settings))
    ]
    if refusal not in (None, problem) and not any("which the file does not have" in doubt for doubt in doubts):
        doubts.insert(
            0,
            phrase(
                "does_not_read", "the [recording] that the case has does not read it: {why}", why=said(refusal or "")
            ),
        )
    for file, table, proposal in proposals:
        unnamed = list(_of_unnamed(table, proposal))
        doubts += [_in_file(file, sentence) for sentence in unnamed] if len(files) > 1 else unnamed
    doubts += _of_another_file(files, whole, case)
    unchanged = case is not None and trial.form == case.recording
    tables = settings.get("files", ())
    parts = tuple(
        FileLook(file, tuple(_columns(table, proposal)), _table_of(file, k, tables, proposal), proposal.setting_reasons)
        for k, (file, table, proposal) in enumerate(proposals)
    )
    columns = [column for part in parts for column in part.columns]
    rows = max((len(column.values) for column in columns), default=0)
    rate = max((proposal for _, _, proposal in proposals), key=lambda proposal: proposal.has_forces).rate
    file = files[0]
    odd = sentences_of(problem, [*doubts, *trial.doubts])
    repairs = tuple(each for each in trial.repairs if each not in odd)
    others = tuple(files[1:])
    return Look(file, rows, tuple(columns), settings, odd, problem, unchanged, (), rate, others, parts, repairs)


def _in_file(file: Path, sentence: Phrase) -> Phrase:
    return phrase("in_file", "{file}: {sentence}", file=file.name, sentence=sentence)


_Proposals = list[tuple[Path, TextColumns, Proposal]]


def _as_laid_out(files: Sequence[Path], case: Case) -> "tuple[_Proposals, dict[str, Any], Trial] | None":
    """Proposals for files that are laid out as the case states; None where it states no layout, or they do not read.

    What columns mean is proposed then, by the names that the files have in this layout.
    """
    layout = {key: value for key, value in stated_of(case.recording).items() if key in LAYOUT}
    if not layout or case.recording.files:
        return None
    proposals: _Proposals = []
    for file in files:
        try:
            form = FileFormat.model_validate(layout)
            table = replace(_table(file, form), settings=layout)
        except (RecordingError, ValidationError):  # of another layout, which is looked for
            return None
        proposals.append((file, table, proposed(table, case)))
    settings = proposal_of_run([(file.name, proposal) for file, _, proposal in proposals])
    trial = trial_of(files, settings, case)
    return (proposals, settings, trial) if trial.problem is None else None


def _table_of(file: Path, k: int, tables: Sequence[Mapping[str, Any]], proposal: Proposal) -> int | None:
    """Which of the tables of a run's files is that of a file: that whose pattern or columns it has, else the k-th."""
    if not tables:
        return None
    named = [n for n, table in enumerate(tables) if "match" in table and fnmatch(file.name, table["match"])]
    whole = [n for n, table in enumerate(tables) if {*table.get("columns", {}).values()} <= {*proposal.names}]
    free = [n for n in whole if "match" not in tables[n]]
    return next(iter(named or free), k if k < len(tables) else None)


def _of_unnamed(table: TextColumns, proposal: Proposal) -> Iterator[Phrase]:
    """What the columns of a file without names may be by their values; nothing is proposed for them."""
    sentences = [
        phrase("no_name", "{name} has no name: {what}", name=name, what=_by_values(table.numbers[k]))
        for k, name in enumerate(proposal.names)
        if name == f"column {k + 1}" and k in table.numbers and k not in proposal.places.values()
    ]
    yield from sentences
    if sentences:
        yield phrase(
            "name_all",
            "list the names of all columns in recording.column_names, in their order; nothing is guessed from values",
        )


def _by_values(values: Array) -> Phrase:
    """What numbers of a column, shape (n,), look like."""
    finite = values[np.isfinite(values)]
    if len(finite) < 3:
        return phrase("few_numbers", "too few numbers to say what it is")
    low, high, steps = float(finite.min()), float(finite.max()), np.diff(finite)
    if low == high:
        text = f"{low:.6g}"
        return phrase("constant_value", "{value} all along, as a constant or a switch that is never used", value=text)
    if np.isin(finite, (low, high)).all():
        ends = {"low": f"{low:.6g}", "high": f"{high:.6g}"}
        return phrase("two_values", "{low} or {high}, as a switch; a trigger, perhaps", **ends)
    if steps.min() > 0.0 and np.ptp(steps) <= ALIKE * (usual := float(np.median(steps))):
        if usual == 1.0 and low == np.rint(low):
            return phrase(
                "rises_as_rows", "rises by {step} from row to row, as numbers of the rows", step=f"{usual:.6g}"
            )
        return phrase("rises_as_clock", "rises by {step} from row to row, as a clock", step=f"{usual:.6g}")
    bend = float(np.sqrt(np.mean(np.diff(steps) ** 2) / np.mean(steps**2)))
    ends = {"low": f"{low:.6g}", "high": f"{high:.6g}"}
    if bend < SMOOTH:
        return phrase("smooth_values", "{low} to {high}, smooth, as a position, angle or set point", **ends)
    return phrase("noisy_values", "{low} to {high}, with noise, as a force or moment", **ends)


def _of_another_file(files: Sequence[Path], whole: set[str], case: Case | None) -> Iterator[Phrase]:
    """What to say of a file that holds one half of a run: the other may be in a file of another recorder."""
    if case is None or case.setup == "1a" or len(files) > 1:
        return
    forces = whole >= {*case.sensor_frame.channels}
    turns = (POSE, ROTATION, QUATERNION, *((ANGLES,) if case.machine is None else ()))
    motion = any(whole >= {*group} for group in (case.drive_columns, DRIVES, *turns))
    if forces != motion:
        both = f"hexcite look {files[0].name} OTHER"
        if forces:
            yield phrase(
                "has_forces_alone",
                "it has forces and no pose; if another file of the run has them, name both: {both}",
                both=both,
            )
        else:
            yield phrase(
                "has_pose_alone",
                "it has pose and no forces; if another file of the run has them, name both: {both}",
                both=both,
            )


def _columns(table: TextColumns, proposal: Proposal) -> Iterator[Column]:
    """The columns of a file with their meaning."""
    ours_of = {k: ours for ours, k in proposal.places.items()}
    clock = table.numbers.get(proposal.places.get(CLOCK, -1))
    if clock is not None:
        with np.errstate(all="ignore"):  # stamps that are infinite are said to be
            clock = (clock - clock[0]) * TICKS[proposal.units[CLOCK]] / proposal.clock_counts
    for k, name in enumerate(proposal.names):
        if name:
            ours, values = ours_of.get(k), table.numbers.get(k, np.zeros(0))
            stamps = clock if clock is not None and len(clock) == len(values) else None
            unit, guessed = proposal.units.get(ours or "", ""), ours in proposal.guessed
            why = proposal.reasons.get(ours or "", NO_REASON)
            why_unit = proposal.unit_reasons.get(ours or "", NO_REASON)
            yield Column(name, ours, unit, guessed, values, stamps, why, why_unit)


def _table(file: Path, form: FileFormat | None = None) -> TextColumns:
    """The columns of a file; `form`: says how it is laid out, else that is found."""
    return _parquet(file) if is_parquet(file) else look_at_text(file, form)


def _as_stated(file: Path, case: Case) -> tuple[TextColumns, Case]:
    """The columns of a file that a case reads, and the case with the table of its [recording] that reads it."""
    ways = case.recording.ways(file.name)
    problem: RecordingError | None = None
    for form in ways:
        try:
            table = _table(file, form)
        except RecordingError as error:
            problem = error
            continue
        if len(ways) == 1 or {*form.columns.values()} <= {*table.names}:
            stated = {key: value for key, value in stated_of(form).items() if key != "match"}
            stated |= {k: v for k, v in stated_of(case.recording).items() if k in ("filter_cutoff_Hz", "rate_Hz")}
            layout = {key: value for key, value in stated.items() if key in LAYOUT}
            stated_case = case.model_copy(update={"recording": RecordingFormat.model_validate(stated)})
            return replace(table, settings=layout), stated_case
    raise problem or RecordingError(
        place=file, problem="fits several tables of the case", remedy="give each of them a match", code=Code.WRONG_KIND
    )


def _parquet(file: Path) -> TextColumns:
    """A Parquet file, which needs no settings."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(file)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(
            place=file, problem="is a damaged Parquet file", remedy="copy or export it again", code=Code.DAMAGED
        ) from error
    numbers = {
        k: np.asarray(table.column(k).cast(pa.float64(), safe=False).to_numpy())
        for k, kind in enumerate(table.schema.types)
        if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)
    }
    with_values = {k: values for k, values in numbers.items() if np.isfinite(values).any()}
    return TextColumns(table.schema.names, [], with_values, {}, None)
