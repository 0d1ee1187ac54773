"""Hexapods drawn from a seed: machines that no planner was tuned on."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.base.errors import InfeasiblePlan
from cases.schema import Case
from identification.machines.hexapod import Hexapod as Kinematics
from planner.search.feasibility import require_rest
from tests.bench.machines.description import Hexapod, Range, case_of, reachable
from tests.helpers import pose_shares

LARGEST_ANGLES = (40.0, 40.0, 60.0)  # [deg] of a, b and c, however far struts and joints let them go
WIDEST_JOINT = 85.0  # [deg]
STEPS = 100  # in which the stroke of an axis is searched
HOME = 0.85  # largest share of a limit of poses that home may use
LEAST_REACHABLE = 0.05  # of the box
MACHINE = ("strut length", "joint angle", "singularity")  # limits of poses, keep-out boxes apart


def drawn(seed: int) -> Hexapod:
    """A valid machine, the same for the same seed: geometry, struts, a box of single-axis strokes, limits, sensors.

    What is drawn is drawn again where home is near a limit, a keep-out box is in the way or too little is reachable.
    """
    draw = np.random.default_rng(seed)
    while True:
        hexapod = _with_box(draw, _without_box(draw, f"Drawn from seed {seed}"))
        if hexapod is None:
            continue
        case = case_of("drawn", hexapod)
        try:
            require_rest(case)
        except InfeasiblePlan:
            continue
        if reachable(case, 1000).all_limits >= LEAST_REACHABLE:
            return hexapod


def _between(draw: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform, to three digits."""
    return _short(float(np.exp(draw.uniform(np.log(low), np.log(high)))))


def _short(value: float) -> float:
    return float(f"{value:.3g}")


def _without_box(draw: np.random.Generator, title: str) -> Hexapod:
    """Geometry, struts and sensors; the box and its limits are placeholders."""
    base = _between(draw, 100.0, 1500.0)
    platform = _short(base * draw.uniform(0.4, 0.95))
    height = _short(base * _between(draw, 0.6, 3.5))
    off_centre = draw.random() < 1 / 3
    places = draw.uniform(-1.0, 1.0, 5) * off_centre * (0.15 * base, 0.15 * base, 6.0, 6.0, 15.0)
    x, y, a, b, c = (_short(place) + 0.0 for place in places)  # and no -0.0
    mass = _short(400.0 * (platform * 1e-3) ** 2 * _between(draw, 0.3, 3.0))
    transducer = draw.random() < 1 / 4
    hexapod = Hexapod(
        title=title,
        base=(base, _short(draw.uniform(6.0, 20.0))),
        platform=(platform, _short(60.0 - draw.uniform(6.0, 20.0))),
        home=(x, y, height, a, b, c),
        struts=(0.1 * height, 10.0 * (height + base)),
        box=(1.0,) * 6,
        rates=(1.0, 1.0),
        accelerations=(1.0, 1.0),
        jerks=(1.0, 1.0),
        drives=(1.0, 1.0),
        joints=(90.0, 90.0),
        frame=None if transducer else tuple(_short(platform * share) for share in (0.55, 0.64, 0.44)),
        range_N=_short(9.81 * mass * _between(draw, 0.8, 4.0) * (2.0 if transducer else 1.0)),
        mass=mass,
        height=_short(platform * draw.uniform(0.2, 0.8)),
        gyration=_short(platform * draw.uniform(0.3, 0.7)),
        payloads=(_short(0.3 * mass),) * int(draw.integers(0, 3)),
        cycle_ms=float(draw.choice([1.0, 2.0, 4.0])),
        hangs=bool(draw.random() < 1 / 5),
    )
    kinematics = Kinematics.of(case_of("drawn", hexapod))
    lengths = 1e3 * kinematics.strut_lengths(kinematics.home[None])[0]
    stroke = lengths.mean() * draw.uniform(0.25, 0.6)
    shortest = lengths.min() - stroke * draw.uniform(0.3, 0.7)
    at_base, at_platform = (
        float(np.degrees(np.arccos(cosines.full().min()))) for cosines in kinematics.joint_cosines(kinematics.home)
    )
    return replace(
        hexapod,
        struts=(_short(shortest), _short(shortest + np.ptp(lengths) + stroke)),
        joints=(
            _short(min(at_base + draw.uniform(15.0, 40.0), WIDEST_JOINT)),
            _short(min(at_platform + draw.uniform(20.0, 50.0), WIDEST_JOINT)),
        ),
    )


def _with_box(draw: np.random.Generator, hexapod: Hexapod) -> Hexapod | None:
    """The machine with a box of shares of single-axis strokes and limits of its scale; None where home is not free."""
    strokes = _strokes(case_of("drawn", hexapod))
    if strokes is None:
        return None
    shares = draw.uniform(0.3, 0.95, 6)
    box = tuple((_short(share * low), _short(share * high)) for share, (low, high) in zip(shares, strokes, strict=True))
    length = 1e-3 * float(np.mean([high - low for low, high in box[:3]]))  # [m]
    angle = float(np.mean([high - low for low, high in box[3:]]))  # [deg]
    crossing = _between(draw, 0.2, 1.5)  # seconds at full velocity through the box
    rise, jerk_rise = _between(draw, 0.06, 0.3), _between(draw, 0.03, 0.1)  # seconds to full velocity and acceleration
    velocity, rate = min(length / crossing, 1.0), min(angle / crossing, 120.0)
    acceleration, angular = min(velocity / rise, 10.0), min(np.radians(rate) / rise, 30.0)
    weak = _between(draw, 0.5, 2.0)  # drives, in units of the platform's limits
    hexapod = replace(
        hexapod,
        box=box,
        rates=(_short(1e3 * velocity), _short(rate)),
        accelerations=(_short(acceleration), _short(angular)),
        jerks=(_short(acceleration / jerk_rise), _short(angular / jerk_rise)),
        drives=(_short(weak * velocity), _short(weak * acceleration)),
    )
    return _beside_a_box(draw, hexapod) if draw.random() < 1 / 4 else hexapod


def _strokes(case: Case) -> list[Range] | None:
    """How far each coordinate may go alone [mm, deg]; None where home comes too near a limit of poses."""
    home = case.need_machine("strokes of single axes")[0].home.vector
    if of_poses(case, home[None])[0] > HOME:
        return None
    farthest = [float(np.ptp(case.workspace.strut_length))] * 3 + [float(np.radians(d)) for d in LARGEST_ANGLES]
    units = [1e3] * 3 + [180.0 / np.pi] * 3
    strokes = []
    for axis, (most, unit) in enumerate(zip(farthest, units, strict=True)):
        ends = []
        for sign in (-1.0, 1.0):
            ways = sign * most * np.arange(1, STEPS + 1) / STEPS
            poses = np.tile(home, (STEPS, 1))
            poses[:, axis] += ways
            kept = of_poses(case, poses) <= 1.0
            free = STEPS if kept.all() else int(np.argmin(kept))
            ends.append(unit * ways[max(free - 1, 0)])
        strokes.append((ends[0], ends[1]))
    return strokes


def of_poses(case: Case, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest share of a limit of poses that each pose uses, keep-out boxes apart, shape (n,)."""
    shares = pose_shares(case, poses)
    return np.asarray(np.max([shares[kind].max(axis=1) for kind in MACHINE], axis=0))


def _beside_a_box(draw: np.random.Generator, hexapod: Hexapod) -> Hexapod:
    """The machine beside a box that the platform reaches somewhere in its stroke along x."""
    x, y, z = hexapod.home[:3]
    (_, stroke), radius = hexapod.ranges[0], hexapod.platform[0]
    near = x + radius + _short(stroke * draw.uniform(0.3, 0.9)) + hexapod.strut_radius
    wall = ((near, near + radius), (y - radius, y + radius), (0.9 * z, 1.5 * z))
    return replace(hexapod, keep_out=(("neighbour", tuple((_short(low), _short(high)) for low, high in wall)),))
