"""What came of a search: what it is worth as a plan, and what a user should know of it."""

from typing import Any, NamedTuple

import numpy as np

from cases.schema import Case
from cases.sensors import payload_words
from identification.criteria import reference_scaling
from identification.estimation.fit import PoseField
from identification.limit import LimitKind, LimitReport, Status
from identification.model import Model, identification_model
from identification.motion import Array, Trajectory
from identification.trajectories.curves import FourierMotion, needless_harmonics
from planner.bounds.kept import box_bound, known_tight_bound
from planner.families.fourier import FourierFamily
from planner.families.spline import enough_intervals
from planner.noise import ExpectedNoise, expected_noise, mean_information, without_pose_errors
from planner.plans import Plan
from planner.precision import solver_text
from planner.request import Request, parse_targets
from planner.search import Failed
from planner.search.solving import DRAWN_BACK, Start
from planner.vibration import BothLaws, both_laws
from planner.worth import BINDING, Rival, Search, Worth, bound_by, figures_of, predicted_std_of, worst_std

RIVALS = 1.02  # times the D-efficiency of a plan, from which another family is worth a word
FULL = 0.9  # share of a limit that a good motion uses of at least one
FEW_KNOTS = 0.9  # of as many as the jerk limits allow a spline to use: with fewer, more are worth their blocks
AT_REST = 1e-6  # [m/s, rad/s; m/s^2, rad/s^2] of rounding


class Found(NamedTuple):
    """What came of a search."""

    motion: Trajectory  # the best, proven
    settings: dict[str, Any]  # settings of its family, as found
    limits: LimitReport
    starts: tuple[Start, ...] = ()
    failed: tuple[Failed, ...] = ()  # starts that led nowhere
    interrupted: bool = False  # whether Ctrl-C ended the search early
    rival: Start | None = None  # what another family found in seconds
    white: Start | None = None  # what one start reaches where errors of the pose do not count
    laws: BothLaws | None = None  # what the time law of moves costs on a machine that is not stiff
    of_law: str = ""  # what came of the choice between two time laws

    def of_rival(self, parameters: int) -> float:
        """D-efficiency of the other family's motion in units of this one's, with the weights of the search."""
        if self.rival is None or not self.starts:
            return 0.0
        return float(np.exp((self.rival.tried.logdet - self.starts[0].tried.logdet) / parameters))


def rated(request: Request, case: Case, found: Found, seconds: float) -> Plan:
    """The plan of a motion that keeps all limits: what it is worth.

    Raises:
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
    """
    model = identification_model(case, request.model)
    scaling = reference_scaling(case, model)
    figures, noise, worst = figures_of(case, model, found.motion, request.payloads, request.criterion)
    laws = found.laws or both_laws(case, request.model, found.motion, request.payload)
    predicted = {name: std for name, (std, _) in worst.items()}
    remarks = (
        *_told(case, model, scaling, found.motion, noise, request.payload),
        *_of_pose_errors(case, model, scaling, found, request, predicted),
    )
    bound, parameters = box_bound(case, model), len(scaling)
    worth = Worth(
        settings=found.settings,
        search=_record(found, seconds, bound.efficiency(figures["logdet"]), parameters),
        criterion_value=figures["criterion_value"],
        logdet=figures["logdet"],
        condition=figures["condition"],
        bound=bound,
        bound_tight=known_tight_bound(case, model) if _from_rest_to_rest(found.motion) else None,
        assumed_noise_of_channels=tuple(noise.std.tolist()),
        noise_of_accelerations=noise.shaken,
        weights=noise.weights,
        weaknesses=weaknesses(found, case, parameters),
        notes=(*notes(found._replace(laws=laws), request, case, worst), *remarks),
        vibration=None if laws is None else laws.to_json(),
    )
    rate = case.recording.rate_Hz
    return Plan(case, request, found.motion, found.limits, predicted, noise.sensors, rate, worth)


def _record(result: Found, seconds: float, efficiency: float, parameters: int) -> Search:
    """What a plan keeps of its search."""
    rival = None
    if result.rival is not None:
        rival = Rival(result.rival.family.name, result.of_rival(parameters) * efficiency)
    return Search(tuple(s.tried for s in result.starts), result.failed, result.interrupted, seconds, rival)


def _from_rest_to_rest(motion: Trajectory) -> bool:
    """Whether nothing moves or speeds up at either end: the tighter bound is one of such motions only."""
    ends = motion.at([0.0, motion.duration])
    return bool(max(np.abs(ends.rates).max(), np.abs(ends.accelerations).max()) < AT_REST)


def _told(
    case: Case, model: Model, scaling: Array, motion: Trajectory, noise: ExpectedNoise, payload: int
) -> tuple[str, ...]:
    """What noise of the accelerations does to a plan."""
    if not noise.shaken:
        return ()
    mounted = f"with {payload_words(payload)}" if payload else "without payload"
    sentence = f"noise of the accelerations: a force sample errs by {_rms(noise):.3g} N rms {mounted}"
    if payload:
        sentence += f", by {_rms(expected_noise(case, model)):.3g} N without"
    sentence += f"; the sensors alone by {noise.sensors:.3g} N"
    if noise.weights == "stated":
        return (sentence,)
    case_noise = expected_noise(case, model, payload, "stated")
    pairs = [predicted_std_of(case, model, scaling, motion, n, payload) for n in (case_noise, noise)]
    less = 1.0 - float(np.exp(np.mean([np.log(pairs[0][name] / pairs[1][name]) for name in pairs[0]])))
    return (
        sentence,
        f'identify --weights stated, or sensors.weights = "stated" in the case, makes the standard deviations '
        f"{100 * less:.0f} % smaller than the weights {noise.weights} (geometric mean, this motion)",
    )


def _of_pose_errors(
    case: Case, model: Model, scaling: Array, result: Found, request: Request, predicted: dict[str, float]
) -> tuple[str, ...]:
    """What errors that depend on the pose cost a plan, and what it gave up for them."""
    field = PoseField.of(case.sensors)
    if field is None:
        return ()
    white = worst_std(without_pose_errors(case), model, scaling, result.motion, request.payloads)
    times = float(np.exp(np.mean([np.log(predicted[name] / std) for name, (std, _) in white.items()])))
    remark = (
        f"errors that depend on the pose ({field.words}) make the standard deviations {times:.3g} times those of white "
    )
    remark += "noise alone (geometric mean); "
    if result.white is None:
        return (remark + "D-efficiency counts white noise alone",)
    plain = np.linalg.slogdet(mean_information(model, scaling, result.motion))[1]
    other = result.white.family.motion(result.white.unknowns)
    best = np.linalg.slogdet(mean_information(model, scaling, other))[1]
    bound = box_bound(case, model)
    return (
        f"{remark}D-efficiency, which counts white noise alone, is {bound.efficiency(float(plain)):.3f}; a plan for it "
        f"reaches {bound.efficiency(float(max(best, plain))):.3f}",
    )


def _rms(noise: ExpectedNoise) -> float:
    return float(np.sqrt(np.mean(noise.std[:3] ** 2)))


def weaknesses(found: Found, case: Case, parameters: int) -> tuple[str, ...]:
    """Why another plan would carry more information, each with what to do; the first thing that a user reads."""
    words = []
    times = found.of_rival(parameters)
    if found.rival is not None and times > RIVALS:
        remark = "" if case.sensors.pose_error_N is None else ", errors of the pose counted"
        words.append(
            f"weaker than a motion of another family that took seconds: --family {found.rival.family.name} has "
            f"{times:.2f} times the D-efficiency{remark}"
        )
    refined = [s.tried for s in found.starts if s.tried.refined]
    if refined and not found.interrupted and not refined[0].converged:
        words.append(
            f"the search had not converged where it ended ({solver_text(refined[0].solver)}): more --seconds or "
            "--starts may find more"
        )
    if found.starts and (share := found.starts[0].shrunk) < DRAWN_BACK:
        words.append(
            f"the motion had to be drawn to {100 * share:.0f} % of its ways to satisfy every limit: plan with "
            f"another --seed, or in a smaller box (hexcite case check {case.origin or case.name} --propose)"
        )
    checks = [c for c in found.limits.checks if c.binding and c.kind.kinetic]
    if found.starts and checks and (most := max(checks, key=lambda c: c.ratio)).ratio < FULL:
        words.append(
            f"no limit of speed or force is used beyond {100 * most.ratio:.0f} % ({most.name}): another --seed, "
            "more --seconds or a smaller box may find more"
        )
    return tuple(words)


def notes(found: Found, request: Request, case: Case, worst: dict[str, tuple[float, int]]) -> tuple[str, ...]:
    """What the user should know before running it.

    Args:
        worst: predicted standard deviation of each parameter, and the number of payloads with which it is so large.
    """
    motion, settings = found.motion, found.settings
    words = []
    if isinstance(motion, FourierMotion) and (needless := needless_harmonics(motion)):
        order = max(2, motion.order - needless)
        if order < motion.order:
            text = "highest harmonic is" if needless == 1 else f"{needless} highest harmonics are"
            words.append(f"the {text} negligible: --order {order} would do")
    if found.starts and (binding := bound_by(found.limits)):
        words.append(f"shaped by these limits: {', '.join(binding)}")
    if steps := [c for c in found.limits.checks if c.status is Status.STEPS]:
        limits = ", ".join(f"{abs(c.limit):.4g} {c.unit}" for c in steps)
        words.append(
            f"made for {settings.get('made_for')}, which does not limit jerk: accelerations step, and the limits of "
            f"jerk of the case ({limits}) do not count"
        )
    choices = {(s.family.order, s.family.period) for s in found.starts if isinstance(s.family, FourierFamily)}
    if len(choices) > 1:
        own = f"order {settings['order']} with period {settings['period_s']:g} s"
        words.append(f"{own} is the best of {len(choices)} choices of order and period")
    if (method := settings.get("retimed_with")) is not None:
        before, off_mm, off_deg = (float(settings[k]) for k in ("duration_before_s", "off_path_mm", "off_path_deg"))
        off = f", up to {off_mm:.2g} mm and {off_deg:.2g} deg off its path" if off_mm or off_deg else ""
        words.append(f"re-timed with {method}: {motion.duration:.2f} s instead of {before:.2f} s{off}")
    if request.targets:
        predicted = {name: std for name, (std, _) in worst.items()}
        reached = (
            f"{t.name} {predicted[t.name] / t.scale:.3g} of {t.value / t.scale:.3g} {t.unit}"
            for t in parse_targets(request.targets, case, request.model)
        )
        words.append(f"targets: {', '.join(reached)}")
    if (knots := settings.get("knots")) is not None:
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
    forces = [c for c in found.limits.checks if c.kind is LimitKind.SENSOR_FORCE and c.ratio > BINDING]
    words += [
        f"{c.name} shapes the motion: with fewer weights in [payloads] it could carry more information" for c in forces
    ]
    words += [found.of_law] if found.of_law else []
    return tuple(words if found.laws is None else [*words, found.laws.sentence])
