"""Joints of a hexapod that are numbered otherwise than its struts.

Where the joints of base and platform are mirrored by the same planes, some numbering gives all struts one length at
home. Another numbering of the same joints has struts that run the same way round, or across, and several lengths.
"""

import math
from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from cases.base.errors import Write
from cases.base.phrases import Phrase, phrase
from cases.base.units import DEG, MM, Array
from cases.contradictions import Doubt
from cases.machine import HexapodMachine, Joints, Pose, turned

ALIKE = 0.01  # share of the radius within which joints lie on one circle in one plane, and angles [rad]
AS_LONG = 2e-3  # spread of lengths of one length, as a share: of drawings whose points are rounded
APART = 5e-3  # spread of lengths from which struts have several
_PLACE = "machine.platform"
Order = NDArray[np.intp]


class _Hexagon(NamedTuple):
    """Six joints on a circle about z, mirrored by three planes."""

    order: Order  # numbers of the joints, counter-clockwise
    mirror: float  # direction of one of the planes [rad], of others by 60 degrees


def of_numbering(machine: HexapodMachine) -> Iterator[Doubt]:
    """A doubt about struts of several lengths at home where another numbering of the platform's joints gives one."""
    arms = machine.platform.points @ turned(machine.home.vector[3:]).T
    base, platform = _hexagon(machine.base.points), _hexagon(arms)
    beside = np.hypot(*machine.home.vector[:2]) > ALIKE * np.hypot(*machine.base.points[0, :2])
    if base is None or platform is None or beside:
        return
    turn = (platform.mirror - base.mirror) % (math.pi / 3.0)
    lengths = _lengths(machine, machine.platform.points)
    if min(turn, math.pi / 3.0 - turn) > ALIKE or np.ptp(lengths) < APART * lengths.mean():
        return
    numbered = [found for order in _orders(base, platform) if (found := _numbered(machine, order)) is not None]
    if numbered:
        corrected, words, new = min(numbered, key=lambda found: _lengths(found[0], found[0].platform.points).sum())
        table = _PLACE.split(".") if machine.platform.ring is None else [*_PLACE.split("."), "ring"]
        writes = [Write((*table, key), value) for key, value in new.items()]
        sentence = phrase(
            "joints_numbered",
            "{place}: struts are {short} to {long} mm long at home, though the joints of base and platform lie "
            "symmetric; strut k joins joint k of both: with {keys} all are {equal} mm long; write that, unless the "
            "drawing has several lengths",
            place=_PLACE,
            short=f"{lengths.min() / MM:.2f}",
            long=f"{lengths.max() / MM:.2f}",
            keys=words,
            equal=f"{_lengths(corrected, corrected.platform.points).mean() / MM:.2f}",
        )
        keys = _keys(machine.platform)
        alike = {f"{'.'.join(table)}.{key}" for key in new} <= set(keys)  # else keys of another form have to go
        yield Doubt.on(sentence, keys, writes if alike else ())


def _keys(joints: Joints) -> list[str]:
    if joints.ring is None:
        return [f"{_PLACE}.points_mm"]
    keys = ("half_angle_deg", "included_angle_deg", "pair_centres_deg", "angles_deg")
    return [f"{_PLACE}.ring.{key}" for key in keys if getattr(joints.ring, key) is not None]


def _hexagon(points: Array) -> _Hexagon | None:
    """Joints as a mirrored hexagon about z; None where they are not one. Points have shape (6, 3) [m]."""
    radii, angles = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
    radius = float(radii.mean())
    order = np.argsort(angles)
    gaps = np.diff(angles[order], append=angles[order[0]] + 2.0 * math.pi)
    even = max(float(np.ptp(gaps[k::2])) for k in (0, 1))
    if even > ALIKE or max(float(np.ptp(radii)), float(np.ptp(points[:, 2]))) > ALIKE * radius:
        return None
    return _Hexagon(order, float(angles[order[0]] + gaps[0] / 2.0))


def _lengths(machine: HexapodMachine, platform: Array) -> Array:
    """Lengths of the struts at home, shape (6,) [m], with joints of the platform in {P}, shape (6, 3) [m]."""
    arms = platform @ turned(machine.home.vector[3:]).T
    return np.asarray(np.linalg.norm(machine.home.vector[:3] + arms - machine.base.points, axis=1))


def _orders(base: _Hexagon, platform: _Hexagon) -> Iterator[Order]:
    """Joints of the platform for struts 1 to 6: those in turn, from each joint on, either way round."""
    for way, first in product((1, -1), range(6)):
        order = np.empty(6, dtype=np.intp)
        order[base.order] = platform.order[(first + way * np.arange(6)) % 6]
        yield order


def _numbered(machine: HexapodMachine, order: Order) -> tuple[HexapodMachine, Phrase | str, dict[str, Any]] | None:
    """The machine with joints of the platform in another order, how to write it in words, and by keys; None where
    struts are not of one length then, or do not hold the platform.
    """
    points = machine.platform.points[order]
    lengths = _lengths(machine, points)
    if np.ptp(lengths) > AS_LONG * lengths.mean():
        return None
    ring = machine.platform.ring
    if ring is None:
        listed = [machine.platform.points_mm[k] for k in order] if machine.platform.points_mm is not None else []
        numbers = ", ".join(str(k + 1) for k in order)
        words: Phrase | str = phrase("points_in_order", "its points in the order {numbers}", numbers=numbers)
        new: dict[str, Any] = {"points_mm": [list(point) for point in listed]}
        content: dict[str, Any] = dict(new)
    else:
        stated = {"radius_mm": ring.radius_mm, "z_mm": ring.z_mm}
        angles = ring.angles[order] / DEG
        half = ((angles[1::2] - angles[::2]) % 360.0) / 2.0
        paired = ring.pair_centres_deg is not None and float(np.ptp(half)) < 1e-9 and 0.0 < half[0] < 90.0
        if paired:
            key = "half_angle_deg" if ring.included_angle_deg is None else "included_angle_deg"
            size = _rounded(half[0] * (1.0 if ring.included_angle_deg is None else 2.0))
            centres = [_rounded(angle) for angle in (angles[::2] + half) % 360.0]
            new = {key: size, "pair_centres_deg": centres}
        else:
            new = {"angles_deg": [_rounded(angle) for angle in angles % 360.0]}
        words = ", ".join(f"{key} = {value}" for key, value in new.items())
        content = {"ring": {**stated, **new}}
    try:
        home = Pose.model_validate(machine.home.model_dump())
        again = HexapodMachine(base=machine.base, platform=Joints.model_validate(content), home=home)
    except ValidationError:
        return None
    return again, words, new


def _rounded(angle: float) -> float:
    """An angle in degrees without what arithmetic left behind its ninth digit; 0 instead of 360."""
    return float(f"{angle:.9g}") % 360.0
