"""Standard deviations side by side: ratios of what both tell, and nothing hidden behind anything."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from planner.reports.compare import SPREAD, std_chart


def entry(name: str, deviations: dict[str, float]) -> Any:
    parameters = {n: SimpleNamespace(reported=std) for n, std in deviations.items()}
    return SimpleNamespace(name=name, level="identified", parameters=parameters)


GROUPS = (
    (entry("a", {"m": 0.2, "zC": 3e-5, "k0": 0.0}),),
    (entry("b", {"m": 0.1, "IC33": 7.0, "k0": 0.0}),),
    (entry("<b>c</b>", {"zC": 1.5e-5}),),
)


def test_each_parameter_is_measured_by_its_smallest_deviation():
    a, b, c = std_chart(GROUPS).data
    assert a["y"] == pytest.approx([2.0, 2.0])
    assert b["y"] == pytest.approx([1.0, 1.0])
    assert c["y"] == pytest.approx([1.0])
    assert "zC: 3e-05" in a["text"]


def test_markers_stand_at_their_parameter_and_side_by_side():
    figure = std_chart(GROUPS)
    ticks = figure.layout["xaxis"]["ticktext"]
    assert ticks == ["m", "zC", "k0", "IC33"]
    places = np.concatenate([trace["x"] for trace in figure.data])
    assert len(np.unique(places.round(6))) == len(places)
    named = [label.split(":")[0] for trace in figure.data for label in trace["text"]]
    assert [ticks[round(x)] for x in places] == named
    assert np.abs(places - places.round()).max() < SPREAD / 2


def test_names_are_text():
    assert "&lt;b&gt;c&lt;/b&gt;" in std_chart(GROUPS).__html__()
