"""The page of a demo run: the estimates beside the simulated machine's truth, and what its steps came to."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hexcite._demo import Demo
from hexcite.reports.drawing.chart import COLOURS, Axis, Band, Chart, Points
from hexcite.reports.drawing.figures import limits_table
from hexcite.reports.drawing.scene import moving_machine
from hexcite.reports.identify import noise_tile, residual_blocks, run_inputs
from hexcite.reports.page import Head, note, page, section, table, tiles
from identification.limits.limit import Status
from identification.texts import legible, parameter_words, std_text, value_text
from planner.options import FAMILY_WORDS
from postprocessors.proof.homing import planned_excitation


def demo_page(chain: Demo) -> str:
    """The page of a demo; plan and result have pages of their own beside it."""
    case, result, run, limits = chain.plan.case, chain.result, chain.recording.executed, chain.program.proof.limits
    assert result.residuals is not None
    assert chain.recording.record is not None
    origin = chain.recording.record.origin
    source = case.need_simulation("the demo").source
    inside = sum(abs(row["error"]) <= 1.96 * row["std"] for row in chain.truth)
    execution = f"excitation as executed ({run.planned_s:.2f} s planned, {run.path_error_mm:.3f} mm from its path)"
    efficiency = (
        f"D-efficiency as executed, behind the evaluation's filter ({chain.plan.of_motion[1].d_efficiency:.2f} "
        f"planned, {run.d_efficiency_planned:.2f} as programmed)"
    )
    unproven = "; ".join(f"{c.of}: {c.status}" for c in limits.checks if c.status is not Status.PROVEN)
    proof = (
        f"{chain.program.reading.blocks} blocks, {chain.program.proof.duration:.2f} s, read back by code that shares "
        "nothing with the writer; paths checked at 10 kHz."
    )
    agree = chain.worst < AGREES and not result.warnings
    verdict = (
        f"The largest error of a parameter is {chain.worst:.2g} reported standard deviations: the calibration "
        f"{'agrees' if agree else 'does NOT agree'} with the simulated machine."
    )
    facts = (("program", str(chain.program.path)), ("run on", run.controller))
    return page(
        case.heading,
        Head(verdict, agree, case.name, facts),
        f"Planned, programmed, proven, executed on {run.controller} and identified with model "
        f"{result.record.model}. Sensors and encoders are simulated, with the imperfections that the case states "
        f"({source}). More about the motion is in plan/report.html, about the estimate in result/report.html.",
        (("case", f"{case.name} (hash {case.hash})"), *run_inputs(origin), *result.record.versions.items()),
        result.warnings,
        section(
            "What came out",
            tiles(
                (f"{run.executed_s:.2f} s", execution),
                (f"{run.d_efficiency:.2f}", efficiency),
                (f"{chain.worst:.2f}", "largest error in reported standard deviations"),
                noise_tile(result),
            ),
            errors_chart(chain.truth),
            note(f"{inside} of {len(chain.truth)} truths lie in the 95 % interval of their estimate."),
            table(TRUTH_COLUMNS, map(truth_cells, chain.truth)),
        ),
        section(
            "Motions compared",
            table(MOTION_COLUMNS, motion_rows(chain)),
            *map(
                note, (*chain.comparison.sentences, *(f"Left out: {words}" for words in chain.left_out), *chain.faster)
            ),
            note(
                "Each was planned, programmed, proven, run and identified the same way. Deviations: the geometric mean "
                "of the reported standard deviations over those of the best."
            ),
        ),
        section(
            "The machine along the plan",
            moving_machine(case, planned_excitation(chain.program.reading, chain.program.guarantees)),
        ),
        section(
            "Proof of the program's text",
            note(proof),
            limits_table(limits),
            *([note(f"What its text cannot prove: {unproven}.")] if unproven else []),
        ),
        section("Forces and residuals", *residual_blocks(case, result.residuals)),
    )


MOTION_COLUMNS = (
    "motion", "s planned", "s run", "D-efficiency planned", "as executed", "s0", "largest error in std", "deviations",
)  # fmt: skip


def motion_rows(chain: Demo) -> list[tuple[str, ...]]:
    """Rows of `MOTION_COLUMNS`, one a motion, the moves last."""
    ratios = list(chain.comparison.ratios.values())
    rows: list[tuple[str, ...]] = []
    for number, each in enumerate(chain.all):
        run = each.recording.executed
        ratio = f"{ratios[number]:.2f} times" if len(ratios) == len(chain.all) else "-"
        rows.append(
            (
                FAMILY_WORDS[each.plan.family],
                f"{run.planned_s:.2f}",
                f"{run.executed_s:.2f}",
                f"{each.plan.of_motion[1].d_efficiency:.3f}",
                f"{run.d_efficiency:.3f}",
                f"{each.result.record.s0:.3g}",
                f"{each.worst:.2f}",
                ratio,
            )
        )
    return rows


AGREES = 4.0  # reported standard deviations: none of twenty errors is beyond it by chance
TRUTH_COLUMNS = ("parameter", "truth", "estimate", "std", "error", "error / std", "unit")


def truth_cells(row: dict[str, Any]) -> tuple[str, ...]:
    """The cells of `TRUTH_COLUMNS` of one row of `truth_rows`."""
    scale, unit = legible(row["unit"])
    std = row["std"] * scale
    estimate, error = (value_text(row[key] * scale, std) for key in ("estimate", "error"))
    truth, ratio = f"{row['truth'] * scale:.6g}", f"{row['error'] / row['std']:+.2f}"
    return parameter_words(row["name"]), truth, estimate, std_text(std), error, ratio, unit


def errors_chart(rows: Sequence[dict[str, Any]]) -> Chart:
    """Estimate less truth in standard deviations, with the 95 % and the 4 sigma band."""
    names = [r["name"] for r in rows]
    errors = [r["error"] / r["std"] for r in rows]
    caption = (
        "Points: estimate less truth in reported standard deviations, one standard deviation as the bar; bands: 95 % "
        "and 4 standard deviations."
    )
    reach = max(5.0, 1.15 * max(abs(e) for e in errors))
    return Chart(
        "errors",
        caption,
        (Points(np.arange(float(len(names))), np.array(errors), "", COLOURS[0], bar=1.0, in_legend=False),),
        Axis(names=tuple(names), tilt=45.0),
        Axis("(estimate - truth) / std", ends=(-reach, reach)),
        bands=(Band(4.0, COLOURS[0], 0.10), Band(1.96, COLOURS[0], 0.16)),
        height=380,
    )
