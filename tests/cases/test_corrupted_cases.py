"""Whatever a case file holds, the answer is a usable case or one line."""

import tomllib
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.loading import load_case
from cases.schema import Case
from tests.cases.editing import HEXAPOD, written
from tests.helpers import answer

Path_ = tuple[str | int, ...]


def places(data: Any, path: Path_ = ()) -> list[Path_]:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [found for key, value in items for found in ((*path, key), *places(value, (*path, key)))]


ORIGINAL = tomllib.loads(HEXAPOD)
WHOLE = Case.model_validate(ORIGINAL)
PLACES = places(ORIGINAL)
number = st.integers(-(10**6), 10**6) | st.floats(-1e6, 1e6) | st.sampled_from([float("nan"), float("inf"), 0.0, 1e-12])
word = st.text(st.characters(exclude_categories=["C"]), max_size=8)
simple = number | word | st.booleans()
anything = simple | st.lists(simple, max_size=7) | st.dictionaries(word, simple, max_size=3)


def holder_of(data: Any, path: Path_) -> Any:
    for key in path[:-1]:
        data = data[key]
    return data


def hashes(case: Case) -> tuple[str, str]:
    return case.hash, case.controller_hash


def load(folder: Path, data: dict[str, Any]) -> Case | None:
    """The case, or None after an error in one line that names the file."""
    file = written(folder, data)
    return answer(lambda: load_case(file), file)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=2 * settings().max_examples)
@given(which=st.integers(0, len(PLACES) - 1))
def test_a_key_that_is_gone(which: int, tmp_path: Path) -> None:
    data = tomllib.loads(HEXAPOD)
    del holder_of(data, PLACES[which])[PLACES[which][-1]]
    case = load(tmp_path, data)
    assert case is None or (hashes(case) == hashes(WHOLE)) == (case.model_dump() == WHOLE.model_dump())


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=4 * settings().max_examples)
@given(which=st.integers(0, len(PLACES) - 1), value=anything)
def test_a_value_of_another_kind(which: int, value: Any, tmp_path: Path) -> None:
    data = tomllib.loads(HEXAPOD)
    holder_of(data, PLACES[which])[PLACES[which][-1]] = value
    case = load(tmp_path, data)
    assert case is None or len(case.hash) == 16


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=2 * settings().max_examples)
@given(which=st.integers(0, len(PLACES) - 1), key=word, value=anything)
def test_a_key_too_many(which: int, key: str, value: Any, tmp_path: Path) -> None:
    data = tomllib.loads(HEXAPOD)
    holder = holder_of(data, PLACES[which])
    if isinstance(holder, list):
        holder.append(value)
        assert load(tmp_path, data) is None
    elif key not in holder:
        holder[key] = value
        load(tmp_path, data)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=2 * settings().max_examples)
@given(at=st.integers(0, len(HEXAPOD)), length=st.integers(0, 40), noise=st.binary(max_size=4))
def test_a_file_with_a_hole_or_a_stain(at: int, length: int, noise: bytes, tmp_path: Path) -> None:
    raw = HEXAPOD.encode()
    file = tmp_path / "case.toml"
    file.write_bytes(raw[:at] + noise + raw[at + length :])
    case = answer(lambda: load_case(str(file)), str(file))
    assert case is None or len(case.hash) == 16
