"""A look at a file of unknown format: what its columns are likely to mean, and the table `[recording]` that reads it.

The proposal is tried: the file is read with it as `identify` reads it; and fitted, so that what refuses there is said
here too.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from cases.base.errors import CaseError, Code, FileProblem, HexciteError, RecordingError, option, printable
from cases.base.text_formats import toml_value
from cases.base.units import Array, as_html
from cases.editing import Change, changes_of, write_table
from cases.machine import POSE
from cases.orientation import QUATERNION, ROTATION
from cases.recording_format import CLOCK, DRIVES, TICKS, FileFormat, RecordingFormat
from cases.schema import Case
from cases.tables import built_in_cases, find_case
from identification.finding import Finding, Kind
from identification.identify import require_fit
from identification.recording.formats.binary import Topic
from identification.recording.formats.families import words_of
from identification.recording.formats.frames import is_stated, problem_of
from identification.recording.formats.layout import TextColumns, look_at_text
from identification.recording.formats.meaning import meaning_of
from identification.recording.formats.misnamed import ALIKE, SMOOTH
from identification.recording.formats.proposal import (
    CUTOFF_HZ,
    LAYOUT,
    Proposal,
    missing_parts,
    proposal_of_run,
    proposed,
    stated_of,
)
from identification.recording.formats.quantities import CONTRADICTED, contradiction
from identification.recording.formats.reading import is_bag, is_parquet, read_tables, recording_of
from identification.recording.formats.reasons import NO_REASON, Reason, Why, because
from identification.recording.formats.table import listed
from identification.recording.formats.topics import BagTopic, bag_topics
from identification.recording.recording import Recording, read
from identification.samples.moving_window import checked_filter, on_one_clock
from identification.samples.sample_checks import scan

MOST_FITTED = 200_000
"""Samples of a run that `look` fits; a longer one is read only, for that would take long."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the file."""

    name: str  # as the file has it
    ours: str | None  # our name of it; None: hexcite does not use it, or its meaning is unknown
    unit: str  # unit that the file is taken to use; empty where there is none
    guessed: bool  # whether meaning or unit follow from the values alone
    values: Array  # numbers, shape (n,); empty where the column holds text
    t: Array | None = None  # its own clock, shape (n,) [s]; None: that of the column `t_s`
    reason: Reason = NO_REASON  # why it is taken for what it is; empty where nothing is
    unit_reason: Reason = NO_REASON  # why it has this unit


@dataclass(frozen=True, slots=True)
class FileLook:
    """What one of the files of a run is likely to be."""

    file: Path
    columns: tuple[Column, ...]  # in the order of the file
    table: int | None  # position of its table in `files` of the settings; None: these are its table
    reasons: Mapping[str, Reason]  # key of its settings -> why it has this value


@dataclass(frozen=True, slots=True)
class Look:
    """What a file is likely to be."""

    file: Path
    rows: int  # number of rows of numbers; of a bag the messages that hexcite reads
    columns: tuple[Column, ...]  # in the order of the file
    settings: Mapping[str, Any]  # proposal for `[recording]` of the case, by key
    odd: tuple[str, ...]  # what to look at, one sentence each; first why the file is not read
    problem: str | None  # why the file is not read with these settings; None: it is
    unchanged: bool = False  # whether the settings are those that the case has
    topics: tuple[BagTopic, ...] = ()  # of a bag
    rate: float | None = None  # rows per second; None where there is no clock
    others: tuple[Path, ...] = ()  # more files of the run
    parts: tuple[FileLook, ...] = ()  # each file of the run, a bag apart
    repairs: tuple[str, ...] = ()  # what the reader does with what is not as it should be, and leaves out

    @property
    def reads(self) -> bool:
        """Whether the file is read with these settings."""
        return self.problem is None

    @property
    def toml(self) -> str:
        """The settings as a case file has them."""
        return "\n".join(_toml("[recording]", "recording", self.settings))

    def write(self, case: Path | str, overwrite: bool = False) -> tuple[Change, ...]:
        """Makes `[recording]` of a case file the proposal, and returns what changed; all else, comments too, stays.

        Args:
            case: folder or file; built-in cases are not written.
            overwrite: replace what the case states otherwise; keys that it does not state are added in any case.

        Raises:
            RecordingError: the file is not read with the proposal.
            FileProblem: the case states something else, and `overwrite` is not set; or it cannot be written.
        """
        if self.problem is not None:
            raise RecordingError(
                place=self.file,
                problem=f"is not read with the proposal: {self.problem}",
                remedy="nothing was written",
                code=Code.WRONG_KIND,
            )
        name = str(case)
        if name in built_in_cases():
            raise FileProblem(
                place=name,
                problem="is a built-in case",
                remedy=f"make your own with hexcite case new NAME --like {name}",
                code=Code.EXISTS,
            )
        file = find_case(name)
        if not overwrite and (stated := [c for c in changes_of(file, "recording", self.settings) if c[1] is not None]):
            listed_changes = "; ".join(f"{key} = {toml_value(old)}" for key, old, _ in stated)
            raise FileProblem(
                place=file,
                problem=f"states something else than the proposal: {listed_changes}",
                remedy=f"replace it with {option('overwrite')}",
                code=Code.EXISTS,
            )
        return write_table(file, "recording", self.settings)

    def __repr__(self) -> str:
        """What it is, what is doubtful, and the settings, in a few lines."""
        return "\n".join([*self.remarks, self.toml])

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines for people: the file, why it is not read, the topics of a bag, and the doubts."""
        doubts = self.odd if self.problem is None else self.odd[1:]
        listed_doubts = ["to be compared or completed:", *(f"  - {doubt}" for doubt in doubts)] if doubts else []
        problem = self.odd[:1] if self.problem is not None else ()
        mended = ["what the reader does with it:", *(f"  - {each}" for each in self.repairs)] if self.repairs else []
        topics = (f"  {printable(str(topic))}" for topic in self.topics)
        return (self.headline, *problem, *topics, *listed_doubts, *mended)

    __str__ = __repr__

    _repr_html_ = as_html

    @property
    def headline(self) -> str:
        """The file and its size, in a line."""
        rate = "" if self.rate is None else f", {self.rate:.4g} a second"
        if self.topics:
            return f"{printable(str(self.file))}: a bag of {len(self.topics)} topics"
        more = f" and {len(self.others)} more of the run" if self.others else ""
        return f"{printable(str(self.file))}{more}: {self.rows} rows{rate}, {len(self.columns)} columns"


def _toml(header: str, name: str, settings: Mapping[str, Any]) -> list[str]:
    """Lines of a table; columns and files have sections of their own."""
    lines = [header, *(f"{k} = {toml_value(v)}" for k, v in settings.items() if k not in ("columns", "files"))]
    if columns := settings.get("columns"):
        lines += ["", f"[{name}.columns]", *(f"{ours} = {toml_value(theirs)}" for ours, theirs in columns.items())]
    for table in settings.get("files", ()):
        lines += ["", *_toml(f"[[{name}.files]]", f"{name}.files", table)]
    return lines


def look(files: Path | str | Sequence[Path | str], case: Case | None = None) -> Look:
    """What a file of unknown format is likely to be, or the files of one run.

    >>> seen = hx.look("empty/recording.csv", hx.load_case("hexapod"))
    >>> seen.problem, seen.rows > 1_000
    (None, True)

    Args:
        files: text, Parquet, or the folder of a ROS 2 bag or of a run.
        case: the machine that it was recorded on, with what it states of its recordings; without one, units and
            completeness follow from the names alone.

    Raises:
        RecordingError: a file cannot be read, or holds no table of numbers.
    """
    places = [recording_of(Path(file)) for file in ([files] if isinstance(files, Path | str) else files)]
    if not places:
        raise RecordingError(problem="no recording is named", remedy="give the files of one run", code=Code.MISSING)
    if is_bag(places[0]) and len(places) == 1:
        return _bag(places[0], case)
    if bag := next((place for place in places if is_bag(place)), None):
        raise RecordingError(
            place=bag,
            problem="is a bag, which holds a run alone",
            remedy="look at it by itself",
            code=Code.NOT_SUPPORTED,
        )
    refusal = None if case is None or not _says_how(case) else _refusal(places, case)
    return _tables(places, case, refusal)


def _says_how(case: Case) -> bool:
    """Whether the case states more of its recordings than a filter and a rate."""
    return bool(case.recording.model_fields_set - {"filter_cutoff_Hz", "rate_Hz"})


def _tables(files: Sequence[Path], case: Case | None, own: str | None) -> Look:
    """The look at tables of text or Parquet; `own`: why the [recording] of the case does not read them."""
    reads = case is not None and _says_how(case) and own is None
    laid_out = None if reads or case is None else _as_laid_out(files, case)
    if laid_out is not None:
        proposals, settings, trial = laid_out
    else:
        found = [
            (file, *(_as_stated(file, case) if reads and case is not None else (_table(file), case))) for file in files
        ]
        proposals = [(file, table, proposed(table, its_case, reads)) for file, table, its_case in found]
        settings = proposal_of_run([(file.name, proposal) for file, _, proposal in proposals])
        if reads and case is not None and case.recording.files:
            settings = stated_of(case.recording)
        trial = _trial(files, settings, case)
    problem = trial.problem
    whole = {ours for _, _, proposal in proposals for ours in proposal.places}
    doubts = [
        f"{file.name}: {doubt}" if len(files) > 1 else doubt
        for file, _, proposal in proposals
        for doubt in (*proposal.doubts, *missing_parts(proposal.places, whole, proposal.settings))
    ]
    if own not in (None, problem) and not any("which the file does not have" in doubt for doubt in doubts):
        doubts.insert(0, f"the [recording] that the case has does not read it: {own}")
    for file, table, proposal in proposals:
        prefix = f"{file.name}: " if len(files) > 1 else ""
        doubts += [f"{prefix}{sentence}" for sentence in _of_unnamed(table, proposal)]
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
    odd = _sentences(problem, [*doubts, *trial.doubts])
    repairs = tuple(each for each in trial.repairs if each not in odd)
    others = tuple(files[1:])
    return Look(file, rows, tuple(columns), settings, odd, problem, unchanged, (), rate, others, parts, repairs)


_Proposals = list[tuple[Path, TextColumns, Proposal]]


def _as_laid_out(files: Sequence[Path], case: Case) -> "tuple[_Proposals, dict[str, Any], _Trial] | None":
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
    trial = _trial(files, settings, case)
    return (proposals, settings, trial) if trial.problem is None else None


def _table_of(file: Path, k: int, tables: Sequence[Mapping[str, Any]], proposal: Proposal) -> int | None:
    """Which of the tables of a run's files is that of a file: that whose pattern or columns it has, else the k-th."""
    if not tables:
        return None
    named = [n for n, table in enumerate(tables) if "match" in table and fnmatch(file.name, table["match"])]
    whole = [n for n, table in enumerate(tables) if {*table.get("columns", {}).values()} <= {*proposal.names}]
    free = [n for n in whole if "match" not in tables[n]]
    return next(iter(named or free), k if k < len(tables) else None)


def _of_unnamed(table: TextColumns, proposal: Proposal) -> Iterator[str]:
    """What the columns of a file without names may be by their values; nothing is proposed for them."""
    sentences = [
        f"{name} has no name: {_by_values(table.numbers[k])}"
        for k, name in enumerate(proposal.names)
        if name == f"column {k + 1}" and k in table.numbers and k not in proposal.places.values()
    ]
    yield from sentences
    if sentences:
        yield "list the names of all columns in recording.column_names, in their order; nothing is guessed from values"


def _by_values(values: Array) -> str:
    """What numbers of a column, shape (n,), look like."""
    finite = values[np.isfinite(values)]
    if len(finite) < 3:
        return "too few numbers to say what it is"
    low, high, steps = float(finite.min()), float(finite.max()), np.diff(finite)
    if low == high:
        return f"{low:.6g} all along, as a constant or a switch that is never used"
    if np.isin(finite, (low, high)).all():
        return f"{low:.6g} or {high:.6g}, as a switch; a trigger, perhaps"
    if steps.min() > 0.0 and np.ptp(steps) <= ALIKE * (usual := float(np.median(steps))):
        kind = "numbers of the rows" if usual == 1.0 and low == np.rint(low) else "a clock"
        return f"rises by {usual:.6g} from row to row, as {kind}"
    bend = float(np.sqrt(np.mean(np.diff(steps) ** 2) / np.mean(steps**2)))
    kind = "smooth, as a position, angle or set point" if bend < SMOOTH else "with noise, as a force or moment"
    return f"{low:.6g} to {high:.6g}, {kind}"


def _of_another_file(files: Sequence[Path], whole: set[str], case: Case | None) -> Iterator[str]:
    """What to say of a file that holds one half of a run: the other may be in a file of another recorder."""
    if case is None or case.setup == "1a" or len(files) > 1:
        return
    forces = whole >= {*case.sensor_frame.channels}
    motion = any(whole >= {*group} for group in (case.drive_columns, DRIVES, POSE, ROTATION, QUATERNION))
    if forces != motion:
        has, lacks = ("forces", "pose") if forces else ("pose", "forces")
        both = f"hexcite look {files[0].name} OTHER"
        yield f"it has {has} and no {lacks}; if another file of the run has them, name both: {both}"


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
            own = clock if clock is not None and len(clock) == len(values) else None
            unit, guessed = proposal.units.get(ours or "", ""), ours in proposal.guessed
            why = proposal.reasons.get(ours or "", NO_REASON)
            why_unit = proposal.unit_reasons.get(ours or "", NO_REASON)
            yield Column(name, ours, unit, guessed, values, own, why, why_unit)


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


def _sentences(problem: str | None, doubts: Iterable[str]) -> tuple[str, ...]:
    """Why a file is not read, then the doubts, each once."""
    first = [] if problem is None else [f"not read with these settings: {problem}"]
    return tuple(dict.fromkeys(printable(sentence) for sentence in (*first, *doubts)))


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


_MEANT: dict[Topic, str] = {"joints": "positions of the joints", "wrench": "readings of the force/torque sensor"}


def _bag(bag: Path, case: Case | None) -> Look:
    """The look at a bag: topics, rates, frames, channels, and which of them are read."""
    topics = bag_topics(bag)
    settings: dict[str, Any] = {"filter_cutoff_Hz": CUTOFF_HZ}
    settings |= {} if case is None else {k: v for k, v in stated_of(case.recording).items() if k not in LAYOUT}
    doubts: list[str] = []
    ros = dict(settings.pop("ros", {}))
    chosen: dict[Topic, BagTopic] = {}
    for what, channels_of_kind in _MEANT.items():
        possible = [topic for topic in topics if topic.what == what and topic.messages]
        named = next((topic for topic in possible if topic.name == ros.get(what)), None)
        if what in ros and named is None:
            doubts.append(f"recording.ros.{what} of the case is {ros.pop(what)}, which the bag does not have")
        best = named or min(possible, key=lambda topic: _rank_of_topic(topic, ros.get("frame")), default=None)
        if best is None:
            doubts.append(f"no topic of {channels_of_kind}; record one")
            continue
        chosen[what] = best
        if len(possible) > 1 and named is None:
            ros[what] = best.name
            doubts.append(
                f"several topics of {channels_of_kind}: {listed([t.name for t in possible])}; {best.name} is proposed"
            )
        if not best.stamped and "time" not in ros:
            ros["time"] = "receipt"
            doubts.append(f"{best.name}: its headers have no stamps of use; the bag's own times, of receipt, are taken")
    if ros:
        settings["ros"] = ros
    if "wrench" in chosen:
        doubts += _about_frames(chosen["wrench"], ros.get("frame"))
    settings.pop("columns", None)
    if case is None:
        doubts.append("name the robot with --case, for the order of its joints")
    elif case.chain is not None and "joints" in chosen:
        joints = dict(zip(case.chain.columns, case.chain.names, strict=True)) | case.recording.columns
        names = chosen["joints"].channels
        has_all_joints = {*case.chain.names} <= {
            *names
        }  # then columns of the case are those of another file, if there are any
        if has_all_joints or all(joints[ours] in names for ours in case.chain.columns):
            settings |= {"columns": case.recording.columns} if case.recording.columns else {}
        else:
            places = meaning_of(names, case).places
            renamed = {ours: names[places[ours]] for ours in case.chain.columns if ours in places}
            settings |= {"columns": renamed} if renamed else {}
    columns = tuple(c for topic in chosen.values() for c in _channels(topic, case, settings))
    trial = _trial([bag], settings, case)
    odd = _sentences(trial.problem, [*doubts, *trial.doubts])
    unchanged = case is not None and trial.form == case.recording
    rows = sum(topic.messages for topic in chosen.values())
    repairs = tuple(each for each in trial.repairs if each not in odd)
    return Look(bag, rows, columns, settings, odd, trial.problem, unchanged, topics, repairs=repairs)


def _rank_of_topic(topic: BagTopic, frame: str | None) -> tuple[bool, bool, bool, str]:
    """Order in which topics are chosen: those of the stated frame, and of names that say neither filtered nor
    compensated.
    """
    from identification.recording.formats import vocabulary as say

    words = words_of(topic.name)
    elsewhere = frame is not None and not all(is_stated(own, frame) for own in topic.frames)
    plain = say.FILTERED.among(words) or not say.RAW.among(words)
    return elsewhere, say.NOT_OF_A_SENSOR.among(words), plain, topic.name


def _about_frames(topic: BagTopic, stated: str | None) -> Iterator[str]:
    """Sentences on the frames of a wrench, where the case states one or does not."""
    for frame in topic.frames:
        if problem := problem_of(frame, stated):
            yield f"{topic.name}: {'; '.join(problem)}"
    if len(topic.frames) > 1:
        yield f"{topic.name}: its messages are in several frames, {listed(topic.frames)}"


def _channels(topic: BagTopic, case: Case | None, settings: Mapping[str, Any]) -> Iterator[Column]:
    """The channels of a topic as columns."""
    from cases.recording_format import WRENCH
    from identification.recording.formats.binary import AXES

    assert topic.values is not None
    assert topic.t is not None
    ours: dict[str, str] = dict(zip(AXES, WRENCH, strict=True))
    if topic.what == "joints":
        chain = None if case is None else case.chain
        names = {} if chain is None else dict(zip(chain.columns, chain.names, strict=True))
        is_complete = {*names.values()} <= {*topic.channels}
        ours = {
            theirs: column for column, theirs in (names if is_complete else names | settings.get("columns", {})).items()
        }
    taken = because(Why.JOINTS_OF if topic.what == "joints" else Why.WRENCH_OF, topic=topic.name)
    for name, values in zip(topic.channels, topic.values.T, strict=True):
        unit = "rad" if topic.what == "joints" else "N" if name.startswith("force") else "Nm"
        if topic.what == "joints" and ours.get(name, "").endswith("_mm"):
            unit = "m"
        there = np.isfinite(values)
        why, why_unit = (taken, because(Why.MESSAGES)) if name in ours else (NO_REASON, NO_REASON)
        yield Column(name, ours.get(name), unit, False, values[there], topic.t[there], why, why_unit)


@dataclass(slots=True)
class _Trial:
    """What became of an attempt to read a file with some settings."""

    problem: str | None = None  # why it is not read; None: it is
    form: RecordingFormat | None = None  # the settings, where they can be
    doubts: list[str] = field(default_factory=list)  # warnings of what was read, and why `identify` refuses it
    repairs: list[str] = field(default_factory=list)  # what the reader made of it


def _trial(files: Sequence[Path], settings: Mapping[str, Any], case: Case | None, fitted: bool = True) -> _Trial:
    """An attempt to read files with some settings, as `identify` reads them; `fitted`: and to fit what was read."""
    try:
        form = RecordingFormat.model_validate(dict(settings))
    except ValidationError as error:
        return _Trial("; ".join(str(problem["msg"]).removeprefix("Value error, ") for problem in error.errors()))
    trial = _Trial(form=form)
    try:
        if case is None:
            findings = [f for file in files for table in read_tables(file, form) for f in table.findings]
            done = findings
        else:
            case_with_form = case.model_copy(update={"recording": form})
            read_run = read(files, case_with_form)
            findings = [*read_run.findings]
            whole = on_one_clock(read_run, case_with_form)
            clean = scan(whole, case_with_form)
            done = [*findings, *clean.findings]
            if clean.recording.t is not None:
                checked_filter(clean.recording, case_with_form)
            trial.doubts += _refused_by_identify(whole, case_with_form, files[0]) if fitted else []
    except HexciteError as error:
        if isinstance(error, CaseError):
            raise
        return _Trial(_without_file(error, files[0]), form)
    findings_of_reading = [_of_whom(finding, case) for finding in done]
    trial.doubts += [
        _without_file(f, files[0]) for f in findings_of_reading[: len(findings)] if f.severity == "warning"
    ]
    sentences = (_without_file(f, files[0]) for f in findings_of_reading if f.sentence and f.kind in _ABOUT_READING)
    trial.repairs += dict.fromkeys(sentences)
    return trial


def _of_whom(finding: Finding, case: Case | None) -> Finding:
    """A finding about a unit that the case does not state: the proposal does."""
    entries = finding.quantity.get(CONTRADICTED)
    if entries is None or (case is not None and _states(stated_of(case.recording), entries)):
        return finding
    return contradiction(**entries, source=finding.place, whose="proposed here")


def _states(settings: Mapping[str, Any], entries: Mapping[str, str]) -> bool:
    """Whether settings of a case hold a unit that a file contradicts."""
    value: Any = settings
    for part in entries["key"].split(".")[1:]:
        value = value.get(part) if isinstance(value, Mapping) else None
    return bool(value == entries["used"])


def _refusal(files: Sequence[Path], case: Case) -> str | None:
    """Why files are not read as a case says; None: they are."""
    return _trial(files, stated_of(case.recording), case, False).problem


_ABOUT_READING = (Kind.FORMAT, Kind.DAMAGE, Kind.CLOCK, Kind.WINDOW)
"""Kinds of findings that say what the reader made of a file."""


def _refused_by_identify(recording: Recording, case: Case, file: Path) -> list[str]:
    """What to say of a run that is read and gets no estimate."""
    if len(recording.forces) > MOST_FITTED:
        return []
    try:
        require_fit(recording, case)
    except HexciteError as error:
        why = _without_file(error, file)
        return [f"it is read, but identify refuses it (tare and force may take it, as a standstill): {why}"]
    return []


def _without_file(sentence: object, file: Path) -> str:
    """A sentence that begins with the file, which is named above it."""
    return str(sentence).removeprefix(f"{file}").lstrip(":, ")
