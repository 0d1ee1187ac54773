"""What came of a search, and what a user should know of it."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cases.schema import Case
from identification.limit import LimitKind, LimitReport, Status
from identification.motion import Trajectory
from identification.trajectories.curves import FourierMotion, needless_harmonics
from planner.families.fourier import FourierFamily
from planner.families.spline import enough_intervals
from planner.request import Request, parse_targets
from planner.search.ipopt import solver_text
from planner.search.solving import DRAWN_BACK, Failed, Start

if TYPE_CHECKING:
    from planner.vibration import BothLaws

RIVALS = 1.02  # times the D-efficiency of a plan, from which another family is worth a word
FULL = 0.9  # share of a limit that a good motion uses of at least one
BINDING = 0.99  # share of a limit from which it shapes the motion
FEW_KNOTS = 0.9  # of as many as the jerk limits allow a spline to use: with fewer, more are worth their blocks


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
    laws: "BothLaws | None" = None  # what the time law of moves costs on a machine that is not stiff
    of_law: str = ""  # what came of the choice between two time laws

    def of_rival(self, parameters: int) -> float:
        """D-efficiency of the other family's motion in units of this one's, with the weights of the search."""
        if self.rival is None or not self.starts:
            return 0.0
        return float(np.exp((self.rival.logdet - self.starts[0].logdet) / parameters))


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
    refined = [s for s in found.starts if s.refined]
    if refined and not found.interrupted and not refined[0].converged:
        words.append(
            f"the search had not converged where it ended ({solver_text(refined[0].status)}): more --seconds or "
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


def bound_by(limits: LimitReport) -> list[str]:
    """The limits that shape a motion."""
    return [c.name for c in limits.checks if c.binding and c.ratio > BINDING]


def notes(
    found: Found,
    request: Request,
    case: Case,
    worst: dict[str, tuple[float, int]],
) -> tuple[str, ...]:
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
        targets = parse_targets(request.targets, case, request.model)
        words.append(f"targets: {', '.join(t.compared(predicted) for t in targets)}")
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
