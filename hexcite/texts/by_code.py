"""Sentences in German by their codes and values, and names of parameters, checks and causes."""

import re
from collections.abc import Callable, Mapping
from html import unescape

from markupsafe import Markup, escape

from cases.base.errors import AT_PLACE
from cases.base.phrases import PURPOSE, QUOTED
from cases.schema import TITLE
from hexcite.texts import answers, cases, plan, sentences
from identification.limits.limit import NAMED, Limit
from identification.texts import CAUSE, CHECK, PARAMETER, SENTENCES, begun, parameter_words
from planner.options import FAMILY


def parameter(name: str) -> str:
    """A parameter in words with its letter."""
    words = answers.PARAMETERS.get(name)
    return parameter_words(name) if words is None else f"{words} ({name})"


def limit(name: str, place: str = "") -> str:
    """A limit by its name, with the strut, joint or body that comes closest."""
    try:
        limited = Limit.named(name)
    except ValueError:
        return name
    words = answers.LIMITS[str(limited.kind)] + (f" {limited.box}" if limited.box else "")
    words += "" if limited.move is None else f", {answers.LIMITS[str(limited.move)]}"
    return f"{words} ({place_words(place)})" if place else words


def limit_of(at: str) -> str:
    """A limit as sentences have it: a name, with a place in brackets or without."""
    name, bracket, place = at.partition(" (")
    return limit(name, place[:-1]) if bracket else limit(at)


def place_words(place: str) -> str:
    """A strut, joint or sensor with its number, or the name of a body."""
    first, blank, rest = place.partition(" ")
    where = _PAYLOADS.sub(lambda count: f"{count[1]} Nutzlast{'en' if count[2] else ''}", rest)
    where = where.replace(" at most", " höchstens")
    return f"{answers.PLACES.get(first, first)}{blank}{where}"


_PAYLOADS = re.compile(r"(\d+) payload(s?)")
"""How many payloads are mounted where a limit is closest."""


def sentence(value: object, quoted: Callable[[object], Markup]) -> Markup | None:
    """A sentence by its code and values, escaped; None where a code has no German words.

    Args:
        value: entries as `Phrase.to_json` gives them, or a text, which stays.
        quoted: shows a text that is English.
    """
    if not isinstance(value, Mapping):
        return escape(value)
    code, values = str(value.get("code")), value.get("values")
    if not isinstance(values, Mapping):
        return None
    if code in sentences.SIGNS:
        parts = [sentence(part, quoted) for part in values.get("parts", ())]
        return None if None in parts else Markup(sentences.SIGNS[code]).join(each for each in parts if each)
    if code == SENTENCES:
        each_part = [sentence(part, quoted) for part in values.get("parts", ())]
        ended = [Markup("{}.").format(Markup(begun(part.removesuffix(".")))) for part in each_part if part is not None]
        return None if None in each_part else Markup(" ").join(ended)
    if code == PARAMETER:
        return escape(parameter(str(values.get("name"))))
    if code == FAMILY:
        return escape(plan.TEXTS.get(f"family_{values.get('name')}", ("", str(values.get("name"))))[1])
    if code == NAMED:
        return escape(limit_of(str(values.get("name"))))
    if code == CAUSE:
        return escape(answers.CAUSES.get(str(values.get("name")), str(values.get("name"))))
    if code == TITLE:
        return escape(answers.TITLES.get(str(values.get("name")), str(values.get("title"))))
    if code == CHECK:
        judged = answers.CHECKS.get(str(values.get("code")))
        return None if judged is None else escape(judged.format(of=parameter(str(values.get("of")))))
    if code == PURPOSE:
        purpose = str(values.get("words"))
        return escape(cases.PURPOSES[purpose]) if purpose in cases.PURPOSES else quoted(purpose)
    if code == QUOTED:
        return quoted(values.get("text", ""))
    words = sentences.SENTENCES.get(code)
    inner = {str(name): sentence(each, quoted) for name, each in values.items()}
    if code == AT_PLACE:
        inner["place"] = Markup("<code>{}</code>").format(at_place(str(values.get("place"))))
    return None if words is None or None in inner.values() else Markup(words).format(**inner)


def at_place(place: str) -> str:
    """A place as messages of commands name it: a file or a case, a line, a column, an option."""
    for pattern, words in _PLACES:
        place = pattern.sub(words, place)
    return place


_PLACES = (
    (re.compile(r"^case (?=\w)"), "Maschine "),
    (re.compile(r"\bline (?=\d)"), "Zeile "),
    (re.compile(r"\bcolumn (?=\w)"), "Spalte "),
    (re.compile(r"\bchannel (?=\w)"), "Kanal "),
)
"""Words in places, and ours."""


def plain(value: object, english: str) -> str:
    """A sentence by its code without any markup; the English one in quotation marks where it has no German words."""
    phrase_text = sentence(value, lambda text: escape(f"“{text}”")) if isinstance(value, Mapping) else None
    if phrase_text is None:
        return f"“{english}”"
    return begun(unescape(_CODE.sub("", str(phrase_text))))


_CODE = re.compile("</?code>")
