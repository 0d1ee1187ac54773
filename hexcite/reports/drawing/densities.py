"""Normal densities of parameters (last row of Table 5), and residuals beside a normal distribution."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import ndtri

from cases.base.phrases import phrase
from hexcite.comparison.entries import Entry
from hexcite.reports.drawing.chart import Axis, Chart, Dash, Line, Points, colour
from hexcite.reports.drawing.figures import powers, unit_of
from identification.estimation.fit import Value
from identification.signals import Residuals
from identification.texts import legible

WIDTH = 4.0  # standard deviations to either side of the widest density
POINTS = 81  # of a density
TINY = 1e-300  # in place of zero
QUANTILES = 300  # of the residuals of a channel
SHOWN = ("m", "xC", "yC", "zC")  # parameters whose densities stand side by side in a comparison


def density(x: np.ndarray, std: float) -> np.ndarray:
    """Normal density of mean 0 and a standard deviation, shape (n,)."""
    return np.asarray(np.exp(-0.5 * (x / std) ** 2) / (std * np.sqrt(2.0 * np.pi)))


def density_charts(parameters: Mapping[str, Value]) -> tuple[Chart, ...]:
    """Densities of the parameters of a result about their values, a figure a unit; factors of deformation in percent.

    Factors of each sensor (K1, K3, K4) and parameters that are given are left out.
    """
    groups: dict[str, list[str]] = {}
    for name, value in parameters.items():
        if value.reported > 1e-9 * abs(value.value) and not name.startswith("K"):
            groups.setdefault("%" if name.startswith("k") else value.unit, []).append(name)
    charts = []
    for number, (si, names) in enumerate(groups.items()):
        scale, unit = legible(si)
        shares = {name: 100.0 / max(abs(parameters[name].value), TINY) if si == "%" else scale for name in names}
        std = {name: parameters[name].reported * share for name, share in shares.items()}
        x = np.linspace(-WIDTH, WIDTH, POINTS) * max(std.values())
        series = tuple(Line(x, density(x, s), name, colour(k)) for k, (name, s) in enumerate(std.items()))
        charts.append(
            Chart(
                f"density-{number}",
                phrase(
                    "density_of",
                    "Normal density of {names} about the estimate, by the reported standard deviation: the narrower "
                    "and "
                    "higher, the better known.",
                    names=", ".join(names),
                ),
                series,
                Axis(f"deviation from the estimate [{powers(unit)}]"),
                Axis(f"density [1/({powers(unit)})]"),
                height=260,
                half=True,
            )
        )
    return tuple(charts)


def compared_densities(entries: Sequence[Entry]) -> tuple[Chart, ...]:
    """Densities of mass and centre of gravity of each entry, one beside the other: about values, of plans about 0."""
    charts = []
    for name in SHOWN:
        densities = [(k, e, e.parameters[name]) for k, e in enumerate(entries) if name in e.parameters]
        densities = [(k, e, value) for k, e, value in densities if value.reported > 0.0]
        if not densities:
            continue
        scale, unit = legible(densities[0][2].unit)
        middles = [v.value * scale for _, _, v in densities if np.isfinite(v.value)]
        middle = float(np.mean(middles)) if middles else 0.0
        series = []
        for k, entry, value in densities:
            std, at = value.reported * scale, value.value * scale if np.isfinite(value.value) else middle
            x = at + np.linspace(-WIDTH, WIDTH, POINTS) * std
            dash: Dash = "solid" if entry.level == "identified" else "dash"
            series.append(Line(x, density(x - at, std), entry.name, colour(k), dash=dash))
        charts.append(
            Chart(
                f"density-{name}",
                f"Normal density of {name} by each; dashed: predicted by a plan, about the mean of the others.",
                tuple(series),
                Axis(f"{name} [{unit}]"),
                Axis(f"density [1/{unit}]"),
                height=260,
                half=True,
            )
        )
    return tuple(charts)


def normal_chart(residuals: Residuals, channels: Sequence[str]) -> Chart:
    """Quantiles of the residuals of each channel over those of a normal distribution of the same standard deviation."""
    values = np.sort(residuals.evaluated, axis=0)
    count = min(QUANTILES, len(values))
    share = (np.arange(count) + 0.5) / count
    rows = np.clip(np.round(share * len(values) - 0.5).astype(int), 0, len(values) - 1)
    normal = ndtri(share)
    series: list[Line | Points] = [
        Line(normal, values[rows, k], name, colour(k), 1.2) for k, name in enumerate(channels)
    ]
    usual = float(np.sqrt(np.mean(residuals.evaluated**2)))
    series.append(Line(normal, usual * normal, "normal, of their rms", "#8593a1", 1.0, "dot"))
    return Chart(
        "normal",
        "Residuals in order over the quantiles of a normal distribution: a straight line where noise is normal, ends "
        "that bend away where there are gross errors or a part of the run that differs.",
        tuple(series),
        Axis("normal quantile [standard deviations]"),
        Axis(f"residual [{unit_of(channels)}]"),
        height=300,
        half=True,
    )
