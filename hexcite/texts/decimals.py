"""Decimal commas in pages that are German; values of files, command lines, programs and names keep their point.

A number of a sentence, a table or a figure is read by a person; what stands in `code`, `pre`, fields and menus, behind
a key and "=", in brackets of a list or in quotation marks is typed, or read by a program.
"""

import re

_NUMBER = r"\d+\.\d+(?:e[-+]?\d+)?(?!\w|[.-]\w)"
_NUMBERS = rf"(?:\d+, [-+\u2212]?)*{_NUMBER}(?:, [-+\u2212]?(?:{_NUMBER}|\d+(?![.\w])))*"
_VALUE = r"(?:\[[^\]]*\]|\{[^}]*\}|[^\s,;)]+)"
_TYPED = "|".join(
    (
        rf"[a-z][\w\[\]]*[._][\w.\[\]]* ?= ?{_VALUE}(?: auf [\d.]+)?",  # a key of a case with its value
        r"\[[^\[\]]*\]|\{[^{}]*\}",  # a list or a table, as files have them
        r"'[^']*'|`[^`]*`|&#39;(?:(?!&#39;).)*&#39;|&#?\w+;",  # quoted, also as HTML has it
        r"--[a-z-]+[ =]\S+",
        r"(?:Version|LinuxCNC) \d[\w.]*",
        r"[^\W\d][\w.:/-]*",  # a word, or a name with digits in it
        r"\d+(?:\.\d+){2,}\w*",  # a version
    )
)
_TEXT = re.compile(rf"({_TYPED})|({_NUMBERS})|\d[\w.-]*")
_PART = re.compile(
    r"<(script|style|title|pre|code|textarea|option)\b[^<>]*>.*?</\1>"
    r"|<(\w+)\b[^<>]* (?:lang=\"en\"|translate=\"no\")[^<>]*>.*?</\2>"
    r"|<[^<>]*>",
    re.DOTALL,
)
_SPOKEN = re.compile(r'(?<= aria-label=")[^"]*|(?<= title=")[^"]*|(?<= alt=")[^"]*')


def with_commas(text: str) -> str:
    """A German text with decimal commas; what else it quotes or names stays.

    >>> with_commas("558.74 mm, 1.0 von 2.5; recording.clock.period_ms = 0.5")
    '558,74 mm, 1,0 von 2,5; recording.clock.period_ms = 0.5'
    >>> with_commas("0.5, -1, 2.25 mm")
    '0,5; -1; 2,25 mm'

    Args:
        text: plain, or as HTML has it.
    """
    return _TEXT.sub(_with_comma, text) if "." in text else text


def _with_comma(part: re.Match[str]) -> str:
    return part[0].replace(",", ";").replace(".", ",") if part[2] else part[0]


def page_with_commas(page: str) -> str:
    """A German page with decimal commas in what it says: texts, and labels of screen readers and tooltips."""
    parts, end = [], 0
    for kept in _PART.finditer(page):
        tag = kept[0] if kept.lastindex else _SPOKEN.sub(lambda label: with_commas(label[0]), kept[0])
        parts += [with_commas(page[end : kept.start()]), tag]
        end = kept.end()
    return "".join([*parts, with_commas(page[end:])])
