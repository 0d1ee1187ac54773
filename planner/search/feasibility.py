"""Feasible motions: a motion shrunk inside every limit, and the keys to change where there is none."""

from itertools import count

import numpy as np

from cases.base.errors import Code, IdentificationError, InfeasiblePlan
from cases.base.phrases import Phrase, phrase, said
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.criteria import box_middle, information, singular_values, uniform_states
from identification.limits.limit import TOLERANCE, UNUSED_SHARE, LimitCheck, LimitKind, LimitReport
from identification.limits.proof import prove
from identification.machines.of_case import machine_of
from identification.model.model import Model
from identification.motion.motion import Standstill
from planner.families.family import Family

CLOSE_ENOUGH = 3e-4  # gap of the bisection that shrinks a motion
ASIDE = CLOSE_ENOUGH / 3  # of a share at which a limit is expected: it is tried on both sides of it
SMALLEST = 1e-6  # share of all distances below which nothing moves


def keep_limits(case: Case, family: Family, unknowns: Array, rate: float) -> tuple[Array, float]:
    """The same as `shrunk_inside`, however small the motion becomes."""
    inside = shrunk_inside(case, family, unknowns, rate, 0.0)
    assert inside is not None
    return inside


def shrunk_inside(case: Case, family: Family, unknowns: Array, rate: float, least: float) -> tuple[Array, float] | None:
    """Shrinks a motion towards the box's middle until it satisfies every limit, less a margin, on a grid of `rate`.

    The steps grow from small to large: strut lengths need not fall on the way, so that a smaller motion is not always
    further inside. They are at least as long as a limit asks for that is proportional to distances, as most are.

    Args:
        least: share of its distances below which it is given up.

    Returns:
        Unknowns of the motion inside, and its distances over those before it was shrunk; None where it is given up.

    Raises:
        InfeasiblePlan: the motion exceeds a limit even where hardly anything moves; the message names the limit.
    """

    def report_at(share: float) -> LimitReport:
        return prove(family.motion(family.shrunk(unknowns, share)), case, rate)

    def excess(report: LimitReport) -> float:
        return report.worst_ratio - (1.0 - UNUSED_SHARE + TOLERANCE)

    share, outside, step = 1.0, (1.0, np.inf), CLOSE_ENOUGH  # outside: the last share there, and its excess
    while (over := excess(report := report_at(share))) > 0.0:
        if share <= SMALLEST:
            worst = max(report.checks, key=lambda c: c.ratio)
            raise InfeasiblePlan(
                problem=phrase("no_motion", "no feasible motion: {limit}", limit=worst.sentence()),
                remedy=phrase("or_home", "{remedy} or move home", remedy=remedy(worst, case)),
                code=Code.INFEASIBLE,
            )
        outside = share, over
        reduction = share * over / (1.0 + over) + ASIDE if np.isfinite(over) else 0.0  # most limits are proportional
        share -= min(max(step, reduction), share / 2)
        step *= 2
        if share < least:
            return None
    for number in count():
        failed, over_there = outside
        if failed - share <= CLOSE_ENOUGH:
            break
        between = (failed + share) / 2
        if number % 3 < 2 and np.isfinite(over_there):  # where both are proportional the limit lies between two probes
            crossing = share + (failed - share) * over / (over - over_there)
            between = float(np.clip(crossing + (ASIDE, -ASIDE)[number % 3], share + ASIDE, failed - ASIDE))
        if (more := excess(report_at(between))) > 0.0:
            outside = between, more
        else:
            share, over = between, more
    return family.shrunk(unknowns, share), share


_BOX, _JOINTS = "limits.motion", "limits.motion.joints"


def _key(kind: LimitKind, of_pose: bool) -> str:
    """Where a case states a limit."""
    unit = kind.unit.replace("/", "_").replace("^", "")
    if not of_pose:
        place = "machine.chain.joints" if kind in (LimitKind.JOINT_POSITION, LimitKind.JOINT_ANGLE) else _JOINTS
        return f"{kind.family if kind.kinetic else 'position'}_{unit} of {place}"
    several = {
        LimitKind.POSITION: f"{_BOX}.x_mm, y_mm, z_mm",
        LimitKind.ANGLE: f"{_BOX}.a_deg, b_deg, c_deg",
        LimitKind.WORKSPACE_POSITION: "workspace.x_mm, y_mm, z_mm",
        LimitKind.STRUT_LENGTH: f"{_BOX}.strut_length_mm and workspace.strut_length_mm",
    }
    return several.get(kind, f"{_BOX if kind.kinetic else 'workspace'}.{kind.replace(' ', '_')}_{unit}")


def remedy(check: LimitCheck, case: Case) -> Phrase:
    """The remedy where a limit of a case allows no motion."""
    match check.kind:
        case LimitKind.DISTANCE_FROM_BOX:
            table = "workspace" if machine_of(case).of_pose else "machine.chain"
            return phrase("smaller_box", "make that box of {table}.keep_out smaller", table=table)
        case LimitKind.DISTANCE_BETWEEN_LINKS:
            return phrase(
                "narrow_joints",
                "narrow position_deg of {joints}, correct the bodies in machine.chain or name them in its may_touch",
                joints=_JOINTS,
            )
        case LimitKind.JOINT_TORQUE:
            return phrase(
                "lower_accelerations",
                "lower the accelerations of {joints}, correct {effort} or nominal",
                joints=_JOINTS,
                effort="torque_Nm",
            )
        case LimitKind.JOINT_FORCE:
            return phrase(
                "lower_accelerations",
                "lower the accelerations of {joints}, correct {effort} or nominal",
                joints=_JOINTS,
                effort="force_N",
            )
        case LimitKind.SENSOR_FORCE | LimitKind.SENSOR_MOMENT:
            return phrase("less_weight", "take weights out of [payloads], correct sensors.range_N or range_Nm")
        case LimitKind.SINGULARITY:
            return phrase("narrow_poses", "narrow the poses of {box}", box=_BOX)
        case kind:
            return phrase("widen", "widen {key}", key=_key(kind, machine_of(case).of_pose))


def remedy_at_rest(check: LimitCheck, case: Case) -> Phrase:
    """The remedy where a machine cannot even stand, which no slower motion is."""
    if check.kind not in (LimitKind.JOINT_TORQUE, LimitKind.JOINT_FORCE):
        return remedy(check, case)
    return phrase(
        "correct_weights",
        "correct {effort} or link of machine.chain.joints, or nominal,",
        effort="torque_Nm" if check.kind is LimitKind.JOINT_TORQUE else "force_N",
    )


def require_rest(case: Case) -> None:
    """Raises where the machine cannot stand still in the middle of the box, to which every family can shrink.

    Raises:
        InfeasiblePlan: standing there exceeds a limit; the message names the limit.
    """
    report = prove(Standstill(box_middle(case)[0], 0.01), case, 100.0)
    if not report.kept:
        worst = report.violations[0]
        raise InfeasiblePlan(
            problem=phrase("no_motion", "no feasible motion: {limit}", limit=worst.sentence(timed=False)),
            remedy=phrase("or_home", "{remedy} or move home", remedy=remedy_at_rest(worst, case)),
            code=Code.INFEASIBLE,
        )


STATES, SEED = 400, 0  # states of the box at which the regressor is evaluated, and their seed


def require_identifiable(case: Case, model: Model) -> None:
    """Refuses a machine that cannot move its load in all the ways that a model needs, whatever the motion.

    Raises:
        IdentificationError: the message names the parameters that stay unknown.
    """
    states = uniform_states(case, STATES, SEED)
    scaling = np.sqrt(np.diag(information(model, np.ones(len(model.parameters)), states)))
    try:
        singular_values(information(model, 1.0 / np.where(scaling > 0.0, scaling, 1.0), states), model.names)
    except IdentificationError as error:
        raise IdentificationError(
            problem=phrase(
                "box_excites_too_little",
                "case {case}, limits.motion: for any motion in this box {why}: the machine does not turn or accelerate "
                "its load about enough axes",
                case=case.name,
                why=said(error.said.problem),
            ),
            remedy=phrase(
                "wider_or_smaller_model",
                "widen the box, or choose a smaller model than {number}",
                number=model.number,
            ),
            code=Code.NO_EXCITATION,
        ) from error
