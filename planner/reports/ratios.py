"""Standard deviations side by side: each over the smallest of its parameter, so that every unit has one axis."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from planner.reports.charts import Chart
from planner.reports.page import plain

CLOSE, FAR = [1, 1.1, 1.2, 1.5, 2, 3, 4], [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]  # labels, for the largest ratio
SPREAD = 0.7  # of the distance between two parameters, over which the markers of one stand side by side


class Series(NamedTuple):
    """Standard deviations of one method.

    Args:
        name: name in the legend.
        deviations: deviations by parameter; parameters that it does not tell are missing.
        colour: colour of its markers.
        symbol: plotly's name of the marker.
    """

    name: str
    deviations: Mapping[str, float]
    colour: str
    symbol: str = "circle"


def ratio_figure(series: Sequence[Series]) -> Chart:
    """Standard deviations over the smallest of each parameter, on a logarithmic axis; 0 (a given value) is left out."""
    names = list(dict.fromkeys(n for s in series for n in s.deviations))
    known = {n: [s.deviations[n] for s in series if s.deviations.get(n, 0.0) > 0.0] for n in names}
    best = {n: min(values) for n, values in known.items() if values}
    figure = Chart()
    for k, one in enumerate(series):
        told = [n for n in one.deviations if n in best and one.deviations[n] > 0.0]
        aside = SPREAD * ((k + 0.5) / len(series) - 0.5)
        figure.add_scatter(
            x=[names.index(n) + aside for n in told],
            y=[one.deviations[n] / best[n] for n in told],
            name=plain(one.name),
            mode="markers",
            marker={"size": 8, "color": one.colour, "symbol": one.symbol},
            text=[f"{plain(n)}: {one.deviations[n]:.3g}" for n in told],
            hovertemplate="%{text} (SI), %{y:.3g} times the smallest",
        )
    figure.update_xaxes(
        range=[-0.6, len(names) - 0.4], showgrid=False, zeroline=False, tickvals=list(range(len(names))),
        ticktext=[plain(n) for n in names], tickangle=-90,
    )  # fmt: skip
    largest = max((one.deviations[n] / best[n] for one in series for n in one.deviations if n in best), default=1.0)
    figure.update_yaxes(title="times the smallest", type="log", tickvals=CLOSE if largest < CLOSE[-1] else FAR)
    return figure
