"""The plan of the motion from a search: its figures, and notes for the user."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cases.base.phrases import NOTHING, Phrase, enumerated, phrase
from cases.schema import Case
from identification.estimation.criteria import Criterion, box_middle, reference_scaling
from identification.limits.limit import NAMED, LimitKind, LimitReport, Status
from identification.model.model import Model, identification_model
from identification.motion.curves import FourierMotion
from identification.motion.motion import Joined, Trajectory
from identification.motion.moves import StraightMove, fastest_profile, limits_along
from planner.bounds.bound import information_limit
from planner.families.fourier import of_lower_order
from planner.families.plan_settings import FourierSettings, MoveSettings, PlanSettings
from planner.families.ptp import PointToPointFamily
from planner.families.settings import Fourier, PointToPoint
from planner.noise import mean_information
from planner.options import family_phrase
from planner.plans.figures import Worth, figures_of, prediction_of, predictions_of
from planner.plans.plan import Plan
from planner.plans.prediction import Gain, Promise
from planner.request import Request
from planner.search.feasibility import keep_limits
from planner.search.problem import CHECK_RATE
from planner.search.record import Failed
from planner.search.solving import DRAWN_BACK, Start

_OTHERWISE = {  # by family
    "ptp": phrase("less_moves", "fewer moves"),
    "fourier": phrase("free_period", "a free period"),
    "spline": phrase("moves_instead", "moves from point to point"),
}
FULL = 0.9  # share of a limit that a good motion uses of at least one
ORDER_1 = phrase(
    "order_1",
    "order 1 moves on ellipses: accelerations are -w^2 times the way from the middle, all at one frequency; only the "
    "ways in and out, and gravity as it turns, tell inertia from offsets and from errors that depend on the pose; "
    "plan order 3 too and compare the predicted deviations",
)
SPARE = 0.05  # share of the duration that a free period may leave before it is said
NEEDLESS = 0.01  # share of the information that harmonics may carry and yet be called needless


class PlannedMotion(NamedTuple):
    """The motion from a search, and the record of the search."""

    motion: Trajectory  # the best one, proven
    settings: PlanSettings
    limits: LimitReport
    starts: tuple[Start, ...] = ()  # the best one first
    failed: tuple[Failed, ...] = ()  # starts without a feasible motion
    interrupted: bool = False  # whether Ctrl-C ended the search early
    out_of_time: bool = False  # whether it ended because it had lasted as long as was asked for


def rated_plan(request: Request, case: Case, planned: PlannedMotion, seconds: float) -> Plan:
    """The plan of a feasible motion, with its figures.

    Args:
        seconds: time spent on the search [s].

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
    """
    model, motion = identification_model(case, request.model), planned.motion
    figures, noise = figures_of(case, model, motion, request.payload, request.criterion)
    scaling = reference_scaling(case, model)
    promise, gain = Promise.of(predictions_of(case, model, scaling, motion, request.payloads)), None
    if request.known is not None:
        values = request.known.values
        gain = Gain.of(prediction_of(case, model, scaling, motion, noise, request.payload, values), request.known)
    bound, smooth = information_limit(case, model).raised(figures["logdet"]), None
    if planned.settings.without == LimitKind.JERK and isinstance(motion, Joined):
        within = with_jerk_limited(motion, case)
        smooth = (
            within.duration,
            bound.efficiency(figures_of(case, model, within, request.payload, request.criterion)[0]["logdet"]),
        )
    efficiencies = tried_families(planned, bound.efficiency(figures["logdet"]), len(model.names))
    worth = Worth(
        starts=tuple(start.record for start in planned.starts),
        failed_starts=planned.failed,
        criterion_value=figures["criterion_value"],
        logdet=figures["logdet"],
        condition=figures["condition"],
        bound=bound,
        assumed_noise_of_channels=tuple(noise.std.tolist()),
        noise_of_accelerations=noise.shaken,
        weights=noise.weights,
        weaknesses=weaknesses(planned, request),
        notes=(
            *choice_notes(efficiencies),
            *notes(planned, smooth),
            *fourier_notes(case, model, request, motion, figures["logdet"]),
            *search_notes(planned, request, len(model.names)),
        ),
        tried=efficiencies,
    )
    return Plan(
        case, request, motion, planned.limits, promise, noise.sensors, case.recording.rate_Hz, worth,
        planned.settings, seconds, planned.interrupted, gain=gain,
    )  # fmt: skip


def weaknesses(planned: PlannedMotion, request: Request) -> tuple[Phrase, ...]:
    """Reasons why another plan would carry more information, each with a remedy; the first thing that a user reads."""
    words = list[Phrase]()
    refined = [s.record for s in planned.starts if s.record.refined]
    ended_early = planned.interrupted or planned.out_of_time
    unfinished = bool(refined) and not ended_early and not refined[0].converged
    if unfinished and request.starts is not None:  # a search that ends by itself has tried further starts
        which = (
            phrase("only_start", "the only start")
            if request.starts == 1
            else phrase("best_start", "the best of {count} starts", count=request.starts)
        )
        words.append(
            phrase(
                "not_converged",
                "{which} had not converged ({why}): where no number of starts is asked for, the search goes on until "
                "further starts gain little",
                which=which,
                why=refined[0].solver.words,
            )
        )
    if planned.starts and (share := planned.starts[0].shrunk) < DRAWN_BACK:
        words.append(
            phrase(
                "drawn_back",
                "the motion that was found exceeded a limit, and was scaled to {share} % of its displacements, which "
                "costs information: plan with another seed, or in a smaller box",
                share=f"{100 * share:.0f}",
            )
        )
    checks = [c for c in planned.limits.checks if c.binding and c.kind.kinetic]
    if planned.starts and checks and (most := max(checks, key=lambda c: c.ratio)).ratio < FULL:
        words.append(
            phrase(
                "short_ways",
                "no limit of speed or force is used beyond {share} % ({limit}): the ways are short for these speeds; "
                "widen [limits.motion], or try {other}",
                share=f"{100 * most.ratio:.0f}",
                limit=phrase(NAMED, most.name, name=most.name),
                other=_OTHERWISE[request.name],
            )
        )
    return tuple(words)


def search_notes(planned: PlannedMotion, request: Request, parameters: int) -> tuple[Phrase, ...]:
    """How close the best starts are where a search for criterion D ended by itself; none of one that was told when.

    Args:
        parameters: their number u.
    """
    if planned.out_of_time:
        ended = phrase(
            "ended_as_asked",
            "ended after {seconds} s, as asked: the best of {count} motions until then",
            seconds=f"{request.seconds:g}",
            count=len(planned.starts),
        )
        return (ended,)
    values = [s.record.criterion_value for s in planned.starts if s.record.refined]
    if request.criterion != Criterion.D or request.starts is not None or planned.interrupted or len(values) < 2:
        return ()
    loss = -math.expm1(min(values[1] - values[0], 0.0) / parameters)
    best = phrase(
        "best_of_starts",
        "the best of {count} starts, the next one has {loss} % less information: more starts gain little",
        count=len({s.record.seed for s in planned.starts}),  # a refinement has the seed of its exploration
        loss=f"{100 * loss:.1f}",
    )
    return (best,)


def tried_families(planned: PlannedMotion, d_efficiency: float, parameters: int) -> dict[str, float]:
    """D-efficiency of the best motion of each family that was searched, the best first; empty where there was one.

    Those behind the best were searched only until others led: what their first starts reached.

    Args:
        d_efficiency: that of the plan, the best.
        parameters: their number u.
    """
    best: dict[str, float] = {}
    for start in planned.starts:  # the best first
        best.setdefault(start.family.name, start.record.logdet)
    if len(best) < 2:
        return {}
    first = planned.starts[0].record.logdet
    return {name: d_efficiency * math.exp((logdet - first) / parameters) for name, logdet in best.items()}


def choice_notes(tried: Mapping[str, float]) -> tuple[Phrase, ...]:
    """Which family was chosen, and why."""
    if not tried:
        return ()
    (name, most), *others = tried.items()
    behind = [
        phrase("family_has", "{family} {efficiency}", family=family_phrase(other), efficiency=f"{efficiency:.3f}")
        for other, efficiency in others
    ]
    path = phrase("timed_moves", "; for a controller that times moves itself, choose moves from point to point")
    chosen = phrase(
        "by_trying",
        "{family} by trying: D-efficiency {most}, and the first starts of others: {behind}{path}",
        family=family_phrase(name),
        most=f"{most:.3f}",
        behind=enumerated("comma", behind),
        path=NOTHING if name == PointToPoint.name else path,
    )
    return (chosen,)


def fourier_notes(case: Case, model: Model, request: Request, motion: Trajectory, logdet: float) -> tuple[Phrase, ...]:
    """Notes on the order of a Fourier series, and on the time that a free period leaves; none of other motions."""
    if not isinstance(motion, FourierMotion) or not isinstance(request.family, Fourier):
        return ()
    words = list[Phrase]()
    if motion.order == 1:
        words.append(ORDER_1)
    order, loss = needless_harmonics(case, model, motion, logdet)
    if order < motion.order:
        words.append(
            phrase(
                "needless_harmonics",
                "harmonics above {order} are needless: without them the motion keeps {share} % of its information; "
                "order {order} searches fewer unknowns",
                order=order,
                share=f"{100 * (1 - loss):.1f}",
            )
        )
    spare, one_more = request.duration - motion.duration, motion.duration + motion.period
    if request.family.free_period and spare > SPARE * request.duration:
        words.append(
            phrase(
                "whole_periods",
                "whole periods of {period} s take {taken} s of the {duration} s; {more} s would have time for one more",
                period=f"{motion.period:.4g}",
                taken=f"{motion.duration:.4g}",
                duration=f"{request.duration:g}",
                more=f"{math.ceil(100 * one_more) / 100:g}",
            )
        )
    return tuple(words)


def needless_harmonics(case: Case, model: Model, motion: FourierMotion, logdet: float) -> tuple[int, float]:
    """The lowest order that carries as much information as a series, but for 1 %, and the share that it loses.

    The highest harmonics are removed, what remains is brought to rest again and shrunk inside every limit.
    """
    scaling, box = reference_scaling(case, model), box_middle(case)
    order, loss = motion.order, 0.0
    for lower in range(motion.order - 1, 1, -1):
        family, unknowns = of_lower_order(motion, lower, *box)
        inside = keep_limits(case, family, unknowns, CHECK_RATE)[0]
        mu = np.linalg.eigvalsh(mean_information(model, scaling, family.motion(inside)))
        removed_share = -math.expm1((np.log(np.maximum(mu, 1e-300)).sum() - logdet) / len(mu))
        if removed_share > NEEDLESS:
            break
        order, loss = lower, removed_share
    return order, loss


def with_jerk_limited(motion: Joined, case: Case) -> Joined:
    """The same moves as fast as the limits of all coordinates allow, jerk among them."""
    limits = case.need_motion("a plan")[1]
    moves: list[Trajectory] = []
    for move in motion.parts:
        if isinstance(move, StraightMove):
            along = limits_along(np.abs(move.end - move.start), limits.rate, limits.acceleration, limits.jerk)
            moves.append(StraightMove(move.start, move.end, fastest_profile(1.0, *along)))
        else:
            moves.append(move)
    return Joined(tuple(moves))


def notes(planned: PlannedMotion, smooth: tuple[float, float] | None = None) -> tuple[Phrase, ...]:
    """Notes that a user acts on before the plan is run.

    Args:
        smooth: duration [s] and D-efficiency of the same moves with limited jerk, where the plan leaves it out.
    """
    settings, words = planned.settings, list[Phrase]()
    if steps := [c for c in planned.limits.checks if c.status is Status.LEFT_OUT]:
        limits = ", ".join(f"{abs(c.limit):.4g} {c.unit}" for c in steps)
        words.append(
            phrase(
                "jerk_left_out",
                "made for {controller}, which does not limit jerk: accelerations step, and the limits of jerk of the "
                "case ({limits}) are left out, as asked for",
                controller=settings.made_for,
                limits=limits,
            )
        )
        if smooth is not None:
            words.append(
                phrase(
                    "with_jerk",
                    "with limited jerk the same moves take {seconds} s, at a D-efficiency of {efficiency}",
                    seconds=f"{smooth[0]:.3g}",
                    efficiency=f"{smooth[1]:.3f}",
                )
            )
    families = (start.family for start in planned.starts)
    counts = {family.moves for family in families if isinstance(family, PointToPointFamily)}
    if len(counts) > 1 and isinstance(settings, MoveSettings):
        tried = ", ".join(map(str, sorted(counts)))
        words.append(
            phrase(
                "best_moves",
                "{moves} moves tell most of the numbers of moves that were tried: {tried}",
                moves=settings.moves,
                tried=tried,
            )
        )
    first = (start.family.settings for start in planned.starts)
    choices = {(own.order, own.period_s) for own in first if isinstance(own, FourierSettings)}
    if len(choices) > 1 and isinstance(settings, FourierSettings):
        words.append(
            phrase(
                "best_order",
                "order {order} with period {period} s is the best of searches that began at {count} pairs of order and "
                "period",
                order=settings.order,
                period=f"{settings.period_s:.4g}",
                count=len(choices),
            )
        )
    return tuple(words)
