"""The plan of the motion from a search: its figures, and notes for the user."""

from typing import NamedTuple

from cases.schema import Case
from identification.limit import LimitReport, Status
from identification.model import identification_model
from identification.motion import Trajectory
from planner.bounds.information_limit import information_limit
from planner.families import Settings
from planner.plan_figures import Worth, figures_of
from planner.plans import Plan
from planner.request import Request
from planner.search import Failed
from planner.search.solving import DRAWN_BACK, Start

FULL = 0.9  # share of a limit that a good motion uses of at least one


class PlannedMotion(NamedTuple):
    """The motion from a search, and the record of the search."""

    motion: Trajectory  # the best one, proven
    settings: Settings  # settings of its family
    limits: LimitReport
    starts: tuple[Start, ...] = ()  # the best one first
    failed: tuple[Failed, ...] = ()  # starts without a feasible motion
    interrupted: bool = False  # whether Ctrl-C ended the search early


def rated_plan(request: Request, case: Case, planned: PlannedMotion, seconds: float) -> Plan:
    """The plan of a feasible motion, with its figures.

    Args:
        seconds: time spent on the search [s].

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
    """
    model, motion = identification_model(case, request.model), planned.motion
    figures, noise, predicted = figures_of(case, model, motion, request.payloads, request.criterion)
    worth = Worth(
        starts=tuple(start.record for start in planned.starts),
        failed_starts=planned.failed,
        criterion_value=figures["criterion_value"],
        logdet=figures["logdet"],
        condition=figures["condition"],
        bound=information_limit(case, model),
        assumed_noise_of_channels=tuple(noise.std.tolist()),
        noise_of_accelerations=noise.shaken,
        weights=noise.weights,
        weaknesses=weaknesses(planned, case),
        notes=notes(planned),
    )
    return Plan(
        case, request, motion, planned.limits, predicted, noise.sensors, case.recording.rate_Hz, worth,
        planned.settings, seconds, planned.interrupted,
    )  # fmt: skip


def weaknesses(planned: PlannedMotion, case: Case) -> tuple[str, ...]:
    """Reasons why another plan would carry more information, each with a remedy; the first thing that a user reads."""
    words = []
    refined = [s.record for s in planned.starts if s.record.refined]
    if refined and not planned.interrupted and not refined[0].converged:
        words.append(
            f"the search had not converged where it ended ({refined[0].solver.words}): more --starts may find more"
        )
    if planned.starts and (share := planned.starts[0].shrunk) < DRAWN_BACK:
        words.append(
            f"the motion had to be drawn to {100 * share:.0f} % of its ways to satisfy every limit: plan with "
            "another --seed, or in a smaller box"
        )
    checks = [c for c in planned.limits.checks if c.binding and c.kind.kinetic]
    if planned.starts and checks and (most := max(checks, key=lambda c: c.ratio)).ratio < FULL:
        words.append(
            f"no limit of speed or force is used beyond {100 * most.ratio:.0f} % ({most.name}): another --seed, "
            "more --starts or a smaller box may find more"
        )
    return tuple(words)


def notes(planned: PlannedMotion) -> tuple[str, ...]:
    """Notes that a user acts on before the plan is run."""
    settings, words = planned.settings, []
    if steps := [c for c in planned.limits.checks if c.status is Status.STEPS]:
        limits = ", ".join(f"{abs(c.limit):.4g} {c.unit}" for c in steps)
        words.append(
            f"made for {settings.get('made_for')}, which does not limit jerk: accelerations step, and the limits of "
            f"jerk of the case ({limits}) do not count"
        )
    tried = {(s["order"], s["period_s"]) for s in (start.family.settings for start in planned.starts) if "order" in s}
    if len(tried) > 1:
        chosen = f"order {settings['order']} with period {settings['period_s']:g} s"
        words.append(f"{chosen} is the best of {len(tried)} choices of order and period")
    return tuple(words)
