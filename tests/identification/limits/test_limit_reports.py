"""Reports of limits come back as they were saved, whatever a box is called; those of version 0.2 by their names."""

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.limits.limit import Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Status

NAMES = ("vice", "vice, untimed moves", "vice (left)", "distance from vice, way home", " (a) ")


def report(box: str, move: OwnMove | None, place: str) -> LimitReport:
    limit = Limit(LimitKind.DISTANCE_FROM_BOX, box, move)
    return LimitReport((LimitCheck(limit, place, 12.0, 10.0, "mm", 0.5, 1.25, Status.PROVEN),))


@given(st.sampled_from(NAMES) | st.text(min_size=1), st.sampled_from([None, *OwnMove]), st.text())
def test_a_report_comes_back_whatever_boxes_and_places_are_called(box: str, move: OwnMove | None, place: str) -> None:
    saved = report(box, move, place)
    assert LimitReport.of_json(saved.to_json()) == saved


def _of_version_0_2(data: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    new = ("kind", "box", "move", "place")
    return {name: {key: value for key, value in entry.items() if key not in new} for name, entry in data.items()}


@pytest.mark.parametrize("move", [None, *OwnMove])
@pytest.mark.parametrize("place", ["", "tool"])
def test_reports_of_version_0_2_are_read(move: OwnMove | None, place: str) -> None:
    saved = report("vice", move, place)
    assert LimitReport.of_json(_of_version_0_2(saved.to_json())) == saved
