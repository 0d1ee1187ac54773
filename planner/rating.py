"""The plan of the motion from a search: its figures, and notes for the user."""

from typing import NamedTuple

import numpy as np

from cases.schema import Case
from cases.sensors import payload_words
from identification.criteria import reference_scaling
from identification.limit import LimitKind, LimitReport, Status
from identification.model import Model, identification_model
from identification.motion import Array, Trajectory
from identification.trajectories.curves import FourierMotion, needless_harmonics
from planner.bounds.information_limit import information_limit
from planner.families import Settings
from planner.families.spline import enough_intervals
from planner.noise import ExpectedNoise, expected_noise, without_pose_errors
from planner.plan_figures import BINDING, Rival, Worth, bound_by, figures_of, predicted_std_of, worst_std
from planner.plans import Plan
from planner.request import Request
from planner.search import Failed
from planner.search.solving import DRAWN_BACK, Start
from planner.vibration import BothLaws, both_laws, mean_ratio

RIVALS = 1.02  # ratio to the D-efficiency of a plan from which another family is reported
FULL = 0.9  # share of a limit that a good motion uses of at least one
FEW_KNOTS = 0.9  # share of the knots that a spline can use within the jerk limits: below it more are worth their blocks


class PlannedMotion(NamedTuple):
    """The motion from a search, and the record of the search."""

    motion: Trajectory  # the best one, proven
    settings: Settings  # settings of its family
    limits: LimitReport
    starts: tuple[Start, ...] = ()  # the best one first
    failed: tuple[Failed, ...] = ()  # starts without a feasible motion
    interrupted: bool = False  # whether Ctrl-C ended the search early
    rival: Start | None = None  # start of another family, for comparison
    laws: BothLaws | None = None  # errors by both time laws of the moves on a machine that is not stiff
    remark: str = ""  # what it replaces, and why: moves with steps of acceleration, or the path at another pace

    def of_rival(self, parameters: int) -> float:
        """D-efficiency of the other family's motion in units of this one's, with the weights of the search."""
        if self.rival is None or not self.starts:
            return 0.0
        return float(np.exp((self.rival.record.logdet - self.starts[0].record.logdet) / parameters))


def rated_plan(request: Request, case: Case, planned: PlannedMotion, seconds: float) -> Plan:
    """The plan of a feasible motion, with its figures.

    Args:
        seconds: time spent on the search [s].

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
    """
    model, motion = identification_model(case, request.model), planned.motion
    scaling = reference_scaling(case, model)
    figures, noise, worst = figures_of(case, model, motion, request.payloads, request.criterion)
    bound, parameters = information_limit(case, model), len(scaling)
    rival = None
    if planned.rival is not None:
        efficiency = planned.of_rival(parameters) * bound.efficiency(figures["logdet"])
        rival = Rival(planned.rival.family.name, efficiency)
    laws = planned.laws or both_laws(case, request.model, motion, request.payload)
    predicted = {name: std for name, (std, _) in worst.items()}
    worth = Worth(
        starts=tuple(start.record for start in planned.starts),
        failed_starts=planned.failed,
        rival=rival,
        criterion_value=figures["criterion_value"],
        logdet=figures["logdet"],
        condition=figures["condition"],
        bound=bound,
        assumed_noise_of_channels=tuple(noise.std.tolist()),
        noise_of_accelerations=noise.shaken,
        weights=noise.weights,
        weaknesses=weaknesses(planned, case, parameters),
        notes=(
            *notes(planned._replace(laws=laws), request, case, worst),
            *_noise_remarks(case, model, scaling, motion, noise, request.payload),
            *_pose_error_remarks(case, model, scaling, planned.motion, request, predicted),
        ),
        vibration=None if laws is None else laws.to_json(),
    )
    return Plan(
        case, request, motion, planned.limits, predicted, noise.sensors, case.recording.rate_Hz, worth,
        planned.settings, seconds, planned.interrupted,
    )  # fmt: skip


def _noise_remarks(
    case: Case, model: Model, scaling: Array, motion: Trajectory, noise: ExpectedNoise, payload: int
) -> tuple[str, ...]:
    """Remarks on the effect of noise of the accelerations on a plan."""
    if not noise.shaken:
        return ()
    mounted, bare = (float(np.sqrt(np.mean(n.std[:3] ** 2))) for n in (noise, expected_noise(case, model)))
    sentence = f"noise of the accelerations: a force sample errs by {mounted:.3g} N rms "
    sentence += f"with {payload_words(payload)}, by {bare:.3g} N without" if payload else "without payload"
    sentence += f"; the sensors alone by {noise.sensors:.3g} N"
    if noise.weights == "stated":
        return (sentence,)
    stated = expected_noise(case, model, payload, "stated")
    pairs = [predicted_std_of(case, model, scaling, motion, n, payload) for n in (stated, noise)]
    return (
        sentence,
        f'identify --weights stated, or sensors.weights = "stated" in the case, makes the standard deviations '
        f"{100 * (1.0 - mean_ratio(*pairs)):.0f} % smaller than the weights {noise.weights} (geometric mean, this "
        "motion)",
    )


def _pose_error_remarks(
    case: Case, model: Model, scaling: Array, motion: Trajectory, request: Request, predicted: dict[str, float]
) -> tuple[str, ...]:
    """A remark on the cost of errors that depend on the pose, where the case states them."""
    field = case.sensors.pose_field
    if field is None:
        return ()
    worst = worst_std(without_pose_errors(case), model, scaling, motion, request.payloads)
    times = mean_ratio(predicted, {name: std for name, (std, _) in worst.items()})
    return (
        f"errors that depend on the pose ({field.words}) make the standard deviations {times:.3g} times those of white "
        "noise alone (geometric mean); D-efficiency counts white noise alone",
    )


def weaknesses(planned: PlannedMotion, case: Case, parameters: int) -> tuple[str, ...]:
    """Reasons why another plan would carry more information, each with a remedy; the first thing that a user reads."""
    words = []
    times = planned.of_rival(parameters)
    if planned.rival is not None and times > RIVALS:
        remark = "" if case.sensors.pose_error_N is None else ", errors of the pose counted"
        words.append(
            f"weaker than a motion of another family that took seconds: --family {planned.rival.family.name} has "
            f"{times:.2f} times the D-efficiency{remark}"
        )
    refined = [s.record for s in planned.starts if s.record.refined]
    if refined and not planned.interrupted and not refined[0].converged:
        words.append(
            f"the search had not converged where it ended ({refined[0].solver.words}): more --seconds or "
            "--starts may find more"
        )
    if planned.starts and (share := planned.starts[0].shrunk) < DRAWN_BACK:
        words.append(
            f"the motion had to be drawn to {100 * share:.0f} % of its ways to satisfy every limit: plan with "
            f"another --seed, or in a smaller box (hexcite case check {case.origin or case.name} --propose)"
        )
    checks = [c for c in planned.limits.checks if c.binding and c.kind.kinetic]
    if planned.starts and checks and (most := max(checks, key=lambda c: c.ratio)).ratio < FULL:
        words.append(
            f"no limit of speed or force is used beyond {100 * most.ratio:.0f} % ({most.name}): another --seed, "
            "more --seconds or a smaller box may find more"
        )
    return tuple(words)


def notes(planned: PlannedMotion, request: Request, case: Case, worst: dict[str, tuple[float, int]]) -> tuple[str, ...]:
    """Notes for the user before the plan is run.

    Args:
        worst: predicted standard deviation of each parameter, and the number of payloads with which it is so large.
    """
    motion, settings = planned.motion, planned.settings
    words = []
    if isinstance(motion, FourierMotion) and (needless := needless_harmonics(motion)):
        order = max(2, motion.order - needless)
        if order < motion.order:
            text = "highest harmonic is" if needless == 1 else f"{needless} highest harmonics are"
            words.append(f"the {text} negligible: --order {order} would do")
    if planned.starts and (binding := bound_by(planned.limits)):
        words.append(f"shaped by these limits: {', '.join(binding)}")
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
    if isinstance(knots := settings.get("knots"), int):
        enough = enough_intervals(case, motion.duration)
        if knots < FEW_KNOTS * enough:
            words.append(
                f"{knots} knots, not the machine, keep accelerations from their limits: --knots {enough} carries "
                "more information"
            )
    if len(request.payloads) > 1:
        by_load = {n: [p for p, (_, most) in worst.items() if most == n] for n in request.payloads}
        text = "; ".join(f"with {n} those of {', '.join(names)}" for n, names in by_load.items() if names)
        words.append(f"predicted standard deviations are the largest with {request.mounted}: {text}")
    forces = [c for c in planned.limits.checks if c.kind is LimitKind.SENSOR_FORCE and c.ratio > BINDING]
    words += [
        f"{c.name} shapes the motion: with fewer weights in [payloads] it could carry more information" for c in forces
    ]
    words += [planned.remark] if planned.remark else []
    return tuple(words if planned.laws is None else [*words, planned.laws.sentence])
