"""The page of a demo run: the whole chain, and the estimates beside the simulated machine's truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from cases.schema import Case
from identification.limit import Status
from identification.motion import Trajectory, sample
from identification.precision import legible, parameter_words, std_text, value_text
from identification.trajectories.executed import instants
from planner.demonstration import Demo
from planner.reports.figures import limits_chart, motion_blocks
from planner.reports.identify import delay_words, noise_tile, residual_blocks, run_inputs
from planner.reports.machine import pictured
from planner.reports.page import COLOURS, Block, Chart, note, page, section, table, tiles
from postprocessors.dialects import Program
from postprocessors.proving.homing import planned_excitation

DRAWN_RATE = 200.0  # [1/s]
RECORDED_RATE = 500.0  # [1/s] high enough to show the ripple of a controller's blocks


def demo_page(chain: Demo) -> str:
    """The page of a demo."""
    case, result, planned = chain.plan.case, chain.result, planned_excitation(chain.program)
    assert result.residuals is not None
    run, plan = chain.recording.record, chain.plan.to_json()
    settings = [f"{key} {value}" for key, value in plan["settings"].items() if not isinstance(value, list | dict)]
    source = case.need_simulation("the demo").source
    return page(
        case.title,
        f"Planned, programmed, proven, executed on {run['controller']} and identified with model "
        f"{result.record.model}. Sensors and encoders are simulated, with the imperfections that the case states "
        f"({source}).",
        (
            ("case", f"{case.name} (hash {case.hash})"),
            ("plan", f"{plan['family']}, criterion {plan['criterion']}, {', '.join(settings)}"),
            *run_inputs(run),
            *result.record.versions.items(),
        ),
        result.warnings,
        section("What came out", _headline(chain), *_truth(chain)),
        *pictured(case, planned),
        section("The planned motion and its limits", *motion_blocks(case, sample(planned, DRAWN_RATE))),
        section("Proof of the program's text", *_proof(chain.program)),
        section("What the controller made of it", _executed(case, chain, planned)),
        section("Forces and residuals", *residual_blocks(case, result.residuals)),
    )


def _headline(chain: Demo) -> Markup:
    run, parameters, (_, worth) = chain.recording.record, chain.result.parameters, chain.plan.of_motion
    m, z = parameters["m"].std_robust, parameters["zC"].std_robust
    return tiles(
        (f"{run['executed_s']:.2f} s", f"excitation as executed ({run['planned_s']:.2f} s planned)"),
        (
            f"{run['d_efficiency']:.2f}",
            f"D-efficiency as executed, behind the evaluation's filter ({worth.d_efficiency:.2f} planned, "
            f"{run['d_efficiency_planned']:.2f} as programmed)",
        ),
        (f"{m * 1e3:.3g} g", "robust standard deviation of the mass"),
        (f"{z * 1e6:.3g} µm", "robust standard deviation of the centre of gravity, z"),
        (f"{chain.worst:.2f}", "largest error in reported standard deviations"),
        noise_tile(chain.result),
    )


def _truth(chain: Demo) -> tuple[Block, ...]:
    rows = list(chain.truth)
    inside = sum(abs(row["error"]) <= 1.96 * row["std"] for row in rows)
    words = f"{inside} of {len(rows)} truths lie in the 95 % interval of their estimate."
    if (delay := delay_words(chain.result)) is not None:
        words += f" {delay}"
    return (errors_chart(rows), note(words), table(TRUTH_COLUMNS, map(truth_cells, rows)))


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
    figure = Chart("errors", caption, y="(estimate - truth) / std", height=380)
    for half, opacity in ((4.0, 0.10), (1.96, 0.16)):
        figure.add_band(half, COLOURS[0], opacity)
    bars = {"type": "constant", "value": 1.0, "thickness": 1.2, "width": 5}
    figure.add(
        "scatter",
        x=names,
        y=errors,
        mode="markers",
        marker={"color": COLOURS[0], "size": 9},
        error_y=bars,
        showlegend=False,
    )
    reach = max(5.0, 1.15 * max(abs(e) for e in errors))
    figure.axes({"tickangle": -45}, {"range": [-reach, reach]})
    return figure


def _proof(program: Program) -> tuple[Block, ...]:
    limits = program.proof.limits
    words = (
        f"{program.reading.blocks} blocks, {program.proof.duration:.2f} s, read back by code that shares nothing with "
        "the writer; paths checked at 10 kHz."
    )
    remarks = "; ".join(f"{c.of}: {c.status}" for c in limits.checks if c.status is not Status.PROVEN)
    unproven = f"What the program does not determine and its text cannot prove: {remarks}."
    return (note(words), limits_chart(limits), *([note(unproven)] if remarks else []))


def _executed(case: Case, chain: Demo, excitation: Trajectory) -> Chart:
    """Accelerations that the controller really made, along x, y, z or of each joint, beside the planned ones."""
    t = instants(chain.run.trigger, RECORDED_RATE)
    execution, limits = chain.run.execution, case.need_motion("the page of a demo")[1]
    inside = np.clip(t, 0.0, execution.duration)
    of_pose = execution.machine.of_pose
    executed = execution.kinematics(inside).twist_rate[:, :3] if of_pose else execution.struts(inside, 2)
    planned = sample(excitation, DRAWN_RATE)
    unit = "acceleration [m/s²]" if of_pose else "acceleration [rad/s² or m/s²]"
    caption = (
        f"Dotted: as planned. Strayed {chain.recording.record['path_error_mm']:.3f} mm at most from the planned path."
    )
    figure = Chart("executed", caption, "time since the trigger [s]", unit, height=380)
    labels = limits.labels[: executed.shape[1]]
    figure.add_lines(t - t[0], executed, labels, 1)
    figure.add_lines(planned.t, planned.accelerations[:, : len(labels)], labels, 2, "dot")
    return figure
