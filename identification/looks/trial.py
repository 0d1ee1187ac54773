"""A proposal is tried: files are read with it as `identify` reads them, and fitted, so that what refuses is said."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cases.base.errors import CaseError, HexciteError, in_python, printable, whole_sentence
from cases.base.phrases import Phrase, again, phrase, said
from cases.recording_format import RecordingFormat
from cases.schema import Case
from identification.finding import Finding, Kind
from identification.identify import require_fit
from identification.recording.formats.proposal import stated_of
from identification.recording.formats.quantities import CONTRADICTED, contradiction
from identification.recording.formats.reading import bags_together, read_tables
from identification.recording.recording import Recording, read
from identification.samples.clocks import on_one_clock
from identification.samples.moving_window import checked_filter
from identification.samples.sample_checks import scan

MOST_FITTED = 200_000
"""Samples of a run that `look` fits; a longer one is read only, for that would take long."""


def sentences_of(problem: str | None, doubts: Iterable[str]) -> tuple[Phrase, ...]:
    """Why a file is not read, then the doubts, each once."""
    first = []
    if problem is not None:
        first = [phrase("not_read", "not read with these settings: {why}", why=said(problem))]
    sentences = map(said, (*first, *doubts))
    return tuple(dict.fromkeys(again(printable(each), each.to_json(printable)) for each in sentences))


@dataclass(slots=True)
class Trial:
    """What became of an attempt to read a file with some settings."""

    problem: str | None = None  # why it is not read; None: it is
    form: RecordingFormat | None = None  # the settings, where they can be
    doubts: list[Phrase] = field(default_factory=list)  # warnings of what was read, and why `identify` refuses it
    repairs: list[Phrase] = field(default_factory=list)  # what the reader made of it


def trial_of(files: Sequence[Path], settings: Mapping[str, Any], case: Case | None, fitted: bool = True) -> Trial:
    """An attempt to read files with some settings, as `identify` reads them; `fitted`: and to fit what was read."""
    try:
        form = RecordingFormat.model_validate(dict(settings))
    except ValidationError as error:
        return Trial("; ".join(str(problem["msg"]).removeprefix("Value error, ") for problem in error.errors()))
    trial = Trial(form=form)
    try:
        if case is None:
            tables = [t for file, more in bags_together(files) for t in read_tables(file, form, more_bags=more)]
            findings = [finding for table in tables for finding in table.findings]
            notes = findings
        else:
            case_with_form = case.model_copy(update={"recording": form})
            read_run = read(files, case_with_form)
            findings = [*read_run.findings]
            whole = on_one_clock(read_run, case_with_form)
            clean = scan(whole, case_with_form)
            notes = [*findings, *clean.findings]
            if clean.recording.t is not None:
                checked_filter(clean.recording, case_with_form)
            trial.doubts += _refused_by_identify(whole, case_with_form, files[0]) if fitted else []
    except HexciteError as error:
        if isinstance(error, CaseError):
            raise
        return Trial(_without_file(error, files[0]), form)
    findings_of_reading = [_of_whom(finding, case) for finding in notes]
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


def refusal_of(files: Sequence[Path], case: Case) -> str | None:
    """Why files are not read as a case says; None: they are."""
    return trial_of(files, stated_of(case.recording), case, False).problem


_ABOUT_READING = (Kind.FORMAT, Kind.DAMAGE, Kind.CLOCK, Kind.WINDOW)
"""Kinds of findings that say what the reader made of a file."""


def _refused_by_identify(recording: Recording, case: Case, file: Path) -> list[Phrase]:
    """What to say of a run that is read and gets no estimate."""
    if len(recording.forces) > MOST_FITTED:
        return []
    try:
        require_fit(recording, case)
    except HexciteError as error:
        refused = phrase(
            "identify_refuses",
            "it is read, but identify refuses it (tare and force may take it, as a standstill): {why}",
            why=_without_file(error, file),
        )
        return [refused]
    return []


def _without_file(of: Finding | HexciteError, file: Path) -> Phrase:
    """The sentence of a finding or an error, which begins with the file that is named above it."""
    text = str(of).removeprefix(f"{file}").lstrip(":, ")
    if isinstance(of, Finding):
        return again(text, of.phrase)
    place = of.said.place.removeprefix(f"{file}").lstrip(":, ")
    whole = whole_sentence(said(of.said.problem), place, of.said.remedy)
    return again(text, whole.to_json(lambda part: printable(in_python(part))))
