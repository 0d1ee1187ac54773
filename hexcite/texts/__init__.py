"""The words of the page in English and German, by stage; of what commands answer by code in `answers`."""

from typing import Literal

from hexcite.texts import certificate, common, data, machine, plan, program, refusals, result, use

Language = Literal["en", "de"]
LANGUAGES: tuple[Language, ...] = ("en", "de")

PARTS = (certificate, common, machine, plan, program, data, result, use, refusals)
TEXTS: dict[str, tuple[str, str]] = {key: words for part in PARTS for key, words in part.TEXTS.items()}
"""Key -> English, German."""


def text(key: str, language: Language, **values: object) -> str:
    """A text of the page, with values in its places; raises KeyError for a key that there is not."""
    words = TEXTS[key][LANGUAGES.index(language)]
    return words.format(**values) if values else words


def language_of(accepted: str) -> Language:
    """The first of our languages that a browser accepts, by its header; English where it is none of them."""
    ranked = []
    for k, part in enumerate(accepted.lower().split(",")[:20]):
        name, _, quality = part.strip().partition(";q=")
        try:
            rank = -float(quality or 1.0)
        except ValueError:
            continue
        ranked.append((rank, k, name.split("-")[0]))
    return next((language for _, _, name in sorted(ranked) for language in LANGUAGES if language == name), "en")
