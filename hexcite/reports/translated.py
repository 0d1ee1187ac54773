"""A report in another language: texts of a page that are marked as ours are replaced, by code or as they stand.

Files, channels, parameters' letters and what users wrote stay; a text that has no other words is marked as English.
"""

import base64
import json
import re
from collections.abc import Callable, Mapping
from html import escape as escaped
from html import unescape
from typing import Any

from markupsafe import Markup, escape

from hexcite.reports.page import script_json, with_tooltips
from hexcite.texts import answers
from hexcite.texts.by_code import limit_of, parameter, sentence
from hexcite.texts.decimals import page_with_commas, with_commas
from hexcite.texts.reports import FIXED, TERMS, WORDS_OF_MACHINE
from identification.texts import begun, parameter_words


def in_german(page: str) -> str:
    """A report as `page_of` makes it, in German."""
    page = _FIGURE.sub(_figure, page)
    page = _SAID.sub(_element, page)
    page = _LABEL.sub(lambda label: f'{label[1]}="{escape(_label(unescape(label[2])))}"', page)
    return page_with_commas(page.replace('<html lang="en">', '<html lang="de">', 1))


def picture_in_german(svg: str) -> str:
    """A picture as `still` draws it, in German."""
    return _still(svg, lambda english: fixed(english) or english)


def _still(svg: str, words: Callable[[str], str]) -> str:
    return _TEXT.sub(lambda text: f"{text[1]}{_shown(words, text[2])}{text[3]}", svg)


def _shown(words: Callable[[str], str], text: str) -> str:
    return escaped(with_commas(words(unescape(text))), quote=False)


_FIGURE = re.compile(r'<figure(?: class="half")?(?: data-phrases="([^"]*)")?>.*?</figure>', re.DOTALL)
_SAID = re.compile(r'<(\w+)([^<>]*) data-said="([^"]*)"([^<>]*)>((?:[^<]|<(?!/\1>))*)</\1>')
_LABEL = re.compile(r'(aria-label|alt)="([^"]*)"')
_SCRIPT = re.compile(r'(<script type="application/json" (?:data-plot="[^"]*"|id="scene")>)(.*?)(</script>)', re.DOTALL)
_STILL = re.compile(r'(src="data:image/svg\+xml;base64,)([^"]*)"')
_TEXT = re.compile(r"(<text[^>]*>)([^<]+)(</text>)")
_TAG = re.compile(r"<[^>]*>")
_PROSE = re.compile(r"[a-z]{3,} [a-z]{2,}")
"""What a text in words has, and a name or a unit has not."""


def _element(element: re.Match[str]) -> str:
    """An element that holds a text of ours."""
    tag, before, entries, after, inside = element.groups()
    english = unescape(_TAG.sub("", inside))
    german = _by_entries(json.loads(unescape(entries))) if entries else None
    if german is None and (words := fixed(english)) is not None:
        german = escape(words)
    if german is None:
        mark = ' lang="en"' if _PROSE.search(english) else ""
        return f"<{tag}{before}{after}{mark}>{inside}</{tag}>"
    return f"<{tag}{before}{after}>{with_tooltips(german, TERMS)}</{tag}>"


def _by_entries(entries: Mapping[str, Any]) -> Markup | None:
    text = sentence(entries, _quoted)
    return None if text is None else Markup(begun(text))


def _quoted(text: object) -> Markup:
    words = fixed(str(text))
    return escape(words) if words is not None else Markup('<q lang="en">{}</q>').format(text)


def _label(english: str) -> str:
    """What a screen reader says of an element."""
    kind, colon, columns = english.partition(": ")
    if kind == "table" and colon:
        return f"Tabelle: {', '.join(fixed(column) or column for column in columns.split(', '))}"
    return fixed(english) or english


def _figure(figure: re.Match[str]) -> str:
    """A figure: its data, its picture, and what is read out of it."""
    phrases = json.loads(unescape(figure[1])) if figure[1] else {}

    def words(english: str) -> str:
        german = _by_entries(phrases[english]) if english in phrases else None
        return (fixed(english) or english) if german is None else unescape(_TAG.sub("", german))

    def data(script: re.Match[str]) -> str:
        value = json.loads(script[2])
        if 'id="scene"' in script[1]:
            return f"{script[1]}{script_json(_scene(value))}{script[3]}"
        value = _replaced(value, words)
        value["layout"]["separators"] = ", "  # between whole and decimal digits, and thousands
        return f"{script[1]}{script_json(value)}{script[3]}"

    def still(source: re.Match[str]) -> str:
        svg = _still(base64.b64decode(source[2]).decode(), words)
        return f'{source[1]}{base64.b64encode(svg.encode()).decode("ascii")}"'

    whole = _STILL.sub(still, _SCRIPT.sub(data, figure[0]))
    return _LABEL.sub(lambda label: f'{label[1]}="{escape(words(unescape(label[2])))}"', whole)


def _replaced(value: Any, words: Callable[[str], str], read: bool = False) -> Any:
    """Data of a figure with its texts in other words; in them, plotly reads some HTML.

    Args:
        value: of the data.
        words: a text in other words.
        read: whether it is one that people read as it stands, and not a name, a colour or a format.
    """
    if isinstance(value, str):
        return _shown(words, value) if read else escaped(words(unescape(value)), quote=False)
    if isinstance(value, list):
        return [_replaced(each, words, read) for each in value]
    if isinstance(value, Mapping):
        packed = "bdata" in value
        return value if packed else {key: _replaced(each, words, key in _READ) for key, each in value.items()}
    return value


_READ = ("text", "ticktext")


def _scene(scene: Mapping[str, Any]) -> dict[str, Any]:
    """A machine in 3-D: names of its parts and of its limits, and the words of its buttons."""
    parts = [{**part, "name": fixed(part["name"]) or part["name"]} for part in scene["parts"]]
    used = scene.get("used")
    if used:
        used = {**used, "names": [fixed(name) or name for name in used["names"]]}
    return {**scene, "parts": parts, "used": used, "words": WORDS_OF_MACHINE}


def fixed(english: str) -> str | None:
    """A text of a report that stands there as it is; None where it is a name, a value, or has no German words."""
    if english in FIXED:
        return FIXED[english]
    for table in (answers.CAUSES, answers.STATUSES):
        if english in table:
            return table[english]
    words, bracket, unit = english.rpartition(" [")
    if bracket and unit.endswith("]") and (german := fixed(words)) is not None:
        return f"{german} [{unit}"
    letters = english.rpartition(" (")[2].removesuffix(")")
    if letters in answers.PARAMETERS and english == parameter_words(letters):
        return parameter(letters)
    if letters in answers.PARAMETERS and english == parameter_words(letters, rods=True):
        return f"{answers.PARAMETERS[letters]}, Plattform mit Stangen ({letters})"
    german = limit_of(english)
    return None if german == english else german
