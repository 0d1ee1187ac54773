"""What commands and cases answer, in the language of the page: by codes where they have some, else as a quotation."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from markupsafe import Markup, escape

from cases.base.phrases import QUOTED, Phrase
from cases.schema import NO_TITLE
from hexcite.page.refusals import Refusal, RefusedFields
from hexcite.page.values import Entry, Section
from hexcite.texts import Language, text
from hexcite.texts import answers as german
from hexcite.texts.by_code import at_place, limit, parameter, place_words, sentence
from hexcite.texts.case_keys import KEYS, NOUNS, TABLES
from hexcite.texts.decimals import page_with_commas
from identification.limits.limit import LimitKind
from identification.recording.formats.reasons import Why
from identification.texts import begun, parameter_words

_CODE = re.compile("`([^`]+)`")  # as docstrings mark it

CONTROLS = {
    "linuxcnc": "LinuxCNC", "sinumerik": "SINUMERIK", "twincat": "TwinCAT", "urscript": "URScript", "ros2": "ROS 2",
    "setpoints": "set points (CSV)",
}  # fmt: skip
"""Names of controllers as their makers write them."""


@dataclass(frozen=True)
class Words:
    """Words in one language. English ones are those of the commands; what has no other is quoted, and marked so."""

    language: Language

    @property
    def _own(self) -> bool:
        return self.language == "en"

    def quoted(self, sentence: object) -> Markup:
        """A sentence of the command line, which is English."""
        if self._own or not str(sentence) or isinstance(sentence, Markup):  # which is ours already
            return escape(sentence)
        if isinstance(sentence, Phrase) and sentence.code != QUOTED:
            return self.clause(sentence.to_json(), str(sentence))
        return Markup('<q lang="en">{}</q>').format(sentence)

    def all_quoted(self, sentences: Iterable[object]) -> Markup:
        """Sentences behind each other."""
        return Markup("; ").join(self.quoted(each) for each in sentences)

    def noun(self, noun: str) -> str:
        """The noun of a key."""
        return noun if self._own else NOUNS.get(noun, noun)

    def meaning(self, entry: Entry) -> Markup:
        """What a key means."""
        return self._of(KEYS, (f"{owner}.{entry.key}" for owner in entry.owners), entry.words)

    def table(self, section: Section) -> Markup:
        """What a table is."""
        return self._of(TABLES, section.owners, section.words)

    def _of(self, table: Mapping[str, str], names: Iterable[str], english: str) -> Markup:
        entry = None if self._own else next((table[name] for name in names if name in table), None)
        words = escape(english) if self._own else self.quoted(english) if entry is None else escape(entry)
        return Markup(_CODE.sub(r"<code>\1</code>", str(words)))  # escaped above

    def limit(self, name: str, place: str = "") -> str:
        """A limit by its name, with the strut, joint or body that comes closest."""
        if self._own:
            name = "nearness to a singularity" if name == LimitKind.SINGULARITY else name
            return f"{name} ({place})" if place else name
        return limit(name, place)

    def limit_at(self, name: str, at: str) -> str:
        """A limit as an answer has it: its name, and its name with a place."""
        return self.limit(name, at[len(name) + 2 : -1] if at.startswith(f"{name} (") else "")

    def limit_of(self, at: str) -> str:
        """A limit as lines of programs have it: a name, with a place in brackets or without."""
        name, bracket, place = at.partition(" (")
        return self.limit(name, place[:-1]) if bracket else self.limit(at)

    def place(self, place: str) -> str:
        """A strut, joint or sensor with its number, or the name of a body."""
        return place if self._own else place_words(place)

    def status(self, status: str) -> str:
        """Who ensures a limit."""
        return status if self._own else german.STATUSES.get(status, status)

    def parameter(self, name: str) -> str:
        """A parameter in words with its letter."""
        return parameter_words(name) if self._own else parameter(name)

    def check(self, code: str, of: str, english: str) -> Markup:
        """What is judged."""
        if self._own or code not in german.CHECKS:
            return self.quoted(english)
        return escape(german.CHECKS[code].format(of=self.parameter(of)))

    def cause(self, kind: str) -> str:
        """What a part of a deviation is by."""
        return kind if self._own else german.CAUSES.get(kind, kind)

    def finding(self, finding: Mapping[str, Any]) -> Markup:
        """A finding of a result: its sentence by its code, else what it is about and a quotation."""
        kind, sentence = str(finding.get("kind")), str(finding.get("sentence", ""))
        if self._own or kind not in german.FINDINGS:
            return self.quoted(sentence)
        by_code = self.by_code(finding.get("phrase"))
        if by_code is None:
            return Markup("{} {}").format(german.FINDINGS[kind], self.quoted(sentence))
        place = str(finding.get("place") or "")
        return Markup("{}: {}").format(place, by_code) if place else by_code

    def by_code(self, entries: object) -> Markup | None:
        """A sentence by its code and values; None in English, and where a code has no other words.

        Args:
            entries: as `Phrase.to_json` gives them.
        """
        if self._own or not isinstance(entries, Mapping):
            return None
        sentence_text = sentence(entries, self.quoted)
        return None if sentence_text is None else Markup(begun(sentence_text))

    def clause(self, entries: object, english: str) -> Markup:
        """A clause by its code, else as a quotation."""
        sentence = self.by_code(entries)
        return self.quoted(english) if sentence is None else sentence

    def clauses(self, sentences: object, phrases: object) -> list[Markup]:
        """Sentences of an answer, or of a file, with their codes beside them, where it has some."""
        own = [each for each in sentences if isinstance(each, str)] if isinstance(sentences, list) else []
        codes = [*phrases] if isinstance(phrases, list) else []
        return [self.clause(code, each) for each, code in zip_longest(own, codes[: len(own)])]

    def error(self, error: Mapping[str, Any]) -> Markup | None:
        """A refusal of a command by its codes, with its place; None where its sentence has none."""
        phrases = error.get("phrases")
        if self._own or not isinstance(phrases, Mapping) or "problem" not in phrases:
            return None
        parts = [self.by_code(phrases["problem"])]
        if error.get("remedy"):
            parts.append(self.clause(phrases.get("remedy"), str(error["remedy"])))
        if parts[0] is None:
            return None
        sentence = Markup("; ").join(each for each in parts if each is not None)
        return (
            Markup("<code>{}</code>: {}").format(at_place(str(error["place"])), sentence)
            if error.get("place")
            else sentence
        )

    def refusal(self, code: str) -> str:
        """What a refused command lacks; empty in English, whose sentence says it."""
        return "" if self._own else german.ERRORS.get(code, "")

    def reasons(self, codes: object, sentence: str) -> Markup:
        """Why a file is taken for what it is."""
        if self._own or not isinstance(codes, list) or not codes:
            return self.quoted(sentence)
        return Markup("; ").join(self._reason(code) for code in codes)

    def _reason(self, code: Mapping[str, Any]) -> Markup:
        words = german.REASONS.get(str(code.get("code")))
        places = {name: str(value) for name, value in code.items() if name != "code"}
        if words is None:
            why = Why.__members__.get(str(code.get("code")).upper())
            return self.quoted("" if why is None else why.value.format(**places))
        return escape(words.format(**places))

    def progress(self, standing: Mapping[str, Any]) -> Markup:
        """How far a search is, that for a motion or that for a cause."""
        if not self._own and "step" in standing:
            words = text(f"step_{standing['step']}", self.language)
            left = standing.get("left_s")
            rest = "" if left is None else text("causes_left", self.language, seconds=f"{float(left):.0f}")
            return escape(", ".join(filter(None, (words, rest))))
        if self._own or "done" not in standing:
            return self.quoted(standing.get("line", ""))
        parts = []
        if standing.get("least"):
            parts.append(text("progress_starts", self.language, done=standing["done"], least=standing["least"]))
        if standing.get("best") is not None:
            parts.append(text("progress_best", self.language, best=f"{float(standing['best']):.3g}"))
        if standing.get("left_s") is not None:
            parts.append(text("progress_left", self.language, seconds=f"{float(standing['left_s']):.0f}"))
        return escape(", ".join(parts) or text("progress_begins", self.language))

    def title(self, machine: str, english: str) -> Markup:
        """The title of a machine: of built-in ones ours, of others the user's own."""
        if english == NO_TITLE:
            return escape(self.say("no_title"))
        return escape(english if self._own else german.TITLES.get(machine, english))

    def refused(self, refusal: Refusal) -> Markup:
        """What the page refuses."""
        if isinstance(refusal, RefusedFields):
            return Markup("; ").join(map(self.refused, (*refusal.fields.values(), *refusal.others)))
        words = self._without_place(refusal)
        return Markup("{}: {}").format(refusal.place, words) if refusal.place else words

    def _without_place(self, refusal: Refusal) -> Markup:
        return self.quoted(refusal.sentence) if refusal.sentence else escape(self.say(refusal.key, **refusal.values))

    def refused_fields(self, fields: Mapping[str, Refusal]) -> dict[str, Markup]:
        """What is refused at each field, by its id, without the field's name before it."""
        return {field: Markup(self._commas(self._without_place(each))) for field, each in fields.items()}

    def _commas(self, sentence: str) -> str:
        return sentence if self._own else page_with_commas(sentence)

    def say(self, key: str, **places: object) -> str:
        """A text of the page."""
        return text(key, self.language, **places)


ENGLISH = Words("en")
