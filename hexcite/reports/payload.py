"""The page of a payload: what was added from one result to another, beside both of them."""

from collections.abc import Mapping

from cases.base.phrases import phrase, said
from hexcite.reports.page import Block, Head, note, page, section, table, tiles
from identification.estimation.fit import Value
from identification.results.frames import Body
from identification.results.payload import Payload
from identification.results.result import Result
from identification.results.verdicts import Verdict
from identification.texts import (
    PARAMETER_COLUMNS,
    as_sentences,
    legible,
    std_text,
    value_cells,
    value_text,
    with_deviation,
)


def payload_page(payload: Payload, body: Body | None = None, verdict: Verdict | None = None) -> str:
    """The page of a payload.

    Args:
        payload: what was added.
        body: the same in a frame that was asked for.
        verdict: E_n beside reference values; None: there are none.
    """
    doubts, failed = payload.doubts, verdict is not None and not verdict.passed
    first = list(doubts[:1])
    if verdict is not None:
        first = [phrase("beside_reference", "{verdict}: E_n beside the reference", verdict=said(verdict.word)), *first]
    elif not doubts:
        first = [phrase("sound_runs", "Nothing speaks against both runs")]
    sections = [section("What was added", tiles(*_largest(payload)), _parameters(payload.parameters))]
    if body is not None:
        counted = "Counted from the origin and along the axes of the frame: {frame}."
        about = note(phrase("counted_in_frame", counted, frame=body.place.name))
        sections.append(section("In the frame that was asked for", about, _parameters(body.parameters)))
    if verdict is not None:
        columns, *rows = verdict.rows()
        words = (
            "E_n is the difference from the reference over the root of both squared U (k = 2); above 1 they disagree."
        )
        title = phrase("beside_reference_is", "Beside the reference: {verdict}", verdict=said(verdict.word))
        sections.append(section(title, table(columns, rows, left=2), note(words)))
    sections.append(section("The two results", _results(payload)))
    inputs = [
        (f"result {name} the payload", f"{of.source}, SHA-256 {of.fingerprint}")
        for name, of in (("without", payload.empty), ("with", payload.loaded))
    ]
    inputs += [(entry["file"], f"SHA-256 {entry['sha256']}") for of in _both(payload) for entry in of.record.inputs]
    return page(
        "Payload",
        Head(
            as_sentences(*first),
            not doubts and not failed,
            payload.loaded.case.name,
            (("result with it", payload.source),),
        ),
        phrase(
            "carries_more",
            "What {loaded} carries more than {empty}: differences of both estimates, with the deviations of both.",
            loaded=payload.source,
            empty=payload.empty.source,
        ),
        [("case", payload.loaded.case.name), *inputs, *payload.loaded.record.versions.items()],
        doubts[1:],
        *sections,
    )


def _both(payload: Payload) -> tuple[Result, Result]:
    return payload.empty, payload.loaded


def _largest(payload: Payload) -> list[tuple[str, str]]:
    """Mass and centre of gravity with their deviations, as tiles."""
    words = {"m": "mass", "xC": "centre of gravity, x", "yC": "centre of gravity, y", "zC": "centre of gravity, z"}
    rows = []
    for name, text in words.items():
        if (value := payload.parameters.get(name)) is not None:
            scale, unit = legible(value.unit)
            rows.append((f"{with_deviation(value.value * scale, value.reported * scale)} {unit}", text))
    return rows


def _parameters(parameters: Mapping[str, Value]) -> Block:
    rows = [value_cells(name, value) for name, value in parameters.items()]
    return table([column.replace("+-", "±") for column in PARAMETER_COLUMNS], rows)


def _results(payload: Payload) -> Block:
    """Parameters of the body and the offsets, without the payload and with it."""
    empty, loaded = (of.parameters for of in _both(payload))
    rows = []
    for name, after in loaded.items():
        if (before := empty.get(name)) is None:
            continue
        scale, unit = legible(after.unit)
        cells = [
            text
            for value in (before, after)
            for text in (
                value_text(value.value * scale, value.reported * scale)
                if value.reported
                else f"{value.value * scale:.6g}",
                std_text(value.reported * scale) if value.reported else "given",
            )
        ]
        rows.append((value_cells(name, after)[0], *cells, unit))
    return table(("parameter", "without", "±", "with", "±", "unit"), rows)
