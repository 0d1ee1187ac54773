"""Programs with characters lost, doubled or swapped: understood and judged, or refused; never anything else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.errors import ProgramError
from cases.loading import load_case
from postprocessors.execute.linuxcnc.guarantees import linuxcnc_guarantees
from postprocessors.execute.virtual import run_virtual
from postprocessors.proving.proof import prove_program
from postprocessors.proving.stretches import Timed, stretches
from postprocessors.reading.linuxcnc import read_linuxcnc
from tests.helpers import one_line
from tests.postprocessors.independent import share_of_limits
from tests.postprocessors.programs import proof, there_and_back, timed, typed

CASE = load_case("hexapod")
TEXT = typed(f"(small)\nG4 P0.1\nM64 P0\n{timed(there_and_back(10))}\nM65 P0\nG1 X5 A1 F3000\nG0 X0 Y0 Z900 A0")
CHARACTERS = "0123456789.-+ XYZABCFGMP()\n;,eE%#/\t\u00e9\u0661"
EDITS = st.tuples(st.sampled_from("rdi2"), st.integers(0, len(TEXT) - 1), st.sampled_from(CHARACTERS))


def damaged(edits: list[tuple[str, int, str]]) -> str:
    text = TEXT
    for kind, position, character in edits:
        k = min(position, len(text) - 1)
        middle = {"r": character, "d": "", "i": character + text[k], "2": text[k] * 2}[kind]
        text = text[:k] + middle + text[k + 1 :]
    return text


def test_the_program_before_the_damage_is_proven():
    assert proof(TEXT, CASE).ok


def judged(edits: list[tuple[str, int, str]]) -> None:
    """A proof, or one line that names the place; what is called proven the independent judge must let pass."""
    text = damaged(edits)
    try:
        result = proof(text, CASE)
    except ProgramError as error:
        assert one_line(error).startswith("p.ngc")
        return
    assert np.isfinite(result.duration)
    assert result.ok == (not result.violations)
    for violation in result.violations:
        assert 1 <= violation.line <= text.count("\n") + 1
        assert "limit" in violation.sentence()
    if result.ok:
        for stretch in stretches(read_linuxcnc(text, "p.ngc")):
            if isinstance(stretch, Timed):
                assert share_of_limits(stretch.points.times, stretch.points.poses, CASE) < 1.001


@settings(max_examples=300)
@given(edits=st.lists(EDITS, min_size=1, max_size=4))
def test_a_damaged_program_ends_in_a_proof_or_in_one_line(edits: list[tuple[str, int, str]]):
    judged(edits)


@pytest.mark.slow
@settings(max_examples=10_000, deadline=None)
@given(edits=st.lists(EDITS, min_size=1, max_size=4))
def test_ten_thousand_damaged_programs_end_in_a_proof_or_in_one_line(edits: list[tuple[str, int, str]]):
    judged(edits)


@settings(max_examples=40)
@given(edits=st.lists(EDITS, min_size=1, max_size=3))
def test_what_is_proven_can_be_run(edits: list[tuple[str, int, str]]):
    try:
        reading = read_linuxcnc(damaged(edits), "p.ngc")
        if not prove_program(reading, CASE, linuxcnc_guarantees(reading, CASE)).ok:
            return
    except ProgramError:
        return
    run = run_virtual(reading, CASE, linuxcnc_guarantees(reading, CASE))
    assert np.isfinite(run.execution.struts(np.linspace(0.0, run.execution.duration, 50))).all()


@settings(max_examples=60)
@given(cut=st.integers(0, len(TEXT) - 3))
def test_a_program_that_breaks_off_is_never_taken_for_a_whole_one(cut: int):
    text = TEXT[:cut]
    try:
        read_linuxcnc(text, "p.ngc")
    except ProgramError as error:
        one_line(error)
    else:
        raise AssertionError(f"read without its end: {text[-40:]!r}")
