"""What the page itself refuses: texts by their keys, so that they are in its language, or sentences of the library."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Self

from cases.base.phrases import enumerated
from hexcite.texts import text


class Refusal(ValueError):
    """Something that cannot be.

    Args:
        key: of the text that says it; empty where the library does.
        sentence: of the library.
        place: field, or key of the case, that it is at; the sentence does not name it. Empty where there is none.
        values: in the text.
    """

    def __init__(self, key: str, *, sentence: str = "", place: str = "", **values: object) -> None:
        self.key, self.sentence, self.place, self.values = key, sentence, place, values
        words = sentence or text(key, "en", **values)
        super().__init__(f"{place}: {words}" if place else words)

    @classmethod
    def of(cls, lines: Iterable[str]) -> Self:
        """What an error of the library says."""
        return cls("", sentence=enumerated("semicolon", list(lines)))


class Unfit(Refusal):
    """A field that cannot be used."""


class NoRecording(Unfit):
    """A program in the place of a recording; `name`: of its file."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__("is_program", name=name)


class Refused(Refusal):
    """A value that cannot be, with the place where it stands."""


class RefusedFields(Refused):
    """All values of a form that cannot be.

    Args:
        fields: id of a field in the form -> why its value cannot be.
        others: what is refused at no field.
    """

    def __init__(self, fields: Mapping[str, Refusal], others: Sequence[Refusal] = ()) -> None:
        self.fields, self.others = fields, others
        super().__init__("", sentence="; ".join(map(str, (*fields.values(), *others))))
