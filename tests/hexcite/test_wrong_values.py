"""Whatever stands for an argument of a public function: an answer, or one HexciteError that names the argument."""

import inspect
from typing import Any

import numpy as np
import pytest

import hexcite as hx
from cases.schema import Case

RECORDING = hx.Recording("run.csv", None, None, None, np.zeros((3, 6)), None)
TYPES = (
    "HexciteError", "Case", "Finding", "History", "Identifiability", "Look", "Model", "ModelChoice", "Plan", "Prior",
    "Program", "Recording", "Result", "Verdict",
)  # fmt: skip
FUNCTIONS = tuple(
    name for name in dir(hx) if name not in TYPES and name != "TYPE_CHECKING" and not name.startswith("_")
)
NOTHING_TAKES: dict[str, Any] = {
    "an object": object(),
    "bytes": b"x",
    "a complex number": 1j,
    "a null character": "a\0b",
    "words of NumPy": np.array(["a", "b"]),
}


def _arguments(name: str, case: Case) -> tuple[dict[str, Any], list[str]]:
    """Arguments that a function needs, and those that may be wrong; what is a bool may be anything."""
    parameters = inspect.signature(getattr(hx, name)).parameters.values()
    named = [p for p in parameters if p.kind is not p.VAR_KEYWORD]
    known = {"case": case, "recording": RECORDING}
    needed = {p.name: known.get(p.name, "nowhere") for p in named if p.default is p.empty}
    return needed, [p.name for p in named if p.annotation is not bool]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_no_argument_can_be_is_refused_by_its_name(name: str, hexapod_case: Case) -> None:
    needed, wrong = _arguments(name, hexapod_case)
    for argument in wrong:
        others = {key: value for key, value in needed.items() if value != "nowhere" or key == argument}
        for what, value in NOTHING_TAKES.items():
            with pytest.raises((hx.HexciteError, TypeError)) as caught:
                getattr(hx, name)(**others | {argument: value})
            if isinstance(caught.value, TypeError):  # Python's own words for arguments that are missing
                assert "missing a required argument" in str(caught.value), (argument, what)
                continue
            assert argument in str(caught.value), (argument, what)
            assert "\n" not in str(caught.value)


def test_numbers_of_numpy_are_numbers(hexapod_case: Case) -> None:
    assert hx.PointToPoint(moves=np.int64(40)) == hx.PointToPoint(moves=40)
    assert hx.ValidationSettings(seed=np.int32(3)).seed == 3
    assert type(hx.ValidationSettings(seed=np.uint8(3)).seed) is int
    with pytest.raises(hx.HexciteError, match=r"model .*99"):
        hx.identify(RECORDING, hexapod_case, model=np.int64(99))


@pytest.mark.parametrize("kind", [hx.Plan, hx.Program, hx.Result, hx.Recording], ids=lambda kind: kind.__name__)
def test_what_is_loaded_is_a_path(kind: Any, hexapod_case: Case) -> None:
    for value in (3, None, b"x", ["x", 3], object(), "a\0b", "x" * 5000):
        with pytest.raises(hx.HexciteError) as caught:
            kind.load(value, hexapod_case)
        assert len(str(caught.value)) < 2000


def test_known_values_are_finite_numbers() -> None:
    for known in ({"m": "2"}, {"m": np.nan}, {3: 1.0}):
        with pytest.raises(hx.HexciteError, match="not a finite number"):
            hx.Method(known=known)
    with pytest.raises(hx.HexciteError, match="m = 'x': is not a finite number"):
        hx.Method(priors=(hx.Prior("m", "x", 1.0),))
