"""Sentences by codes: an English text that knows what it was made of, so that it can be said in other languages."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Self

Sign = Literal["or", "and", "both", "comma", "comma_or", "semicolon", "problems"]
SIGNS: Mapping[Sign, str] = {
    "or": " or ",
    "and": ", and ",
    "both": " and ",
    "comma": ", ",
    "comma_or": ", or ",
    "semicolon": "; ",
    "problems": "; also: ",
}
"""What stands between the parts of an enumeration, in English."""
QUOTED = "quoted"
"""Code of a text that has no code: it is quoted in other languages."""


class Phrase(str):
    """A text in English, with its code and the values in its places: texts, numbers, and phrases in turn.

    A text that is made of it by `+` or in an f-string is a plain one.
    """

    code: str = QUOTED
    values: Mapping[str, Any] = {}
    template: str = "{text}"  # the text with places in braces
    keys: tuple[str, ...] = ()
    """Dotted keys of a case that it is about, entries of lists counted from 1; those of one sum in one, with commas."""

    def about(self, *keys: str) -> Self:
        """The same with the keys that it is about.

        >>> phrase("swapped", "lower limit is not below upper limit").about("workspace.x_mm").keys
        ('workspace.x_mm',)
        """
        keyed = type(self)(self)
        vars(keyed).update(vars(self), keys=keys)
        return keyed

    def filled(self, **values: object) -> "Phrase":
        """The same with other values in some of its places.

        >>> phrase("off", "strut {which} is off by {size}", which=2, size=OPEN).filled(size="1 mm")
        'strut 2 is off by 1 mm'
        """
        return phrase(self.code, self.template, **{**self.values, **values}).about(*self.keys)

    def to_json(self, shown: Callable[[str], str] = str) -> dict[str, Any]:
        """Entries for programs: `code`, and `values` by the names of their places.

        Args:
            shown: makes a text in it one that may be shown.
        """
        return {"code": self.code, "values": {name: _entry(value, shown) for name, value in self.values.items()}}


PURPOSE = "purpose"
"""Code of what something is needed for, whose words are its value."""
OPEN = "{}"
"""Value of a place that `Phrase.filled` fills later."""
NOTHING = Phrase()
"""The empty text."""


def phrase(code: str, english: str, **values: object) -> Phrase:
    """A text with values in its places.

    >>> phrase("struts_off", "struts {which} are off", which=2).to_json()
    {'code': 'struts_off', 'values': {'which': '2'}}

    Args:
        code: what it says, for programs; one for each text.
        english: the text, with places in braces.
        values: by the names of the places.
    """
    result = Phrase(english.format(**values))
    result.code, result.values, result.template = code, values, english
    return result


def enumerated(sign: Sign, parts: Sequence[str]) -> Phrase:
    """Several texts behind each other; the one where it is one.

    What is no phrase is a name or a value, but for parts that are sentences, behind semicolons.
    """
    as_part = said if sign in ("semicolon", "problems") else as_it_is
    if len(parts) == 1:
        return as_part(parts[0])
    result = Phrase(SIGNS[sign].join(parts))
    result.code, result.values = sign, {"parts": [as_part(part) for part in parts]}
    return result


def as_it_is(text: str) -> Phrase:
    """A phrase as it is, and any other text as a name or value that is the same in all languages."""
    return text if isinstance(text, Phrase) else phrase("as_it_is", "{text}", text=text)


def said(text: str) -> Phrase:
    """A phrase as it is, and any other text as one that is quoted."""
    return text if isinstance(text, Phrase) else phrase(QUOTED, "{text}", text=text)


def parts_of(sentence: Phrase, sign: Sign = "problems") -> list[Phrase]:
    """The parts of an enumeration by this sign, such as problems, else the one sentence that it is."""
    return list(sentence.values["parts"]) if sentence.code == sign else [sentence]


def again(text: str, entries: object) -> Phrase:
    """A text as the phrase that it was, by its entries; one that is quoted where they are none.

    Args:
        text: in English.
        entries: as `Phrase.to_json` gives them.
    """
    if not isinstance(entries, Mapping) or not isinstance(values := entries.get("values"), Mapping):
        return said(text)
    result = Phrase(text)
    result.code, result.values = str(entries.get("code")), values
    return result


def _entry(value: Any, shown: Callable[[str], str]) -> Any:
    if isinstance(value, Phrase):
        return value.to_json(shown)
    if isinstance(value, Mapping):  # of a phrase that was read again
        return dict(value)
    if isinstance(value, list | tuple):
        return [_entry(each, shown) for each in value]
    return shown(str(value))
