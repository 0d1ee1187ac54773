"""Numeric proof that a motion satisfies the limits of its case.

Written in NumPy from the definitions (rotation matrices differentiated by the product rule), with no code in common
with the CasADi models that the optimiser uses.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

import numpy as np

from cases.base.units import Array
from cases.chain import Box
from cases.schema import Case
from identification.limits.chain import LimitedChain
from identification.limits.hexapod import LimitedHexapod
from identification.limits.limit import UNUSED_SHARE, LimitCheck, LimitKind, LimitReport, Quantity, Status, worst_of
from identification.limits.sensor_loads import Loads, sensor_loads
from identification.motion.motion import LoadMotion, Motion, Trajectory
from identification.motion.moves import StraightMove

PROOF_RATE = 10_000.0  # [1/s]; at most 200 rad/s^3 * (1e-4 s)^2 / 8 escape between samples, 1e-7 of the rate limits
STEP = 10.0  # times the limit of jerk: a change of the acceleration that is a step, not the rounding of two pieces
SHORTEST_GAP = 1e-6  # [s] between instants, below which a change of the acceleration is not looked at more closely
CHUNK = 2000  # samples at once: what is computed of them stays in the processor's cache


def prove(trajectory: Trajectory, case: Case, rate: float = PROOF_RATE, in_box: bool = True) -> LimitReport:
    """Checks every limit of `[limits.motion]` and `[workspace]` on a fine grid.

    Args:
        rate: samples a second [1/s].
        in_box: whether it must stay in the pose box of `[limits.motion]`; positioning need only stay in `[workspace]`.
    """
    steps = max(1, math.ceil(trajectory.duration * rate - 1e-9))
    return prove_at(trajectory, case, np.linspace(0.0, trajectory.duration, steps + 1), in_box)


class LimitedMachine(Protocol):
    """What a machine limits beside its coordinates, and how it moves the load; n instants, k coordinates.

    The search has limits of its own, `Machine.shares`: neither knows the other.
    """

    def ranges(self, motion: Motion, /) -> Iterable[Quantity]:
        """Where the coordinates are, between the ends of what the machine can reach."""

    def drives(self, motion: Motion, /) -> tuple[Array, Array, Array]:
        """Positions, rates and accelerations of the drives, shapes (n, k) [m or rad]."""

    def mechanics(self, motion: Motion, /) -> tuple[LoadMotion, Iterable[Quantity]]:
        """Motion of the load's frame, and all further limits, which need it: each is computed when it is asked for."""

    def fastest(self, rate: Array, acceleration: Array, /) -> tuple[float, float, float]:
        """Bounds of the load's |omega|, |alpha| and |p''| in any pose [rad/s, rad/s^2, m/s^2].

        From the largest first and second derivatives of the coordinates, shapes (k,).
        """

    def from_anywhere(
        self, speed: float, rate: Array, acceleration: Array, /
    ) -> Iterable[tuple[LimitKind, float, float]]:
        """Kind, bound and limit of drives that are not the coordinates, in any pose [SI].

        `speed` is the largest of the load's frame [m/s]; the others as in `fastest`.
        """


def limited_machine(case: Case) -> LimitedMachine:
    """The machine of a case; raises CaseError where the case lacks it or its limits."""
    return LimitedHexapod.of(case) if case.need_motion("the proof of limits")[1].of_pose else LimitedChain.of(case)


Limited = Callable[[Motion, Case, bool], Iterable[Quantity]]
"""Something of a sampled motion that a case limits; the last argument is the `in_box` of `prove`."""


def of_coordinates(motion: Motion, case: Case, in_box: bool) -> Iterable[Quantity]:
    """Coordinates and their derivatives."""
    home, limits = case.need_motion("the proof of limits")
    if in_box:
        low, high = limits.coordinates
        yield from _by_kind((LimitKind.POSITION, LimitKind.ANGLE), motion.coordinates - home, low, high, limits)
    yield from limited_machine(case).ranges(motion)
    yield from _rates(motion, limits)
    a, j = limits.acceleration, limits.jerk
    kinds = LimitKind.ACCELERATION, LimitKind.ANGULAR_ACCELERATION
    yield from _by_kind(kinds, motion.accelerations, -a, a, limits)
    if limits.limits_jerk:
        yield from _by_kind((LimitKind.JERK, LimitKind.ANGULAR_JERK), _jerks(motion, j), -j, j, limits)


def of_mechanics(motion: Motion, case: Case, in_box: bool) -> Iterable[Quantity]:
    """Quantities of struts, joints, boxes, singularities and sensors, which need the motion of the load."""
    load, quantities = limited_machine(case).mechanics(motion)
    yield from quantities
    loads = Loads.of(case)
    if loads is not None:
        yield from sensor_loads(loads.forces(motion, *load), loads)


def of_velocities(motion: Motion, case: Case) -> Iterable[Quantity]:
    """Rates of the coordinates, and of the drives where these are others."""
    limits = case.need_motion("the proof of limits")[1]
    yield from _rates(motion, limits)
    if limits.of_pose:
        further = limited_machine(case).mechanics(motion)[1]
        yield next(quantity for quantity in further if quantity.of.kind is LimitKind.STRUT_VELOCITY)


def everything(motion: Motion, case: Case, in_box: bool) -> Iterable[Quantity]:
    """All quantities that a case limits."""
    yield from of_coordinates(motion, case, in_box)
    yield from of_mechanics(motion, case, in_box)


def prove_at(
    trajectory: Trajectory,
    case: Case,
    instants: Array,
    in_box: bool = True,
    limited: Limited = everything,
) -> LimitReport:
    """Checks limits, by default every one, at given instants, shape (n,) [s]; see `prove`."""
    reports = []
    for quantities, t, _ in _evaluated(trajectory, case, instants, in_box, limited):
        reports.append(LimitReport(tuple(worst_case(q, t) for q in quantities)))
    return worst_of(reports)


def shares_at(trajectory: Trajectory, case: Case, instants: Array, in_box: bool, limited: Limited) -> Array:
    """Share of each limit that is used at each instant, shape (n, limits); see `prove_at`.

    Limits may be none: of the mechanics of an arm whose case states no bodies, torques and range of the sensor.
    """
    parts = [
        np.column_stack([np.zeros((len(t), 0)), *(q.ratio.max(axis=1) for q in quantities)])[checks]
        for quantities, t, checks in _evaluated(trajectory, case, instants, in_box, limited)
    ]
    return np.concatenate(parts)


_BY_POWER = (
    (LimitKind.VELOCITY, LimitKind.STRUT_VELOCITY),
    (LimitKind.ACCELERATION, LimitKind.STRUT_ACCELERATION),
    (LimitKind.JERK,),
)  # families of limits that shrink with the first, second and third power of the pace


def kinetic_shares(trajectory: Trajectory, case: Case, instants: Array) -> tuple[Array, Array, Array]:
    """Share that is used at each instant of any limit of velocities, of accelerations and of jerks, each of shape (n,).

    Slowing down helps against these limits: their shares shrink with the first, second and third power of the pace.
    """
    parts = [
        [
            np.max(
                [np.zeros(len(t)), *(q.ratio.max(axis=1) for q in quantities if q.of.kind.family in families)], axis=0
            )[checks]
            for families in _BY_POWER
        ]
        for quantities, t, checks in _evaluated(trajectory, case, instants, True, everything)
    ]
    velocity, acceleration, jerk = (np.concatenate(shares) for shares in zip(*parts, strict=True))
    return velocity, acceleration, jerk


_OF_ACCELERATIONS = (
    LimitKind.STRUT_ACCELERATION, LimitKind.SENSOR_FORCE, LimitKind.SENSOR_MOMENT, LimitKind.JOINT_TORQUE,
    LimitKind.JOINT_FORCE,
)  # fmt: skip


def mechanical_pace(move: Trajectory, case: Case, rate: float = PROOF_RATE) -> float:
    """Largest share of the pace that struts, sensors and torques of joints allow, above 1 where it is too fast."""
    shares = [0.0]
    for check in prove(move, case, rate, in_box=False).checks:
        if check.kind in _OF_ACCELERATIONS:
            shares.append(math.sqrt(check.ratio))
        elif check.kind is LimitKind.STRUT_VELOCITY:
            shares.append(check.ratio)
    return max(shares)


SLOWINGS, SLOWED = 30, 0.95  # of a move with too large forces or torques: its weight does not depend on the pace
FORCE_RATE = 1000.0  # [1/s] at which these are looked at


def slowed_for_forces(move: StraightMove, case: Case) -> StraightMove:
    """The move itself, or slowed until struts, sensors and torques of joints satisfy their limits, where that helps."""
    for _ in range(SLOWINGS):
        if (share := mechanical_pace(move, case, FORCE_RATE)) <= 1.0:
            break
        move = StraightMove(move.start, move.end, move.profile.slowed(min(SLOWED, (1.0 - UNUSED_SHARE) / share)))
    return move


def _evaluated(
    trajectory: Trajectory, case: Case, instants: Array, in_box: bool, limited: Limited
) -> Iterator[tuple[tuple[Quantity, ...], Array, slice]]:
    """Quantities that are limited, in chunks of instants: with the instants beside each chunk, and which are its own.

    What is between two instants belongs to both.
    """
    for first in range(0, len(instants), CHUNK):
        before = min(first, 1)
        t = instants[first - before : first + CHUNK + 1]
        with np.errstate(invalid="ignore"):  # what is not a number counts as exceeded, and is reported so
            yield tuple(limited(trajectory.at(t), case, in_box)), t, slice(before, before + CHUNK)


def worst_case(quantity: Quantity, t: Array) -> LimitCheck:
    """Where the largest share is used; `t` are the instants, shape (n,) [s]."""
    kind = quantity.of.kind
    column = int(np.argmax(quantity.ratio.max(axis=0)))
    if kind.least and np.isfinite(quantity.ratio).all():  # shares of two columns do not compare, values do
        column = int(np.argmin(quantity.values.min(axis=0)))
        row = int(np.argmin(quantity.values[:, column]))
    else:
        row = int(np.argmax(quantity.ratio[:, column]))
    value, low, high = (float(v * kind.scale) for v in (quantity.values[row, column], *quantity.limits[:, column]))
    return LimitCheck(
        quantity.of,
        quantity.labels[column],
        value,
        high if value >= (low + high) / 2 else low,
        kind.unit,
        float(quantity.ratio[row, column]),
        float(t[row]),
        Status.PROVEN,
        bounds=None if low == high else (low, high),
    )


def _rates(motion: Motion, limits: Box) -> Iterable[Quantity]:
    v = limits.rate
    yield from _by_kind((LimitKind.VELOCITY, LimitKind.ANGULAR_VELOCITY), motion.rates, -v, v, limits)


def _by_kind(
    kinds: tuple[LimitKind, LimitKind], values: Array, low: Array, high: Array, limits: Box
) -> Iterable[Quantity]:
    """Translations and rotations of a derivative of the coordinates; the kind of each, values in SI."""
    for kind, axes in zip(kinds, (~limits.turns, limits.turns), strict=True):
        if axes.any():
            labels = tuple(label for label, of_its_kind in zip(limits.labels, axes, strict=True) if of_its_kind)
            yield Quantity.between(kind, labels, values[:, axes], low[axes], high[axes])


def _jerks(motion: Motion, limit: Array) -> Array:
    """Jerks, shape (n, k); where accelerations step between two instants, their change over the time between these."""
    if len(motion.t) < 2:
        return motion.jerks
    gaps = np.diff(motion.t)[:, None]
    slopes = np.diff(motion.accelerations, axis=0) / np.maximum(gaps, SHORTEST_GAP)
    jerks = motion.jerks.copy()
    np.copyto(jerks[1:], slopes, where=np.abs(slopes) > STEP * limit)
    return jerks
