"""Standard deviations side by side: ratios of what both tell, and nothing hidden behind anything."""

import numpy as np
import pytest

from planner.reports.compare import SPREAD, ratio_chart

SERIES = (
    ("a", {"m": 0.2, "zC": 3e-5, "k0": 0.0}, {"color": "#000"}),
    ("b", {"m": 0.1, "IC33": 7.0, "k0": 0.0}, {"color": "#111", "symbol": "diamond"}),
    ("<b>c</b>", {"zC": 1.5e-5}, {"color": "#222"}),
)


def test_each_parameter_is_measured_by_its_smallest_deviation():
    a, b, c = ratio_chart("std", "Ratios.", SERIES).data
    assert a["y"] == pytest.approx([2.0, 2.0])
    assert b["y"] == pytest.approx([1.0, 1.0])
    assert c["y"] == pytest.approx([1.0])
    assert "zC: 3e-05" in a["text"]


def test_markers_stand_at_their_parameter_and_side_by_side():
    figure = ratio_chart("std", "Ratios.", SERIES)
    ticks = figure.layout["xaxis"]["ticktext"]
    assert ticks == ["m", "zC", "k0", "IC33"]
    places = np.concatenate([trace["x"] for trace in figure.data])
    assert len(np.unique(places.round(6))) == len(places)
    named = [label.split(":")[0] for trace in figure.data for label in trace["text"]]
    assert [ticks[round(x)] for x in places] == named
    assert np.abs(places - places.round()).max() < SPREAD / 2


def test_names_are_text():
    assert "&lt;b&gt;c&lt;/b&gt;" in ratio_chart("std", "Ratios.", SERIES).__html__()


@pytest.mark.parametrize("largest", [1.3, 3.0, 30.0])
def test_the_axis_has_labels_where_the_markers_are(largest: float):
    figure = ratio_chart(
        "std", "Ratios.", [("a", {"m": 1.0}, {"color": "#000"}), ("b", {"m": largest}, {"color": "#111"})]
    )
    ticks = figure.layout["yaxis"]["tickvals"]
    assert sum(1.0 <= tick <= largest for tick in ticks) >= 3
