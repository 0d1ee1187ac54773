"""Rows of the tables of a result for people: the nearest body, another treatment, a pool, a tare."""

from collections.abc import Mapping
from typing import Any

from identification.estimation.fit import Value
from identification.estimation.nearest_body import NearestBody
from identification.model.parameters import INERTIA_INDEX
from identification.texts import legible, parameter_words, std_text, value_text

_OF_BODY = frozenset(("m", "xC", "yC", "zC", *(f"IC{i + 1}{j + 1}" for i, j in INERTIA_INDEX)))


def physical_rows(parameters: Mapping[str, Value], nearest: NearestBody | None) -> list[tuple[str, ...]]:
    """Rows of a table, the head first: the nearest body that can exist beside the estimate; none where they are one."""
    if nearest is None:
        return []
    rows: list[tuple[str, ...]] = [("nearest body that can exist", "estimate", "nearest", "by deviations", "unit")]
    for name, estimated in parameters.items():
        if name not in _OF_BODY or not estimated.reported > 0.0:
            continue
        scale, unit = legible(estimated.unit)
        value = nearest.parameters[name]
        texts = (value_text(v * scale, estimated.reported * scale) for v in (estimated.value, value))
        rows.append((parameter_words(name), *texts, f"{(value - estimated.value) / estimated.reported:+.2g}", unit))
    return rows


def treatment_rows(treatment: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Rows of a table, the head first: what a treatment of the data changes beside the default."""
    rows: list[tuple[str, ...]] = [("beside the default", "default", "+-", "treated", "+-", "by deviations")]
    for name, of in treatment["parameters"].items():
        usual, treated = (Value(**of[key]) for key in ("default", "treated"))
        scale, unit = legible(usual.unit)
        cells = (
            text
            for value in (usual, treated)
            for text in (value_text(value.value * scale, value.reported * scale), std_text(value.reported * scale))
        )
        rows.append((f"{parameter_words(name)} [{unit}]", *cells, f"{of['deviations']:+.2g}"))
    for key, words in (("s0", "s0 (27)"), ("white_noise", "white noise"), ("samples", "samples")):
        rows.append((words, f"{treatment[key]['default']:.4g}", "", f"{treatment[key]['treated']:.4g}", "", ""))
    return rows


def pooled_rows(pooled: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Rows of a table, the head first: runs that a result is the mean of, and how the others agree without each."""
    rows: list[tuple[str, ...]] = [("run", "share of chi-square", "without it: scatter / promised", "p")]
    others = pooled["without"] or [None] * len(pooled["results"])
    for of, other in zip(pooled["results"], others, strict=True):
        cells = ("-", "-") if other is None else (f"{other['scatter']:.2f}", f"{other['p']:.2g}")
        rows.append((of["result"], f"{100.0 * of['chi2_share']:.0f} %", *cells))
    return rows


def scatter_rows(pooled: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Rows of a table, the head first: of each parameter, how far the runs scatter."""
    head = ("scatter of the runs", "scatter / promised", "p")
    return [
        head,
        *((parameter_words(n), f"{of['scatter']:.2f}", f"{of['p']:.2g}") for n, of in pooled["parameters"].items()),
    ]


def tared_rows(tared: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Rows of a table, the head first: the offsets before and after a tare."""
    rows: list[tuple[str, ...]] = [("offset", "before", "after", "change", "+-", "unit")]
    for name, of in tared.items():
        before, after, deviation = of["before"], of["after"], of["change_std"]
        texts = (value_text(value, deviation) for value in (before, after, after - before))
        rows.append((name, *texts, std_text(deviation), of["unit"]))
    return rows
