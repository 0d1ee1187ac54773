"""Findings about a recording, a fit or a result, beside the figures: one type for notes and warnings."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal

from cases.base.errors import AT_PLACE, Remedy, printable
from cases.base.phrases import Phrase, again
from cases.base.units import as_html


class Kind(StrEnum):
    """What a finding is about."""

    FORMAT = "format"  # how a file was read: units, orientation, clocks that were joined
    DAMAGE = "damage"  # samples that no estimate may use
    WINDOW = "window"  # which part of a recording counts
    CLOCK = "clock"  # rates, delays, lost time
    CONTACT = "contact"
    FEED = "feed"
    PROGRAM = "program"  # what was different from the plan
    NOISE = "noise"  # what the residuals look like, beside what is stated
    MODEL = "model"  # what the model does not explain, or what is impossible
    ESTIMATOR = "estimator"  # what an estimator did, constraints and priors included
    OFFSETS = "offsets"  # that drift
    CASE = "case"  # what has changed, or contradicts the case


ABOUT_THE_RUN = frozenset({Kind.DAMAGE, Kind.WINDOW, Kind.FEED, Kind.PROGRAM})
"""What a run was, and which of it was evaluated: values come from the measured motion, of what is sound in it."""
Severity = Literal["note", "warning"]  # a warning is for people to act on
SEVERITIES: tuple[Severity, ...] = ("note", "warning")


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding.

    >>> finding = hx.Result.load("empty-result").findings[0]
    >>> finding.severity, str(finding.kind), finding.sentence
    ('note', 'model', 'half of all runs like this one would not show time stamps that are 0.65 % too far apart, which
    biases mass (m) by +0.41 kg (58.9 deviations); ...')

    Args:
        kind: what it is about.
        severity: whether people are to act on it.
        sentence: the text for people, place included; empty where it is for programs only.
        place: place in the file, as messages name it; empty where there is none.
        quantity: entries for programs, by their key in result files.
        counted: whether the standard deviations of the result allow for it.
        remedies: keys of the case that would mend it, where some do.
        phrase: entries of the sentence by its code, without the place; None where it has none.
    """

    kind: Kind
    severity: Severity
    sentence: str
    place: str = ""
    quantity: Mapping[str, Any] = field(default_factory=dict)
    counted: bool = False
    remedies: tuple[Remedy, ...] = ()
    phrase: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        """Makes the sentence a printable line, whatever names of files and channels it holds."""
        if isinstance(self.sentence, Phrase) and self.phrase is None:
            object.__setattr__(self, "phrase", self.sentence.to_json(printable))
        object.__setattr__(self, "sentence", printable(self.sentence))

    @property
    def doubts_values(self) -> bool:
        """Whether values may be further off than their deviations say: not by what was left out, or is counted."""
        return self.severity == "warning" and not self.counted and self.kind not in ABOUT_THE_RUN

    @property
    def coded_sentence(self) -> Phrase:
        """The sentence with its code, where it has one."""
        if self.phrase is None or not self.place:
            return again(self.sentence, self.phrase)
        return again(self.sentence, {"code": AT_PLACE, "values": {"place": self.place, "problem": dict(self.phrase)}})

    def __str__(self) -> str:
        return self.sentence

    _repr_html_ = as_html


def warning(kind: Kind, sentence: str, place: str = "", *, counted: bool = False, **quantity: Any) -> Finding:
    """A finding that people should act on."""
    by_code = sentence.to_json(printable) if isinstance(sentence, Phrase) else None
    whole = f"{place}: {sentence}" if place else sentence
    return Finding(kind, "warning", whole, place, quantity, counted, phrase=by_code)


def changed_cases(remarks: Iterable[str]) -> tuple[Finding, ...]:
    """Findings of remarks on a case that has changed since."""
    return tuple(warning(Kind.CASE, remark) for remark in remarks)


def note(kind: Kind, sentence: str = "", **quantity: Any) -> Finding:
    """A finding that is good to know."""
    return Finding(kind, "note", sentence, quantity=quantity)


def sentences(findings: Iterable[Finding], severity: Severity) -> tuple[str, ...]:
    """Sentences for people, of one severity."""
    return tuple(f.coded_sentence for f in findings if f.severity == severity and f.sentence)
