"""What `recording.json` says is a typed record: round trips, entries that are not known, what version 0.2 wrote."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import HexciteError
from cases.schema import Case
from identification.recording.record import RunRecord
from identification.recording.recording import Recording

EXECUTED = {
    "controller": "virtual", "executed_s": 2.5, "planned_s": 2, "path_error_mm": 0.25, "d_efficiency": None,
    "d_efficiency_planned": None, "peaks_of_limit": {"velocity": 0.5}, "exceeded": ["jerk"], "remark": "",
}  # fmt: skip
RUN = {
    "schema_version": 1, "case": "mill", "case_hash": "0123", "program": "/p.ngc", "plan_hash": None, "seed": 3,
    "payload": {"weights": 1, "mass_kg": 12.5}, "poses_m_rad": [[0.0] * 6, [0.1] * 6], "simulated": True,
    "trigger_windows_s": [[0.5, 2.0]], "units": "SI with the unit in each column name",
}  # fmt: skip


@given(
    left_out=st.sets(st.sampled_from(sorted(RUN))),
    executed=st.booleans(),
    further=st.dictionaries(st.text(min_size=1).map("x_".__add__), st.integers() | st.text(), max_size=3),
)
def test_entries_come_back_also_those_that_no_field_names(
    left_out: set[str], executed: bool, further: dict[str, Any]
) -> None:
    entries = {key: value for key, value in RUN.items() if key not in left_out} | further
    entries |= EXECUTED if executed else {}
    record = RunRecord.of_json(entries)
    assert json.loads(json.dumps(record.to_json())) == entries
    assert (record.executed is not None) == executed
    assert all(record[key] == value for key, value in entries.items())  # as version 0.2 read it
    assert record.origin.mounted == (0.0 if "payload" in left_out else 12.5)


@pytest.mark.parametrize("key", sorted(set(EXECUTED) - {"executed_s", "d_efficiency_planned"}))
def test_an_entry_of_a_run_that_is_missing_is_named(key: str) -> None:
    with pytest.raises(HexciteError) as caught:
        RunRecord.of_json({name: value for name, value in (RUN | EXECUTED).items() if name != key})
    assert caught.value.place == key


@pytest.mark.parametrize(
    ("key", "value"), [("plan_hash", 5), ("case", 1.0), ("payload", [1]), ("poses_m_rad", [["x"]]), ("planned_s", -1.0)]
)
def test_an_entry_of_another_kind_is_named(key: str, value: object) -> None:
    with pytest.raises(HexciteError) as caught:
        RunRecord.of_json(RUN | EXECUTED | {key: value})
    assert caught.value.place.split(".")[0] == key


def test_a_mapping_is_read_as_in_version_0_2(hexapod_case: Case) -> None:
    run = Recording("r", np.arange(5) * 1e-3, np.ones((5, 6)), None, np.ones((5, 6)), None, case=hexapod_case)
    given = replace(run, record=RUN | EXECUTED)
    assert given.record == RunRecord.of_json(RUN | EXECUTED)
    assert given.executed.executed_s == 2.5
    assert given.record is not None
    assert given.record["executed_s"] == 2.5
    assert replace(run, record={}).record is None
    with pytest.raises(HexciteError, match="not a run of hexcite"):
        _ = run.executed
