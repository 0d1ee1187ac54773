"""What stands in a header stays in its comment and says nothing to the controller."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from postprocessors.blocks import Blocks, ToHome
from postprocessors.dialects.linuxcnc.read import LONGEST_LINE
from tests.postprocessors.programs import HOME, linuxcnc_text, read_linuxcnc

MOVE = (ToHome(HOME, 0.05),)
ESCAPES = [
    "a) G1 X100 (b",
    "a)\nG1 X100\n(b",
    "a)\r\nG1 X100",
    "(nested (twice))",
    ";) M2",
    "Vorschub für Größe µ°²",
    "\x00\x07\x0b\x0c\x1b\x85\u2028\u2029",
    "% /",
    "",
]


COMMANDS = ["MSG, hello", "debug, x", " LOGOPEN,stolen.txt", "Print, x", "AXIS,stop", "LOGCLOSE"]


def header_of(text: str) -> Blocks:
    return (text, *MOVE)


@given(text=st.text(max_size=400))
def test_any_header_becomes_comment_lines_of_printable_ascii_and_nothing_else(text: str):
    lines = linuxcnc_text(header_of(text)).split("\n")
    program = linuxcnc_text(MOVE).split("\n")
    comments = lines[: len(lines) - len(program)]
    assert lines[len(comments) :] == program
    for line in comments:
        assert (line[0], line[-1]) == ("(", ")")
        assert set(line[1:-1]).isdisjoint("()")
        assert all(" " <= c <= "~" for c in line)


@given(text=st.text(st.characters(min_codepoint=32, max_codepoint=126), min_size=240, max_size=2000))
def test_a_long_header_does_not_make_a_line_that_the_controller_refuses(text: str):
    assert max(map(len, linuxcnc_text(header_of(text)).splitlines())) <= LONGEST_LINE


@pytest.mark.parametrize("text", ESCAPES)
def test_a_header_cannot_break_out_of_its_comment(text: str):
    assert (
        len(read_linuxcnc(linuxcnc_text(header_of(text)), "p.ngc").stretches) == 2
    )  # to home: what slides, what turns


@pytest.mark.linuxcnc
@pytest.mark.parametrize("text", [*COMMANDS, *ESCAPES])
def test_linuxcnc_takes_a_header_as_a_comment_and_not_as_a_command(text: str, rs274: Callable):
    """Comments that begin with MSG, LOGOPEN and the like are commands, blanks before the word notwithstanding."""
    text = linuxcnc_text(header_of(text))
    commands = [name for name, _ in rs274(text)]
    program = [name for name, _ in rs274(linuxcnc_text(MOVE))]
    assert [c for c in commands if c != "COMMENT"] == [c for c in program if c != "COMMENT"]
    extra = text.count("(") - linuxcnc_text(MOVE).count("(")
    assert commands.count("COMMENT") == program.count("COMMENT") + extra
