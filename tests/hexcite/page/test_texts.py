"""The page speaks both languages wherever it speaks."""

import re
import string
from pathlib import Path

import pytest

from hexcite import page
from hexcite.texts import LANGUAGES, PARTS, TEXTS, language_of, text

FOLDER = Path(page.__file__).parent
ASKED = re.compile(r"""\bt\("(\w+)"[,)]""")


def test_every_text_is_there_in_both_languages_with_the_same_places():
    for key, words in TEXTS.items():
        assert len(words) == len(LANGUAGES)
        assert all(words), key
        places = [{name for _, name, _, _ in string.Formatter().parse(each) if name} for each in words]
        assert places[0] == places[1], key


def test_templates_ask_for_texts_that_there_are():
    asked = {key for file in (FOLDER / "templates").glob("*.jinja") for key in ASKED.findall(file.read_text())}
    assert len(asked) > 60
    assert asked <= TEXTS.keys()


@pytest.mark.parametrize(
    ("accepted", "language"),
    [("de-DE,de;q=0.9,en;q=0.8", "de"), ("fr,en;q=0.2,de;q=0.7", "de"), ("fr", "en"), ("", "en"), ("de;q=x", "en")],
)
def test_the_language_is_that_of_the_browser(accepted: str, language: str):
    assert language_of(accepted) == language
    assert text("plan", language_of(accepted))


def test_no_part_of_the_table_hides_a_text_of_another():
    assert sum(len(part.TEXTS) for part in PARTS) == len(TEXTS)
