"""The stage Result: the verdict, and the parameters in words."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from cases.base.errors import HexciteError
from cases.base.phrases import said
from hexcite.page.actions.common import Context
from hexcite.page.actions.data import remedies_of
from hexcite.page.actions.result import REFERENCES
from hexcite.page.actions.stated import LIMITS
from hexcite.page.stages import Made, Workspace, case_of
from hexcite.page.views.common import Query, beginning, chosen, parameter, recording_in, remedies
from hexcite.page.words import Words
from identification.finding import ABOUT_THE_RUN
from identification.results.agreement import Difference, differences
from identification.results.pooling import UNLIKELY
from identification.results.result import Result
from identification.results.result_rows import pooled_rows, scatter_rows
from identification.results.verdicts import Check, Verdict, accept
from identification.texts import legible, std_text


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Result shows of a machine, for its template."""
    result: Made | None = chosen(there.results, query.get("result"))
    if result is None:
        return {"results": there.results, "chosen": None}
    job = context.jobs.writing(result.name)
    names = {recording.name for recording in there.recordings}
    return {
        "results": there.results,
        "chosen": result,
        **(about := outcome(context.words, result)),
        "remedies": remedies([each for finding in result.record.get("findings", ()) for each in remedies_of(finding)]),
        "written": job.notes if job is not None else (),
        "stated": query.get("stated") == "1",
        **_judged(context, result),
        "rods": _rods(context),
        "budget": _budget(context.words, result.record),
        "pooled": _pooled(result.record),
        "channels": _channels(context, result.record),
        "other": _beside(context, result, there.results, query.get("other")),
        "recordings": there.recordings,
        **_payload(context, result, [each.name for each in there.results]),
        "again": about["recording"] if about["recording"] in names else "",
    }


def _rods(context: Context) -> str:
    """Mass of the rods that struts' sensors carry as part of the body [kg]; empty where they carry none."""
    case = context.machine.case
    struts = None if case is None else case.sensor_frame.struts
    return "" if struts is None or not struts.carried_kg else f"{struts.carried_kg:.4g}"


@lru_cache(64)
def _verdict(folder: Path, fingerprint: str, file: Path, time_ns: int, size: int) -> Verdict | None:
    """The verdict on a result by a case file, computed once for each content that they have."""
    try:
        return accept(Result.load(folder, case_of(str(file), time_ns, size), stale=True))
    except HexciteError:
        return None  # there is nothing to judge, or the result is damaged: the command that uses it says so


def _judged(context: Context, result: Made) -> dict[str, Any]:
    """The limits of `[accept]` with what the result has, and the keys of the form that states them."""
    case = context.machine.case
    file = context.machine.file
    status = file.stat()
    key = (file, status.st_mtime_ns, status.st_size)
    verdict = None if case is None else _verdict(context.root / result.name, result.fingerprint, *key)
    limits = {} if case is None or case.accept is None else case.accept.model_dump(exclude_unset=True)
    return {
        "verdict": None
        if verdict is None
        else {
            "passed": verdict.passed,
            "unjudged": [context.words.clause(said(u).to_json(), u) for u in verdict.unjudged],
        },
        "checks": [] if verdict is None else [_check_row(context.words, check) for check in verdict.checks],
        "limits_stated": case is not None and case.accept is not None,
        "limits_form": [(key, _stated(limits, key)) for key in LIMITS],
    }


def failed_checks(context: Context, result: Made) -> list[str]:
    """What a result fails of `[accept]`, with values and limits; none where it passes, or nothing is judged."""
    judged = _judged(context, result)
    return [
        f"{name} {value}{'' if unit == '-' else f' {unit}'} ({limit})"
        for passed, name, value, limit, unit in judged["checks"]
        if not passed
    ]


def _check_row(words: Words, check: Check) -> tuple[bool | str, ...]:
    limit = words.say("at_least" if check.least else "at_most", limit=f"{check.limit:.3g}")
    judged = words.check(check.code, check.of, check.name)
    return (check.passed, judged, f"{check.value:.3g}", limit, check.unit or "-")


def _stated(values: Any, key: str) -> str:
    """The value of a dotted key as a form shows it."""
    for part in key.split("."):
        values = values.get(part) if isinstance(values, Mapping) else None
    return "" if values is None else f"{values:g}" if isinstance(values, float | int) else str(values)


def _budget(words: Words, record: Mapping[str, Any]) -> dict[str, Any] | None:
    """Of each parameter the parts of its variance by their causes; None where the case states no tolerances."""
    budget = record.get("budget") or {}
    if not budget:
        return None
    kinds = list(next(iter(budget.values())))
    rows = []
    for name, parts in budget.items():
        power = [float(parts[kind] or 0.0) ** 2 for kind in kinds]
        total = sum(power)
        if total <= 0.0:
            continue
        scale, unit = legible(str((record.get("parameters", {}).get(name) or {}).get("unit", "")))
        bars, begin = [], 0.0
        for k, share in enumerate(each / total for each in power):
            bars.append(
                (k % 8, f"{200 * begin:.1f}", f"{200 * share:.1f}", words.cause(kinds[k]), f"{100 * share:.0f}")
            )
            begin += share
        largest = max(range(len(kinds)), key=lambda k: power[k])
        rows.append(
            {
                "words": words.parameter(name),
                "bars": [bar for bar in bars if bar[4] != "0"],
                "largest": words.cause(kinds[largest]),
                "share": f"{100 * power[largest] / total:.0f}",
                "cells": [std_text(float(parts[kind]) * scale) if parts[kind] else "" for kind in kinds],
                "unit": unit,
            }
        )
    return {"kinds": [words.cause(kind) for kind in kinds], "rows": rows}


def _pooled(record: Mapping[str, Any]) -> dict[str, Any] | None:
    """The runs that a result is the mean of, each with its share of chi-square; None of a single run."""
    pooled = record.get("pooled")
    if not isinstance(pooled, Mapping):
        return None
    runs = [(Path(str(file)).parent.name, *cells) for file, *cells in pooled_rows(pooled)[1:]]
    agree, without = float(pooled["p"]) >= UNLIKELY, pooled["without"] or [{"p": 0.0}] * len(runs)
    odd = [not agree and float(of["p"]) >= UNLIKELY for of in without]  # the others agree without it
    shares = [100.0 * float(of["chi2_share"]) for of in pooled["results"]]
    return {
        "p": f"{float(pooled['p']):.2g}",
        "agree": agree,
        "chi2": f"{float(pooled['chi2']):.3g}",
        "freedom": pooled["degrees_of_freedom"],
        "runs": [(differs, f"{share:.0f}", *row) for differs, share, row in zip(odd, shares, runs, strict=True)],
        "scatter": scatter_rows(pooled)[1:],
    }


def _channels(context: Context, record: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Of each channel: rms residual, noise by the residuals, stated noise."""
    case, rms = context.machine.case, record.get("residual_rms")
    if case is None or not isinstance(rms, list):
        return []
    noise = record.get("channel_noise") or {}
    names = [case.recording.file_name(name) for name in case.sensor_frame.channels]
    columns = [rms, *(noise.get(key) or [None] * len(rms) for key in ("measured", "stated"))]
    if any(len(column) != len(names) for column in columns):
        return []
    return [
        (name, *("" if v is None else f"{float(v):.3g}" for v in cells))
        for name, *cells in zip(names, *columns, strict=True)
    ]


@lru_cache(64)
def _differences(
    before: Path, after: Path, fingerprints: tuple[str, str], file: Path, time_ns: int, size: int
) -> dict[str, Difference]:
    """Differences of two results, computed once for each content; none where one of them cannot be loaded."""
    del fingerprints
    case = case_of(str(file), time_ns, size)
    try:
        return differences(*(Result.load(folder, case, stale=True) for folder in (before, after)))
    except HexciteError:
        return {}


def _beside(context: Context, result: Made, results: Sequence[Made], name: str | None) -> dict[str, Any] | None:
    """Another result beside this one: values, difference, and that over its U, tolerances of both counted once."""
    other = next((each for each in results if each.name == name), None)
    if other is None or other.name == result.name:
        return None
    rows, file = [], context.machine.file
    status = file.stat()
    prints = (other.fingerprint, result.fingerprint)
    between = _differences(
        context.root / other.name, context.root / result.name, prints, file, status.st_mtime_ns, status.st_size
    )
    for name, value in result.record.get("parameters", {}).items():
        before = other.record.get("parameters", {}).get(name)
        if not before:
            continue
        words, now, _, _, unit = parameter(context.words, name, value)
        scale = legible(str(value.get("unit", "")))[0]
        off = float(value["value"]) - float(before["value"])
        en = between[name].en if name in between else None
        apart = "–" if en is None else f"{en:.2g}"
        rows.append((words, parameter(context.words, name, before)[1], now, f"{off * scale:+.3g}", unit, apart))
    return {"name": other.name, "rows": rows}


def _payload(context: Context, result: Made, results: Sequence[str]) -> dict[str, Any]:
    """What the latest payload of this result was, and which of the results was, or may be, the one without it."""
    from identification.options import FRAMES
    from postprocessors.export.targets import LOADS

    job = context.jobs.latest(context.machine.key, "payload", result.name)
    answer = job.answer if job is not None and job.arrived and job.answer is not None else {}
    reference, in_frame = answer.get("reference") or {}, answer.get("in_frame") or {}
    before = "" if job is None else job.command[1].removeprefix("./")
    others = [name for name in results if name != result.name]
    return {
        "payload_before": before if before in results else next(iter(others), ""),
        "payload": [parameter(context.words, name, value) for name, value in (answer.get("parameters") or {}).items()],
        "payload_checks": [
            (
                c["passed"],
                context.words.check("reference", c.get("of", ""), c["check"]),
                f"{c['value']:.3g}",
                f"{c.get('at_most', 1.0):.3g}",
            )
            for c in reference.get("checks", ())
        ],
        "payload_in": [parameter(context.words, name, value) for name, value in in_frame.get("parameters", {}).items()],
        "payload_frame": in_frame.get("frame", ""),
        "payload_report": Path(answer["report"]).name if "report" in answer else "",
        "payload_file": Path(answer["file"]).name if "file" in answer else "",
        "payload_text": beginning(context.root / answer["file"])[0] if "file" in answer else "",
        "payload_warnings": answer.get("warnings", ()),
        "loads": [(name, context.words.say(f"to_{name}")) for name in LOADS],
        "frames": FRAMES,
        "references": [(name, unit) for name, (unit, _, _) in REFERENCES.items()],
    }


def outcome(words: Words, result: Made) -> dict[str, Any]:
    """The verdict of a result, its findings and its parameters in words."""
    record = result.record
    findings = [f for f in record.get("findings", ()) if isinstance(f, Mapping) and f.get("sentence")]
    warnings = [f for f in findings if f.get("severity") == "warning"]
    doubts = [f for f in warnings if not f.get("counted") and f.get("kind") not in {str(k) for k in ABOUT_THE_RUN}]
    first = next(iter(doubts or warnings), None)
    unseen = next((f for f in findings if _entries(f)), None)
    run = record.get("run") or {}
    return {
        "light": "doubt" if doubts else "counted" if warnings else "good",
        "first": "" if first is None else _finding(words, first),
        "more": [_finding(words, f) for f in findings if f is not first and f is not unseen],
        "unseen": None if unseen is None else _unseen(words, _entries(unseen), record.get("parameters", {})),
        "simulated": bool(run.get("simulated")),
        "recording": recording_in(record),
        "parameters": [parameter(words, name, value) for name, value in record.get("parameters", {}).items()],
        "not_counted": ", ".join(words.cause(str(each)) for each in record.get("not_counted") or ()),
    }


MOST_UNSEEN = 5  # effects in the table of what a run does not show


def _entries(finding: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """What a run does not show, the worst first; empty of findings about other things."""
    quantity = finding.get("quantity")
    entries = quantity.get("not_shown") if isinstance(quantity, Mapping) else None
    return [each for each in entries if isinstance(each, Mapping)] if isinstance(entries, list) else []


def _unseen(words: Words, entries: Sequence[Mapping[str, Any]], parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Of the largest effects that a run does not show: cause, parameter, its bias, its U, both with the unit."""
    rows = []
    for entry in entries[:MOST_UNSEEN]:
        name = str(entry.get("parameter", ""))
        value = parameters.get(name) or {"value": 0.0}
        shown_name, _, _, reach, unit = parameter(words, name, value)
        bias = float(entry.get("bias", 0.0)) * legible(str(value.get("unit", "")))[0]
        cause = words.clause(entry.get("phrase"), str(entry.get("as_with", "")))
        rows.append((cause, shown_name, f"{bias:+.2g}", reach, unit))
    return {"rows": rows, "count": len(entries)}


def _finding(words: Words, finding: Mapping[str, Any]) -> Markup:
    return words.finding(finding)
