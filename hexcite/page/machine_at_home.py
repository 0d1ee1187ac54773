"""A machine standing at home, while its values are typed: its scene in 3-D, and what it comes closest to there."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.base.units import MM
from cases.chain import Chain, Joint
from cases.schema import Case
from cases.urdf import LinkPlace
from hexcite.reports.drawing.chart import COLOURS
from hexcite.reports.drawing.scene import (
    BASE,
    Label,
    Part,
    Scene,
    drawn_pose,
    shown_alone,
    standing_chain,
    standing_machine,
)
from identification.limits.chain import body_clearances, chain_frames
from identification.limits.hexapod import LimitedHexapod
from identification.limits.limit import LimitKind, Quantity
from identification.motion.motion import StandingPoses

AT_HOME = "of det J^-1 at home"  # end of the unit of what counts from home
CLOSE = 0.9  # share of a limit from which it is marked
MOST_ROWS = 6
TURN = 180.0  # [deg] to either side of a joint without ends that a slider offers
SLIDE = 1000.0  # [mm] the same


@dataclass(frozen=True)
class Near:
    """What a machine comes closest to at home.

    Args:
        limit: its name.
        place: joint, strut or bodies.
        value: there; of distances what is left.
        unit: of both.
        ends: between which it has to stay; empty of distances.
        mark: "hit" where it is exceeded, "close", or "free".
    """

    limit: str
    place: str
    value: str
    unit: str
    ends: str
    mark: str


def scene_of(case: Case | None, chain: Chain | None) -> Scene | None:
    """The scene of a case, or of the chain of one that is not complete yet; None where there is neither."""
    if chain is not None:
        return standing_chain(chain)
    return None if case is None else standing_machine(case)


def near(case: Case | None, chain: Chain | None) -> tuple[Near, ...]:
    """What the machine at home comes closest to: a joint or strut of each limit of geometry, and bodies."""
    rows = []
    for quantity in _quantities(case, chain):
        kind = quantity.of.kind
        if kind.unit.endswith(AT_HOME):
            continue  # it is what it is compared with
        every = range(quantity.ratio.shape[1])
        for k in every if kind.least else [int(np.argmax(quantity.ratio[0]))]:
            label = quantity.labels[k] if quantity.labels else ""
            share, value = float(quantity.ratio[0, k]), float(quantity.values[0, k]) * kind.scale
            low, high = quantity.limits[:, k] * kind.scale
            mark = "hit" if share > 1.0 else "close" if share > CLOSE else "free"
            ends = "" if kind.least else f"{low:.4g} .. {high:.4g}"
            rows.append((share, Near(str(quantity.of), label, f"{value:.4g}", kind.unit, ends, mark)))
    return tuple(row for _, row in sorted(rows, key=lambda row: -row[0])[:MOST_ROWS])


def _quantities(case: Case | None, chain: Chain | None) -> Iterable[Quantity]:
    if chain is not None:
        still = StandingPoses(drawn_pose(chain)[None]).at([0.0])
        yield from _ends(chain, still.coordinates)
        yield from body_clearances(still.t, chain_frames(still, chain), chain)
    elif case is not None and case.limits is not None:
        machine = LimitedHexapod.of(case)
        still = StandingPoses(case.need_motion("the pose at home")[0][None]).at([0.0])
        yield from machine.ranges(still)
        yield from (quantity for quantity in machine.mechanics(still)[1] if not quantity.of.kind.kinetic)


def _ends(chain: Chain, pose: Any) -> Iterable[Quantity]:
    """Joints between their ends; those without ends have none."""
    turns = np.array([joint.turns for joint in chain.joints])
    ended = np.isfinite(chain.position).all(axis=0)
    for kind, of_kind in ((LimitKind.JOINT_POSITION, ended & ~turns), (LimitKind.JOINT_ANGLE, ended & turns)):
        if of_kind.any():
            names = tuple(name for name, k in zip(chain.names, of_kind, strict=True) if k)
            yield Quantity.between(kind, names, pose[:, of_kind], *chain.position[:, of_kind])


@dataclass(frozen=True)
class Slider:
    """A number of the form that is moved: of a joint at home, or one of the sensor's three angles.

    Args:
        field: name of the form's field that holds it, without `v.` or `w.`.
        item: its number in the field's list; -1 where the field is the number.
    """

    name: str
    field: str
    item: int
    low: float
    high: float
    value: float
    unit: str


def sliders(chain: Chain) -> tuple[Slider, ...]:
    """One a joint, between its ends."""
    return tuple(
        _slider(k, joint, value) for k, (joint, value) in enumerate(zip(chain.joints, drawn_pose(chain), strict=True))
    )


def _slider(k: int, joint: Joint, value: float) -> Slider:
    unit, way = ("deg", TURN) if joint.turns else ("mm", SLIDE)
    low, high = (end / joint.unit if np.isfinite(end) else np.sign(end) * way for end in joint.position)
    field = f"machine.chain.joints[{k}].home_{unit}"
    return Slider(joint.name, field, -1, float(low), float(high), round(float(value / joint.unit), 3), unit)


def sensor_angles(chain: Chain) -> tuple[Slider, ...]:
    """Of the sensor on the last joint: about x, then y, then z of that joint's frame, which stand still."""
    return tuple(
        Slider(axis, "machine.chain.sensor.rpy_deg", k, -180.0, 180.0, round(float(angle), 3), "deg")
        for k, (axis, angle) in enumerate(zip("xyz", chain.sensor.rpy_deg, strict=True))
    )


def chain_in(data: Mapping[str, Any]) -> Chain | None:
    """The chain of a case file that may lack all else; None where it has none that can be read."""
    from pydantic import ValidationError

    machine = data.get("machine")
    chain = machine.get("chain") if isinstance(machine, Mapping) else None
    if not isinstance(chain, Mapping):
        return None
    try:
        return Chain.model_validate(chain)
    except ValidationError:
        return None


def scene_of_links(links: Sequence[LinkPlace]) -> Scene:
    """The links of a URDF file with all joints at 0, each at its origin and joined to its parent."""
    points = {link.name: link.origin / MM for link in links}
    ways = tuple(
        (np.stack([points[link.parent], points[link.name]]), (BASE, BASE)) for link in links if link.parent in points
    )
    parts = (Part("links", ways, 6.0, COLOURS[0]),)
    labels = tuple(Label(link.name, points[link.name], BASE) for link in links)
    frames = np.eye(4)[None, None, :3]
    return shown_alone(Scene(False, np.zeros(1), frames, parts, np.zeros((3, 2)), labels))
