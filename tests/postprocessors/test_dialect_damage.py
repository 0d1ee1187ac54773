"""Programs with characters lost, doubled or swapped: understood and judged, or refused; never anything else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.errors import ProgramError
from tests.helpers import one_line
from tests.postprocessors.other_dialects import BOTH, SINUMERIK, TWINCAT, Typed, smooth_points

POLY = (
    "G64 G93\nPOLY PO[X]=(0.01,0,0.01) PO[C]=(0.001,0,0.001) PL=1 F600\n"
    "POLY PO[X]=(0.02,0.01,-0.01) PO[C]=(0.002) F600\nG94 G60 G1\nDO $A_OUT[1]=0\nG4 F0.1"
)
BODY = {
    "sinumerik": f"; small\nDO $A_OUT[1]=1\n{SINUMERIK.timed(smooth_points(SINUMERIK, 'X', 2.0, 6))}\n{POLY}\n"
    "G1 X5 A2=1 F3000\nG0 X0 Y0 Z900 A2=0\nG17 G3 X0 Y0 I5 J0 F3000",
    "twincat": f"(small)\nM100\n{TWINCAT.timed(smooth_points(TWINCAT, 'X', 2.0, 6))}\nM101\nG04 0.1\n"
    "G1 G60 X5 A1 F3000\nG0 G60 X0 Y0 Z900 A0\nG17 G3 G60 X0 Y0 I5 J0 F3000",
}
IN_STRUTS = {
    "sinumerik": "DO $A_OUT[1]=1\nPTP G93 G1 X50 Y20 A2=5 F60\nCP G94\nDO $A_OUT[1]=0\nG4 F0.1",
    "twincat": "M100\n#PTP ON\nG93\nG1 G60 X50 Y20 A5 F1\n#PTP OFF\nG94\nM101",
}
CHARACTERS = "0123456789.-+ XYZABCFGMPO()[]=\n;,eE%#/$\"'\t\u00e9"
EDITS = st.tuples(st.sampled_from("rdi2"), st.integers(0, 10_000), st.sampled_from(CHARACTERS))
both = pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)


def damaged(text: str, edits: list[tuple[str, int, str]]) -> str:
    for kind, position, character in edits:
        k = position % len(text)
        middle = {"r": character, "d": "", "i": character + text[k], "2": text[k] * 2}[kind]
        text = text[:k] + middle + text[k + 1 :]
    return text


@both
def test_the_program_before_the_damage_is_read(typed: Typed):
    assert len(typed.read(typed.text(BODY[typed.name])).events) > 10


@both
@settings(max_examples=300)
@given(edits=st.lists(EDITS, min_size=1, max_size=4))
def test_a_damaged_program_ends_in_a_proof_or_in_one_line(typed: Typed, edits: list[tuple[str, int, str]]):
    text = damaged(typed.text(BODY[typed.name]), edits)
    try:
        result = typed.proof(text)
    except ProgramError as error:
        assert one_line(error).startswith("p")
        return
    assert np.isfinite(result.duration)
    assert result.ok == (not result.violations)
    for violation in result.violations:
        assert 1 <= violation.line <= text.count("\n") + 1


@both
@settings(max_examples=60)
@given(edits=st.lists(EDITS, min_size=1, max_size=3))
def test_damaged_moves_in_the_struts_end_in_a_proof_or_in_one_line(typed: Typed, edits: list[tuple[str, int, str]]):
    body = IN_STRUTS[typed.name]
    assert any(getattr(event, "in_struts", False) for event in typed.read(typed.text(body)).events)
    try:
        result = typed.proof(typed.text(damaged(body, edits)))
    except ProgramError as error:
        assert one_line(error).startswith("p")
    else:
        assert result.ok == (not result.violations)


@pytest.mark.slow
@both
@settings(max_examples=3500)
@given(edits=st.lists(EDITS, min_size=1, max_size=6))
def test_thousands_of_damaged_programs_end_in_a_proof_or_in_one_line(typed: Typed, edits: list[tuple[str, int, str]]):
    try:
        result = typed.proof(damaged(typed.text(BODY[typed.name]), edits))
    except ProgramError as error:
        assert one_line(error).startswith("p")
    else:
        assert result.ok == (not result.violations)


@both
@settings(max_examples=60)
@given(share=st.floats(0.0, 0.995))
def test_a_program_that_breaks_off_is_never_taken_for_a_whole_one(typed: Typed, share: float):
    text = typed.text(BODY[typed.name])
    with pytest.raises(ProgramError):
        typed.read(text[: int(share * (len(text) - 2))])


@both
@given(junk=st.binary(max_size=200))
def test_junk_is_refused_in_one_line(typed: Typed, junk: bytes):
    from tests.postprocessors.other_dialects import CASE

    with pytest.raises(ProgramError) as caught:
        typed.language.read(junk, "p", CASE)
    one_line(caught.value)
