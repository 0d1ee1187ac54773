"""Standard deviations side by side: ratios of what both tell, and nothing hidden behind anything."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexcite.reports.compare import SPREAD, std_chart
from hexcite.reports.drawing.chart import Points
from hexcite.reports.page import section


def entry(name: str, deviations: dict[str, float]) -> Any:
    parameters = {n: SimpleNamespace(reported=std) for n, std in deviations.items()}
    return SimpleNamespace(name=name, level="identified", parameters=parameters)


GROUPS = (
    (entry("a", {"m": 0.2, "zC": 3e-5, "k0": 0.0}),),
    (entry("b", {"m": 0.1, "IC33": 7.0, "k0": 0.0}),),
    (entry("<b>c</b>", {"zC": 1.5e-5}),),
)


def series() -> list[Points]:
    return [points for points in std_chart(GROUPS).series if isinstance(points, Points)]


def test_each_parameter_is_measured_by_its_smallest_deviation():
    a, b, c = series()
    assert a.y == pytest.approx([2.0, 2.0])
    assert b.y == pytest.approx([1.0, 1.0])
    assert c.y == pytest.approx([1.0])
    assert "zC: 3e-05" in a.words[1]


def test_markers_stand_at_their_parameter_and_side_by_side():
    ticks = std_chart(GROUPS).x.names
    assert ticks == ("m", "zC", "k0", "IC33")
    places = np.concatenate([points.x for points in series()])
    assert len(np.unique(places.round(6))) == len(places)
    named = [label.split(":")[0] for points in series() for label in points.words]
    assert [ticks[round(x)] for x in places] == named
    assert np.abs(places - places.round()).max() < SPREAD / 2


def test_names_are_text():
    block = section("deviations", std_chart(GROUPS))
    assert "&lt;b&gt;c&lt;/b&gt;" in block
    assert "<b>c" not in block
