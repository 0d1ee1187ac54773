"""What a file of unknown format is likely to be, as a value: its columns, and the table `[recording]` that reads it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.base.errors import Code, FileProblem, RecordingError, option, printable
from cases.base.phrases import said
from cases.base.text_formats import toml_value
from cases.base.units import Array, as_html
from cases.editing import Change, changes_of, write_table
from cases.tables import built_in_cases, find_case
from identification.recording.formats.reasons import NO_REASON, Reason
from identification.recording.formats.ros.topics import BagTopic


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

    def to_json(self) -> dict[str, Any]:
        """What it is taken for, and why."""
        return {
            "name": self.name, "meaning": self.ours, "unit": self.unit, "guessed": self.guessed, "reason": self.reason,
            "unit_reason": self.unit_reason, "reason_codes": self.reason.codes,
            "unit_reason_codes": self.unit_reason.codes,
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class FileLook:
    """What one of the files of a run is likely to be."""

    file: Path
    columns: tuple[Column, ...]  # in the order of the file
    table: int | None  # position of its table in `files` of the settings; None: these are its table
    reasons: Mapping[str, Reason]  # key of its settings -> why it has this value

    def to_json(self) -> dict[str, Any]:
        """Which columns it has, and why its settings are what they are."""
        return {
            "file": str(self.file), "columns": [column.name for column in self.columns], "table": self.table,
            "reasons": dict(self.reasons), "reason_codes": {key: why.codes for key, why in self.reasons.items()},
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Look:
    """What a file is likely to be.

    >>> hx.look("empty/recording.csv", hx.load_case("hexapod"))
    empty/recording.csv: 5356 rows, 1000 a second, 14 columns
    [recording]
    filter_cutoff_Hz = 40.0
    """

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

    def to_json(self) -> dict[str, Any]:
        """All but the numbers of its columns, as programs read it."""
        return {
            "recording": str(self.file),
            "reads": self.reads,
            "unchanged": self.unchanged,
            "rows": self.rows,
            "rate_Hz": self.rate,
            "columns": [column.to_json() for column in self.columns],
            "files": [part.to_json() for part in self.parts],
            "repairs": list(self.repairs),
            "repairs_phrases": [said(each).to_json() for each in self.repairs],
            "topics": [topic.to_json() for topic in self.topics],
            "settings": dict(self.settings),
            "odd": list(self.odd),
            "odd_phrases": [said(each).to_json() for each in self.odd],
        }

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
