"""Random edits of numbers, words and lines: what is nevertheless called proven is judged again by a naive reading."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.errors import ProgramError
from tests.helpers import one_line
from tests.postprocessors.edited import EVERY_DIALECT, NAMES, changed, moves, proof
from tests.postprocessors.naive import naive_share

DAMAGE = st.tuples(
    st.sampled_from(["digit", "sign", "point", "delete", "double", "swap", "word", "letter"]),
    st.integers(0, 10_000),
    st.integers(0, 9),
)


def edited(text: str, edits: list[tuple[str, int, int]]) -> str:
    """Numbers, words and lines edited so that the syntax mostly stays intact."""
    for kind, where, digit in edits:
        lines = text.rstrip("\n").split("\n")
        if kind in ("delete", "double", "swap"):
            k = where % (len(lines) - 1)
            lines[k : k + 2] = {"delete": [lines[k + 1]], "double": [lines[k]] * 2 + [lines[k + 1]]}.get(
                kind, [lines[k + 1], lines[k]]
            )
            text = "\n".join(lines) + "\n"
            continue
        pattern = {"word": r"\b[GM]\d+\b ?", "letter": r"[XYZABC](?=-?\d)"}.get(kind, r"(?<=[XYZABCF=])-?\d+(?:\.\d+)?")
        found = list(re.finditer(pattern, text))
        match = found[where % len(found)]
        old = match[0]
        k = where % len(old)
        new = {
            "digit": old[:k] + (str(digit) if old[k].isdigit() else old[k]) + old[k + 1 :],
            "sign": old[1:] if old[0] == "-" else f"-{old}",
            "point": f"{float(old) * 10 ** (digit % 3 - 1):.6f}" if kind == "point" else "",
            "word": "",
            "letter": "XYZABC"[digit % 6],
        }[kind]
        text = text[: match.start()] + new + text[match.end() :]
    return text


def judged(name: str, edits: list[tuple[str, int, int]]) -> None:
    text = edited(moves(name), edits)
    try:
        result = proof(name, text)
    except ProgramError as error:
        assert one_line(error).startswith("p")
        return
    if result.ok:
        assert naive_share(name, text) <= 1.0 + 1e-6, text


each = pytest.mark.parametrize("name", NAMES)


@each
@settings(max_examples=100, deadline=None)
@given(edits=st.lists(DAMAGE, min_size=1, max_size=3))
def test_what_is_proven_of_an_edited_program_holds_by_a_naive_reading_too(name: str, edits: list[tuple[str, int, int]]):
    judged(name, edits)


@pytest.mark.slow
@each
@settings(max_examples=3400, deadline=None)
@given(edits=st.lists(DAMAGE, min_size=1, max_size=5))
def test_ten_thousand_edits_of_numbers_words_and_lines(name: str, edits: list[tuple[str, int, int]]):
    judged(name, edits)


@each
def test_the_naive_judge_sees_what_is_dangerous(name: str):
    assert 0.3 < naive_share(name, moves(name)) <= 1.0
    for edit in ("a feed ten times as high", "a height below ground", "a position ten times as far"):
        assert naive_share(name, changed(moves(name), *EVERY_DIALECT[edit])) > 1.0
