"""Programs that break off, and junk, are refused in one line; what is proven can be run."""

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import ProgramError
from postprocessors.controllers.virtual import run_virtual
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.proof.proof import prove_program
from tests.bench.reliability.programs import edited, originals
from tests.helpers import examples, one_line
from tests.postprocessors.other_dialects import BOTH, CASE, LINUXCNC, Typed
from tests.postprocessors.programs import read_linuxcnc

each = pytest.mark.parametrize("typed", [*BOTH, LINUXCNC], ids=lambda t: t.name)


@each
def test_the_programs_before_the_damage_are_read(typed: Typed):
    for text in originals(typed.name):
        assert len(typed.read(text).stretches) > 5


@each
@settings(max_examples=examples(20))
@given(share=st.floats(0.0, 0.995))
def test_a_program_that_breaks_off_is_never_taken_for_a_whole_one(typed: Typed, share: float):
    text = originals(typed.name)[-1]
    with pytest.raises(ProgramError):
        typed.read(text[: int(share * (len(text) - 3))])


@each
@given(junk=st.binary(max_size=200))
def test_junk_is_refused_in_one_line(typed: Typed, junk: bytes):
    with pytest.raises(ProgramError) as caught:
        typed.language.read(junk, "p", CASE)
    one_line(caught.value)


@settings(max_examples=examples(15))
@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_proven_can_be_run(seed: int):
    text = edited(originals("linuxcnc")[-1], random.Random(seed))
    try:
        reading = read_linuxcnc(text, "p.ngc")
        if not prove_program(reading, linuxcnc_guarantees(reading, CASE)).ok:
            return
    except ProgramError:
        return
    run = run_virtual(reading, linuxcnc_guarantees(reading, CASE))
    assert np.isfinite(run.execution.drives(np.linspace(0.0, run.execution.duration, 50))).all()
