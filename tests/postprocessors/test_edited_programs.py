"""One digit edited in a program: where a limit is passed the proof fails and names the line, else it holds."""

import re
from functools import cache

import numpy as np
import pytest

from cases.base.errors import ProgramError
from cases.schema import load_case
from postprocessors.proof.proof import ProgramProof
from tests.postprocessors.independent import points, share_of_limits, timed_lines
from tests.postprocessors.programs import proof, small_excitation

CASE = load_case("hexapod")
TEXT = small_excitation(CASE, period=0.6)
LINES = TEXT.splitlines()
FIRST, LAST = min(timed_lines(TEXT)), max(timed_lines(TEXT))
WORD = re.compile(r"([XYZABCF])(-?\d+(?:\.\d+)?)")
CRAWL = LINES.index("(- what is left, at a crawl)")
START = [float(number) for line in LINES[CRAWL + 1 : CRAWL + 3] for _, number in WORD.findall(line)[:3]]


def excitation_share(text: str) -> float:
    """Share of the limits that the excitation uses whatever the controller does between its points."""
    return share_of_limits(*points(timed_lines(text), np.array(START)), CASE)


def with_digit(line: int, position: int, digit: str) -> str:
    """The program with the character at `position` of `line` replaced."""
    old = LINES[line - 1]
    return "\n".join([*LINES[: line - 1], old[:position] + digit + old[position + 1 :], *LINES[line:]]) + "\n"


@cache
def random_edits() -> tuple[tuple[int, str, ProgramProof, float], ...]:
    """Line, text, proof and independent share of limits of edits at random digits, half of them of later decimals."""
    draw = np.random.default_rng(5)
    found = []
    while len(found) < 50:
        line = int(draw.integers(FIRST + 3, LAST - 3))
        words = list(WORD.finditer(LINES[line - 1]))
        word = words[draw.integers(len(words))]
        digits = [k for k in range(word.start(2), word.end(2)) if LINES[line - 1][k].isdigit()]
        position = digits[draw.integers(len(digits))]
        digit = str(draw.integers(10))
        if digit == LINES[line - 1][position]:
            continue
        text = with_digit(line, position, digit)
        if float(WORD.findall(text.splitlines()[line - 1])[-1][1]) < 60:
            continue  # a feed without its first digits: a block of minutes
        try:
            found.append((line, text, proof(text, CASE), excitation_share(text)))
        except ProgramError as error:  # a block of no whole cycles, which LinuxCNC does not keep
            assert word[1] == "F"
            assert error.line == line
    return tuple(found)


def test_the_program_itself_is_proven_and_the_independent_judge_agrees():
    assert proof(TEXT, CASE).ok
    assert 0.7 < excitation_share(TEXT) < 0.86


@pytest.mark.slow
def test_an_edit_that_no_motion_could_follow_within_the_limits_is_caught():
    broken = [(line, p) for line, _, p, share in random_edits() if share > 1.001]
    assert len(broken) > 15, "too few of the edits break a limit: not a test"
    assert [line for line, p in broken if p.ok] == []


def test_the_line_of_the_edit_is_named_within_two_lines():
    for line, _, p, share in random_edits():
        if share > 1.001:
            assert abs(p.violations[0].line - line) <= 2, p.violations[0].sentence()


def test_what_the_proof_lets_pass_the_independent_judge_lets_pass():
    passed = [share for _, _, p, share in random_edits() if p.ok]
    assert len(passed) > 9, "too few of the edits are harmless: not a test"
    assert max(passed) < 1.001


@pytest.mark.parametrize("letter", "XYZABC")
def test_an_edit_of_the_last_decimal_changes_nothing(letter: str):
    middle = (FIRST + LAST) // 2
    word = re.search(rf"{letter}-?\d+\.\d+", LINES[middle - 1])
    position = word.end() - 1
    digit = str((int(LINES[middle - 1][position]) + 5) % 10)
    assert proof(with_digit(middle, position, digit), CASE).ok


@pytest.mark.parametrize("factor", [2.0, 5.0, 10.0])
def test_a_faster_feed_in_one_line_is_caught(factor: float):
    middle = (FIRST + LAST) // 2
    line = re.sub(r"F([\d.]+)", lambda m: f"F{float(m[1]) * factor:.6f}", LINES[middle - 1])
    text = "\n".join([*LINES[: middle - 1], line, *LINES[middle:]])
    assert excitation_share(text) > 1.0
    result = proof(text, CASE)
    assert not result.ok
    assert abs(result.violations[0].line - middle) <= 2


def test_all_feeds_raised_together_are_caught_as_soon_as_the_limits_are_passed():
    def at(factor: float) -> str:
        home, path = TEXT.split("G93", 1)  # the feed to home is the safe one, not any faster
        return f"{home}G93" + re.sub(r"F([\d.]+)", lambda m: f"F{float(m[1]) * factor:.6f}", path)

    assert proof(at(10 / 11), CASE).ok  # blocks of 11 ms
    assert excitation_share(at(10 / 8)) > 1.0
    assert not proof(at(10 / 8), CASE).ok
