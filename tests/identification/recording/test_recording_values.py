"""A recording that is made in Python checks itself: what cannot be is one error with the argument's name."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cases.base.errors import RecordingError
from identification.recording.recording import Recording
from tests.helpers import one_line

COUNT = 20
T = 1e-3 * np.arange(COUNT)
DRAW = np.random.default_rng(0)
FORCES, STRUTS = DRAW.normal(size=(COUNT, 6)), DRAW.normal(size=(COUNT, 6))
SOUND = Recording("run", T, STRUTS, None, FORCES, T > 0.01)
HOLE = FORCES.copy()
HOLE[7, 2] = np.nan

WRONG: dict[str, tuple[str, Any, tuple[str, ...]]] = {
    "fewer forces": ("forces", FORCES[:-5], ("15", "20")),
    "fewer struts": ("drives", STRUTS[:-1], ("19 rows", "forces has 20")),
    "five forces": ("forces", FORCES[:, :5], ("(20, 5)", "(n, 6)")),
    "one row": ("forces", FORCES[0], ("(6,)", "(n, 6)")),
    "no forces": ("forces", None, ("None",)),
    "a number": ("forces", 3.0, ("shape ()", "(n, 6)")),
    "words": ("forces", np.full((COUNT, 6), "x"), ("<U1",)),
    "a word": ("drives", "l1", ("'l1'",)),
    "objects": ("drives", np.full((COUNT, 6), None), ("object",)),
    "complex numbers": ("drives", STRUTS * 1j, ("complex",)),
    "ragged rows": ("drives", [[1.0], [1.0, 2.0]], ("equal rows",)),
    "a time that is not a number": ("t", np.where(T[4] == T, np.nan, T), ("row 4",)),
    "an infinite time": ("t", np.where(T[0] == T, np.inf, T), ("row 0",)),
    "a force that is not a number": ("forces", HOLE, ("row 7", "missing")),
    "a mask": ("forces", np.ma.array(FORCES, mask=FORCES > 2.0), ("masked array",)),
    "a masked time": ("t", np.ma.array(T, mask=T[3] == T), ("hides 1 of its 20",)),
    "rotations": ("rotations", np.zeros((COUNT, 9)), ("(20, 9)", "(n, 3, 3)")),
    "a voltage": ("trigger", 24.0 * (T > 0.01), ("0 and 1",)),
    "a source": ("source", 3, ("3",)),
    "a case": ("case", "hexapod", ("'hexapod'", "hx.load_case")),
    "paths": ("paths", (3,), ("(3,)",)),
    "a record": ("record", [1], ("[1]",)),
    "averages": ("averaged", 0.0, ("0.0",)),
    "others": ("others", (FORCES,), ("a ndarray",)),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_is_refused_by_name(what: str) -> None:
    name, value, words = WRONG[what]
    with pytest.raises(RecordingError) as caught:
        replace(SOUND, **{name: value})
    line = one_line(caught.value)
    assert line.startswith(f"Recording: {name}" if what != "fewer forces" else "Recording: ")
    for word in words:
        assert word in line


def test_what_means_the_same_is_taken() -> None:
    """Integers, lists, other floats, flags of 0 and 1, masks that hide nothing, and one path."""
    whole = np.rint(100.0 * FORCES)
    other = Recording("run", T.tolist(), STRUTS.astype(np.float32), None, whole.astype(int),
                      (T > 0.01).astype(int), paths="run.csv")  # fmt: skip
    np.testing.assert_array_equal(other.forces, whole)
    np.testing.assert_array_equal(other.trigger, SOUND.trigger)
    assert {array.dtype.name for array in other.channels.values()} == {"float64", "bool"}
    assert [path.name for path in other.paths] == ["run.csv"]
    masked = replace(SOUND, forces=np.ma.array(FORCES, mask=False))
    assert type(masked.forces) is np.ndarray


def test_a_row_that_is_missing_needs_no_value() -> None:
    assert replace(SOUND, forces=HOLE, missing=np.arange(COUNT) == 7).bad.sum() == 1
