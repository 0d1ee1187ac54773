"""Hypotheses about the drawing of a hexapod: its two rings and home, and the ends of the bars of its sensor frame."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cases.base.phrases import Phrase, phrase
from cases.base.units import MM
from cases.machine import HexapodMachine, Joints, Ring
from cases.schema import Case
from cases.sensors import Bars
from identification.findings.causes.hypothesis import Edit, Family, Hypothesis
from identification.texts import number

BETWEEN = 60.0  # [deg] between the centre of a pair of joints and the middle to the next pair
TOLERANCE_MM = 1e-6  # by which points count as those of a ring

Change = Callable[[Joints], Joints | None]
"""Six joints as another reading of their drawing gives them; None where it does not apply to them."""
Exchange = Callable[[Joints, Joints], tuple[Joints, Joints] | None]


@dataclass(frozen=True, slots=True)
class _Set:
    """Two sets of six joints that belong together: of the machine, or of the bars."""

    family: Family
    table: str  # where they stand in a case
    keys: tuple[str, str]
    names: tuple[Phrase, Phrase]
    both: Phrase

    def joints(self, case: Case) -> tuple[Joints, Joints]:
        """The two."""
        one, other = self.keys
        part = case.hexapod if self.table == "machine" else case.sensor_frame.bars
        return getattr(part, one), getattr(part, other)

    def changed(self, case: Case, **joints: Joints) -> Case:
        """The case with other joints."""
        if self.table == "machine":
            assert case.machine is not None
            return case.model_copy(update={"machine": case.machine.model_copy(update=joints)})
        frame = case.sensor_frame
        assert frame.bars is not None
        frame = frame.model_copy(update={"bars": frame.bars.model_copy(update=joints)})
        return case.model_copy(update={"sensor_frame": frame})


_RINGS = _Set(
    Family.MACHINE, "machine", ("base", "platform"),
    (phrase("base_joints", "joints of the base"), phrase("platform_joints", "joints of the platform")),
    phrase("ring_joints", "joints of base and platform"),
)  # fmt: skip
_BARS = _Set(
    Family.BARS,
    "bars",
    ("lower", "upper"),
    (phrase("lower_ends", "lower ends of the bars"), phrase("upper_ends", "upper ends of the bars")),
    phrase("bar_ends", "ends of the bars"),
)


def of_machine(case: Case, machine: HexapodMachine) -> Iterator[Hypothesis]:
    """Hypotheses about joints and home of a hexapod."""
    yield from _of_set(case, _RINGS)
    exchanged = phrase("rings_exchanged", "base and platform are exchanged")
    yield _hypothesis(_RINGS, exchanged, _exchanged(_RINGS, _whole))
    if machine.home.z_mm != 0.0:
        yield _hypothesis(_RINGS, phrase("home_below", "home is upside down"), _home_below)


def of_bars(case: Case, bars: Bars) -> Iterator[Hypothesis]:
    """Hypotheses about the ends of bars; those that exchange all lower and upper ones are the sense of the sensors."""
    del bars
    yield from _of_set(case, _BARS)


def _hypothesis(of: _Set, words: Phrase, edit: Edit, mistakes: float = 1.0, single: bool = False) -> Hypothesis:
    return Hypothesis(family=of.family, words=words, edit=edit, place="case", mistakes=mistakes, single=single)


def _of_set(case: Case, of: _Set) -> Iterator[Hypothesis]:
    first, second = of.joints(case)
    for say, change, weight in READINGS:
        for key, name, joints in zip(of.keys, of.names, (first, second), strict=True):
            if change(joints) is not None:
                yield _hypothesis(of, say(name), _changed(of, (key,), change), weight)
        if change(first) is not None and change(second) is not None:
            yield _hypothesis(of, say(of.both), _changed(of, of.keys, change), 1.2 * weight)
    for between, exchange in EXCHANGES:
        if exchange(first, second) is not None:
            yield _hypothesis(of, between(*of.names), _exchanged(of, exchange))
    for key, name in zip(of.keys, of.names, strict=True):
        for one, other in combinations(range(6), 2):
            pair = phrase("pair", "{one} and {other}", one=one + 1, other=other + 1)
            words = phrase("exchanged", "{what} {pairs} are exchanged", what=name, pairs=pair)
            yield _hypothesis(of, words, _changed(of, (key,), _swapped(one, other)), single=of.table == "machine")
        for shift in range(1, 6):
            words = phrase(
                "counted_from", "{what} are counted from another one ({first} is 1)", what=name, first=shift + 1
            )
            yield _hypothesis(of, words, _changed(of, (key,), _shifted(shift)), 1.3)


def _changed(of: _Set, keys: tuple[str, ...], change: Change) -> Edit:
    def edit(case: Case) -> Case:
        before = dict(zip(of.keys, of.joints(case), strict=True))
        after = {key: change(before[key]) for key in keys}
        return of.changed(case, **{key: joints for key, joints in after.items() if joints is not None})

    return edit


def _exchanged(of: _Set, exchange: Exchange) -> Edit:
    def edit(case: Case) -> Case:
        after = exchange(*of.joints(case))
        return case if after is None else of.changed(case, **dict(zip(of.keys, after, strict=True)))

    return edit


def _half_angle(value: Callable[[float], float]) -> Change:
    """Another half-angle of joints that are drawn in pairs."""

    def changed(joints: Joints) -> Joints | None:
        ring = joints.ring
        if ring is None or ring.angles_deg is not None:
            return None
        if ring.half_angle_deg is not None:
            key, angle = "half_angle_deg", value(ring.half_angle_deg)
        else:
            assert ring.included_angle_deg is not None  # one of the two
            key, angle = "included_angle_deg", 2.0 * value(ring.included_angle_deg / 2.0)
        return Joints(ring=ring.model_copy(update={key: angle})) if 0.0 < angle < 2.0 * BETWEEN else None

    return changed


def _scaled(factor: float) -> Change:
    """Joints at another radius."""

    def changed(joints: Joints) -> Joints | None:
        if joints.ring is not None:
            return Joints(ring=joints.ring.model_copy(update={"radius_mm": factor * joints.ring.radius_mm}))
        return _of_points(joints.points * [factor, factor, 1.0])

    return changed


def _on_the_other_side(joints: Joints) -> Joints | None:
    """Joints as far below as they were above."""
    if not np.any(joints.points[:, 2]):
        return None
    if joints.ring is not None:
        return Joints(ring=joints.ring.model_copy(update={"z_mm": -joints.ring.z_mm}))
    return _of_points(joints.points * [1.0, 1.0, -1.0])


def _turned(angle: float) -> Change:
    """Joints turned about z by an angle [deg]."""

    def changed(joints: Joints) -> Joints:
        ring = joints.ring
        if ring is None:
            cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
            return _of_points(joints.points @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]))
        key = "pair_centres_deg" if ring.angles_deg is None else "angles_deg"
        directions = tuple(float(round(d + angle, 3)) for d in getattr(ring, key))
        return Joints(ring=ring.model_copy(update={key: directions}))

    return changed


def _of_points(points: np.ndarray) -> Joints:
    """Joints at points, shape (6, 3) [m]."""
    rows = tuple(tuple(float(f"{value / MM:.9g}") for value in point) for point in points)
    return Joints(points_mm=rows)


def _in_order(joints: Joints, order: Sequence[int]) -> Joints:
    """The same joints in another order, on a ring by their directions."""
    if joints.ring is None:
        return _of_points(joints.points[list(order)])
    ring = joints.ring
    directions = tuple(float(f"{d:.9g}") for d in np.degrees(ring.angles)[list(order)])
    return Joints(ring=Ring(radius_mm=ring.radius_mm, angles_deg=directions, z_mm=ring.z_mm))


def _swapped(one: int, other: int) -> Change:
    order = list(range(6))
    order[one], order[other] = other, one
    return lambda joints: _in_order(joints, order)


def _shifted(shift: int) -> Change:
    """Joints counted from another one, in pairs where they were drawn so."""

    def changed(joints: Joints) -> Joints:
        ring = joints.ring
        if ring is not None and ring.pair_centres_deg is not None:
            points, (pairs, odd) = np.roll(joints.points, -shift, axis=0), divmod(shift, 2)
            centres = np.roll(ring.pair_centres_deg, -pairs)
            update = {"pair_centres_deg": tuple(float(c) + BETWEEN * odd for c in centres)}
            other = Joints(ring=ring.model_copy(update=update))
            mirrored = _half_angle(lambda angle: BETWEEN - angle)(other) if odd else other
            if mirrored is not None and np.abs(mirrored.points - points).max() < TOLERANCE_MM * MM:
                return mirrored
        return _in_order(joints, [(k + shift) % 6 for k in range(6)])

    return changed


def _one(code: str, english: str) -> Callable[[Phrase], Phrase]:
    return lambda what: phrase(code, english, what=what)


def _two(code: str, english: str) -> Callable[[Phrase, Phrase], Phrase]:
    return lambda first, second: phrase(code, english, first=first, second=second)


READINGS: tuple[tuple[Callable[[Phrase], Phrase], Change, float], ...] = (
    (
        _one("half_angle_other_way", "the half-angle of the {what} is measured the other way"),
        _half_angle(lambda angle: BETWEEN - angle),
        1.0,
    ),
    (
        _one("half_angle_full", "the half-angle of the {what} is the full angle"),
        _half_angle(lambda angle: angle / 2.0),
        1.0,
    ),
    (
        _one("half_angle_full_other_way", "the half-angle of the {what} is the full angle, measured the other way"),
        _half_angle(lambda angle: BETWEEN - angle / 2.0),
        1.5,
    ),
    (
        _one("half_angle_half", "the half-angle of the {what} is half of it"),
        _half_angle(lambda angle: 2.0 * angle),
        1.0,
    ),
    (_one("radius_full", "the radius of the {what} is a diameter"), _scaled(0.5), 1.0),
    (_one("radius_half", "the radius of the {what} is half of it"), _scaled(2.0), 1.0),
    (_one("other_side", "the {what} are on the other side of the origin along z"), _on_the_other_side, 1.0),
    (_one("turned_60", "the {what} are turned by 60 deg"), _turned(BETWEEN), 1.2),
    (_one("turned_back_60", "the {what} are turned by -60 deg"), _turned(-BETWEEN), 1.2),
    (_one("turned_180", "the {what} are turned by 180 deg"), _turned(3.0 * BETWEEN), 1.2),
)  # fmt: skip
"""What engineers take for something else in a drawing of six joints; words are of the joints."""


def _of_two(*keys: str) -> Exchange:
    """Keys of two rings, each with the value of the other."""

    def exchanged(first: Joints, second: Joints) -> tuple[Joints, Joints] | None:
        one, other = first.ring, second.ring
        if one is None or other is None or any(getattr(ring, key) is None for key in keys for ring in (one, other)):
            return None
        if all(getattr(one, key) == getattr(other, key) for key in keys):
            return None
        swapped = (
            own.model_copy(update={key: getattr(foreign, key) for key in keys})
            for own, foreign in ((one, other), (other, one))
        )
        return Joints(ring=next(swapped)), Joints(ring=next(swapped))

    return exchanged


def _whole(first: Joints, second: Joints) -> tuple[Joints, Joints]:
    return second, first


def _heights(first: Joints, second: Joints) -> tuple[Joints, Joints] | None:
    low, high = first.points, second.points
    if np.array_equal(low[:, 2], high[:, 2]):
        return None
    if first.ring is not None and second.ring is not None:
        return _of_two("z_mm")(first, second)
    return (
        _of_points(np.column_stack([low[:, :2], high[:, 2]])),
        _of_points(np.column_stack([high[:, :2], low[:, 2]])),
    )


EXCHANGES: tuple[tuple[Callable[[Phrase, Phrase], Phrase], Exchange], ...] = (
    (_two("radii_exchanged", "the radii of {first} and {second} are exchanged"), _of_two("radius_mm")),
    (_two("half_angles_exchanged", "the half-angles of {first} and {second} are exchanged"), _of_two("half_angle_deg")),
    (
        _two("radii_half_angles_exchanged", "radii and half-angles of {first} and {second} are exchanged"),
        _of_two("radius_mm", "half_angle_deg"),
    ),
    (_two("heights_exchanged", "the heights of {first} and {second} are exchanged"), _heights),
)


def _home_below(case: Case) -> Case:
    assert case.machine is not None
    assert case.hexapod is not None
    home = case.hexapod.home
    home = home.model_copy(update={"z_mm": -home.z_mm})
    return case.model_copy(update={"machine": case.machine.model_copy(update={"home": home})})


def of_turned_bars(angle: float, mistakes: float, std: float | None = None) -> Hypothesis:
    """All bars are turned about z by an angle; std: its standard deviation [deg]."""
    words = phrase("bars_turned", "the bars are turned by {angle} deg about z", angle=number(angle, std, 4))
    return _hypothesis(_BARS, words, _changed(_BARS, _BARS.keys, _turned(angle)), mistakes)
