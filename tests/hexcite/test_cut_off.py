"""Runs that were cut off, recordings of another machine, and programs of another case are told as such."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import IdentificationError, RecordingError
from cases.basis import COMPUTED_FROM, recording_basis
from cases.schema import Case
from cases.tables import built_in_cases
from identification.identify import identify
from identification.samples.sample_checks import cut_off
from tests.helpers import tells
from tests.hexcite.command_line import refused
from tests.identification.findings.test_findings import CASE, run


def test_a_recording_that_ends_with_its_trigger_on_is_told() -> None:
    whole = run()
    end = int(np.flatnonzero(whole.trigger)[-1]) - 200
    columns = ("t", "drives", "forces", "trigger")
    cut = replace(whole, **{name: getattr(whole, name)[:end] for name in columns})
    assert any(re.match(r"line \d+: .*ends.*trigger", str(f)) for f in cut_off(cut))
    assert cut_off(whole) == []
    assert cut_off(replace(cut, trigger=np.ones(end, dtype=bool))) == []  # a column that says nothing


@pytest.mark.slow
def test_a_recording_of_another_case_is_named_as_such() -> None:
    data = tomllib.loads(built_in_cases()["hexapod"].read_text(encoding="utf-8"))
    data["machine"]["base"]["ring"]["radius_mm"] *= 3.0
    wide = Case.model_validate(data | {"name": "wide"})
    with pytest.raises(IdentificationError, match="case other, not wide"):
        identify(replace(run(), record={"case": "other"}), wide)
    weak = Case.model_validate(data | {"name": "weak", "sensors": data["sensors"] | {"range_N": 1.0}})
    with pytest.raises(RecordingError, match="case other, not weak"):
        identify(replace(run(), record={"case": "other"}), weak)


def test_a_recording_of_another_case_that_can_be_evaluated_is_named_first() -> None:
    """Sensors differ, columns do not; a case that only has another name is the same machine."""
    record = {"case": "other", COMPUTED_FROM: recording_basis(CASE)}
    assert not any("recorded with" in w for w in identify(replace(run(), record=record), CASE).warnings)
    turned = replace(
        run(), record=record | {COMPUTED_FROM: recording_basis(CASE) | {"setup": "2x", "gravity_m_s2": None}}
    )
    first, *_ = identify(turned, CASE).warnings
    assert tells(first, "case other, not hexapod", "setup was 2x, is 1b (1 more)", "with its own case")


def test_a_program_of_another_case_is_named_as_such_first(tmp_path: Path) -> None:
    program = tmp_path / "a.ngc"
    program.write_text("(case other, hash 0123456789abcdef, controller settings 0123456789abcdef)\nG1 X900 F100\nM2\n")
    line = refused("run", program, "--case", "hexapod", "-o", tmp_path / "r")
    assert tells(line, "another case, other", "this is hexapod; ")
