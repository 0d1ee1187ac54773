"""Marks of elements that hold a text of ours and nothing else, by which a page can be made in another language."""

import json
from typing import TypeGuard

from markupsafe import Markup

from cases.base.phrases import QUOTED, Phrase


def mark(text: str) -> Markup:
    """The attribute of an element that holds a text: the entries of its phrase, empty where it has no code."""
    return Markup(' data-said="{}"').format(json.dumps(text.to_json()) if has_code(text) else "")


def has_code(text: str) -> TypeGuard[Phrase]:
    """Whether a text is a phrase with a code of its own."""
    return isinstance(text, Phrase) and text.code != QUOTED
