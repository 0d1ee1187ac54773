"""Values of a case that contradict each other, or that no machine has: figures of motion, loads, geometry and times.

What physics forbids altogether is an error of the case's tables, not a doubt.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cases.base.phrases import NOTHING, Phrase, phrase
from cases.base.units import DEG, MM, Array
from cases.chain import Chain, JointMotionLimits
from cases.contradictions import Doubt, Relation, Stated, Values, contradictions
from cases.machine import HexapodMachine, MotionLimits, Workspace, turned
from cases.sensors import RigidBody, SensorFrame, Sensors
from cases.tables import Vector

OFTEN, WIDELY, LOOSELY = 4.0, 6.0, 8.0  # factors by which figures of sound machines scatter
SOMEWHAT, HARDLY, NEVER = 2.0, 1.3, 1.1  # the same beyond limits
USUAL_RUN_UP = 0.3  # of a range, on the way to the largest velocity
DENSEST = 22_600.0  # [kg/m^3] of osmium
FASTEST, STRONGEST = 20.0, 500.0  # [m/s, m/s^2] of machines that carry sensors of force
SPINNING, WHIRLING = 100.0, 5_000.0  # [rad/s, rad/s^2]
MOST_TURN = 8.0 * math.pi  # [rad] end of a joint
TWO_TURNS = 4.0 * math.pi  # a number that is too small for degrees where all joints turn by less
LEAST_OF_PAIR, LEAST_OF_JOINT = 1.6, 4.0  # [deg] half-angles and angles of joints: smaller ones look like radians


def _largest(values: Values, key: str) -> float:
    return float(np.abs(values[key]).max())


def _reached(values: Values, v: str, a: str, j: str, unit: str) -> Relation:
    """The acceleration is one that velocity and jerk allow: it is built up before the velocity is reached."""
    acceleration = math.sqrt(_largest(values, v) * _largest(values, j))
    words = phrase(
        "velocity_jerk_allow",
        "velocity and jerk allow an acceleration of {size} {unit}",
        size=f"{acceleration:.3g}",
        unit=unit,
    )
    return Relation((a, v, j), _largest(values, a) / acceleration, 0.0, 1.0, SOMEWHAT, words)


def _run_up(values: Values, s: str, v: str, a: str) -> Relation:
    """The largest velocity is reached on a share of the range."""
    share = _largest(values, v) ** 2 / _largest(values, a) / _largest(values, s)
    words = phrase(
        "reached_on",
        "at that acceleration the velocity is reached on {share} % of the range",
        share=f"{100.0 * share:.2g}",
    )
    return Relation((v, a, s), share, USUAL_RUN_UP, USUAL_RUN_UP, LOOSELY, words)


def _at_most(values: Values, key: str, most: float, unit: str) -> Relation:
    size = _largest(values, key)
    words = phrase("more_than_any", "{size} {unit} is more than any such machine has", size=f"{size:.3g}", unit=unit)
    return Relation((key,), size / most, 0.0, 1.0, HARDLY, words)


Pair = tuple[str, str]


def _alike(values: Values, one: Pair, other: Pair, often: float) -> Relation:
    """Translation and rotation go together alike, as way, velocity, acceleration and jerk."""
    first, second = (_largest(values, pair[0]) / _largest(values, pair[1]) for pair in (one, other))
    words = phrase(
        "go_with",
        "{first} m go with 1 rad in the first two, {second} m in the others",
        first=f"{first:.3g}",
        second=f"{second:.3g}",
    )
    return Relation((*one, *other), first / second, 1.0, 1.0, often, words)


def of_motion(limits: MotionLimits, machine: HexapodMachine | None) -> Iterator[Doubt]:
    """Doubts about the box of a hexapod: translations, rotations and struts beside each other."""

    def stated(*keys: str) -> Stated:
        key = next(key for key in keys if getattr(limits, key) is not None)
        return Stated(f"limits.motion.{key}", np.array(getattr(limits, key)))

    def sides(letters: str, unit: str) -> Stated:
        names = [f"{letter}_{unit}" for letter in letters]
        widths = np.array([np.ptp(getattr(limits, name)) for name in names])
        return Stated(f"limits.motion.{', '.join(names)}", widths, phrase("with_widths", "with widths"))

    values = [
        sides("xyz", "mm"),
        sides("abc", "deg"),
        stated("velocity_mm_s"),
        stated("angular_velocity_deg_s"),
        stated("acceleration_m_s2"),
        stated("angular_acceleration_rad_s2", "angular_acceleration_deg_s2"),
        stated("jerk_m_s3"),
        stated("angular_jerk_rad_s3", "angular_jerk_deg_s3"),
        stated("strut_velocity_m_s"),
        stated("strut_acceleration_m_s2"),
    ]
    x, phi, v, omega, a, alpha, j, zeta, strut_v, strut_a = (value.key for value in values)
    jacobian = None if machine is None else _inverse_jacobian(machine)

    def relations(now: Values) -> Iterator[Relation]:
        yield _reached(now, v, a, j, "m/s^2")
        yield _reached(now, omega, alpha, zeta, "rad/s^2")
        yield _run_up(now, x, v, a)
        yield _run_up(now, phi, omega, alpha)
        yield _alike(now, (x, phi), (v, omega), OFTEN)
        yield _alike(now, (v, omega), (a, alpha), OFTEN)
        yield _alike(now, (a, alpha), (j, zeta), OFTEN)
        yield _alike(now, (v, omega), (j, zeta), WIDELY)
        yield _at_most(now, v, FASTEST, "m/s")
        yield _at_most(now, a, STRONGEST, "m/s^2")
        yield _at_most(now, omega, SPINNING, "rad/s")
        yield _at_most(now, alpha, WHIRLING, "rad/s^2")
        if jacobian is not None:
            for strut, pose, unit in ((strut_v, (v, omega), "m/s"), (strut_a, (a, alpha), "m/s^2")):
                need = float(np.abs(jacobian * np.hstack([now[key] for key in pose])).max())
                words = phrase(
                    "asked_of_strut",
                    "at home the platform's own limits ask {size} {unit} of a strut",
                    size=f"{need:.3g}",
                    unit=unit,
                )
                yield Relation((strut, *pose), _largest(now, strut) / need, 1.0, 1.0, WIDELY, words)

    yield from contradictions(values, relations)


def _inverse_jacobian(machine: HexapodMachine) -> Array:
    """Rates of the struts at home for those of the pose, turns about fixed axes, shape (6, 6) [-, m]."""
    arms = machine.platform.points @ turned(machine.home.vector[3:]).T
    struts = machine.home.vector[:3] + arms - machine.base.points
    along = struts / np.linalg.norm(struts, axis=1)[:, None]
    return np.hstack([along, np.cross(arms, along)])


def of_chain(chain: Chain, limits: JointMotionLimits) -> Iterator[Doubt]:
    """Doubts about a chain: each joint's limits beside each other, and beside those of other joints."""
    stated: dict[str, Stated] = {}
    keys = [[f"limits.motion.joints[{k}].{key}" for key in joint.keys] for k, joint in enumerate(limits.joints, 1)]
    for joint, own in zip(limits.joints, keys, strict=True):
        low, high = getattr(joint, joint.keys[0])
        stated[own[0]] = Stated(own[0], np.array(high - low), phrase("with_width", "with a width of"))
        for key, name in zip(own[1:], joint.keys[1:], strict=True):
            stated[key] = Stated(key, np.array(getattr(joint, name)))
    ends = dict[str, bool]()
    for k, end in enumerate(chain.joints, 1):
        if (position := end.position_deg or end.position_mm) is not None:
            key = f"machine.chain.joints[{k}].position_{'deg' if end.turns else 'mm'}"
            stated[key], ends[key] = Stated(key, np.array(position)), end.turns
    origins = [*chain.joints, chain.sensor]
    distances = np.array([np.linalg.norm(np.array(frame.origin_mm)) for frame in origins])
    stated[ORIGINS] = Stated(ORIGINS, distances, phrase("with_distances", "with distances"))

    def relations(now: Values) -> Iterator[Relation]:
        for joint, (s, v, a, j) in zip(limits.joints, keys, strict=True):
            yield _run_up(now, s, v, a)
            yield _reached(now, v, a, j, "rad/s^2" if joint.turns else "m/s^2")
            most = (SPINNING, WHIRLING) if joint.turns else (FASTEST, STRONGEST)
            yield _at_most(now, v, most[0], "rad/s" if joint.turns else "m/s")
            yield _at_most(now, a, most[1], "rad/s^2" if joint.turns else "m/s^2")
        for turns in (True, False):
            alike = [of_joint for joint, of_joint in zip(limits.joints, keys, strict=True) if joint.turns == turns]
            for order in (1, 2, 3) if len(alike) > 2 else ():
                usual = float(np.median([_largest(now, of_joint[order]) for of_joint in alike]))
                for key in (of_joint[order] for of_joint in alike):
                    times = f"{usual / _largest(now, key):.3g}"
                    words = phrase("other_joints", "other joints have {times} times as much", times=times)
                    yield Relation((key,), _largest(now, key) / usual, 1.0, 1.0, OFTEN, words)
        for key, turns in ends.items():
            size = _largest(now, key)
            if turns:
                turns_made = f"{size / 2 / math.pi:.3g}"
                words = phrase("many_turns", "{turns} turns are more than joints make", turns=turns_made)
                yield Relation((key,), size / MOST_TURN, 0.0, 1.0, HARDLY, words)
            else:
                yield _at_most(now, key, REACH, "m")
        turning = [key for key, turns in ends.items() if turns]
        if len(turning) > 2:  # of one alone a few degrees may be meant
            widest = float(np.median([_largest(now, key) for key in turning])) / DEG
            words = phrase("joints_turn_by", "most joints turn by {angle} deg at most", angle=f"{widest:.3g}")
            yield Relation(tuple(turning), widest, TWO_TURNS, math.inf, NEVER, words)
        reach = float(np.sum(now[ORIGINS]))
        words = phrase("origins_sum", "origins of joints add up to {size} m", size=f"{reach:.3g}")
        yield Relation((ORIGINS,), reach, LEAST_REACH, REACH, HARDLY, words)

    yield from contradictions(list(stated.values()), relations)


def of_links(chain: Chain) -> Iterator[Doubt]:
    """A doubt about links whose mass lies far from all of the link: its centre is counted from another frame."""
    ends = [np.array(frame.origin_mm) * MM for frame in (*chain.joints[1:], chain.sensor)]
    far = list[tuple[int, float, float]]()
    for k, (joint, end) in enumerate(zip(chain.joints, ends, strict=True), 1):
        if joint.link is not None:
            length, away = float(np.linalg.norm(end)), float(np.linalg.norm(np.array(joint.link.centre_of_gravity)))
            if away > MOST_OF_LINK * (length + LINK_AROUND):
                far.append((k, away, length))
    if far:
        number, away, length = max(far, key=lambda link: link[1] - link[2])
        keys = [f"machine.chain.joints[{k}].link.centre_of_gravity_mm" for k, _, _ in far]
        joints = ", ".join(chain.joints[k - 1].name for k, _, _ in far)
        sentence = phrase(
            "link_far",
            "link.centre_of_gravity_mm of {joints}: that of {name} lies {away} from its joint, the next frame "
            "{length}, as if it were counted from another frame; correct it, or take link away, and torque_Nm limits "
            "nothing",
            joints=joints,
            name=chain.joints[number - 1].name,
            away=_mm(away),
            length=_mm(length),
        )
        yield Doubt.on(sentence, keys)


MOST_OF_LINK, LINK_AROUND = 2.0, 0.2  # times the length of a link, and what is around it [m]


ORIGINS = "machine.chain.joints.origin_mm"
LEAST_REACH, REACH = 0.02, 60.0  # [m] sum of the distances of joints
LEAST_SIZE, SIZE = 0.002, 10.0  # [m] radius of gyration of a body, where nothing tells the machine's size


class Carried(NamedTuple):
    """What the sensors of a case carry."""

    bodies: Mapping[str, RigidBody]  # by their tables
    size: float | None  # of the part that carries them [m]; None where the case does not tell it
    frame: SensorFrame
    gravity: Array  # in {B}, shape (3,)
    turns: Sequence[Array]  # orientations of {P}, each (3, 3), in one of which the sensors bear the weight


def of_loads(carried: Carried, sensors: Sensors) -> Iterator[Doubt]:
    """Doubts about bodies beside the machine's size, and about sensors beside the weight that they carry."""
    stated = [
        Stated(f"{table}.{key}", np.array(getattr(body, key)))
        for table, body in carried.bodies.items()
        for key in ("mass_kg", "centre_of_gravity_mm", "inertia_kg_m2")
    ]
    keys = (RANGE, NOISE, "sensors.range_Nm", "sensors.moment_noise_Nm")
    of_sensors = {key: getattr(sensors, key.partition(".")[2]) for key in keys}
    stated += [Stated(key, np.array(value)) for key, value in of_sensors.items() if value is not None]

    def relations(now: Values) -> Iterator[Relation]:
        for table in carried.bodies:
            yield from _of_body(now, table, carried.size)
        for key in ("mass_kg", "inertia_kg_m2"):
            one, other = f"nominal.{key}", f"simulation.parameters.body.{key}"
            if one in now and other in now:
                ratio = _largest(now, one) / _largest(now, other)
                yield Relation((one, other), ratio, 1.0, 1.0, OFTEN, _times_the_other(ratio))
        for size, scatter in ((RANGE, NOISE), ("sensors.range_Nm", "sensors.moment_noise_Nm")):
            if size in now and scatter in now:
                part = float(now[scatter] / now[size])
                words = phrase("noise_of_range", "noise is {share} % of the range", share=f"{100.0 * part:.3g}")
                yield Relation((scatter, size), part, 0.0, 0.1, HARDLY, words)
        if "nominal.mass_kg" not in now:
            return
        mass = float(now["nominal.mass_kg"])
        if RANGE in now and carried.frame.struts is None:
            load = mass * _weighed(carried, now[CENTRE])
            words = phrase("weight_loads", "the body's weight alone loads a sensor with {load} N", load=f"{load:.3g}")
            yield Relation((RANGE, "nominal.mass_kg", CENTRE), load / float(now[RANGE]), 0.0, 1.0, NEVER, words)
        if NOISE in now:
            part = float(now[NOISE]) / float(np.linalg.norm(carried.gravity)) / mass
            words = phrase("noise_of_weight", "noise is {share} % of the body's weight", share=f"{100.0 * part:.3g}")
            yield Relation((NOISE, "nominal.mass_kg"), part, 0.0, 0.5, HARDLY, words)

    yield from contradictions(stated, relations)


RANGE, NOISE = "sensors.range_N", "sensors.force_noise_N"
CENTRE = "nominal.centre_of_gravity_mm"


def _weighed(carried: Carried, centre: Array) -> float:
    """Largest force on a channel by a kilogram somewhere in {P}, shape (3,) [m], in its best orientation [N/kg]."""

    def largest(turn: Array) -> float:
        weight = turn.T @ carried.gravity
        wrench = -np.hstack([weight, np.cross(centre, weight)])
        return float(
            np.abs(np.linalg.solve(carried.frame.structure, wrench)[: 3 if carried.frame.has_moments else 6]).max()
        )

    return min(map(largest, carried.turns))


def _of_body(now: Values, table: str, size: float | None) -> Iterator[Relation]:
    mass, centre, inertia = (f"{table}.{key}" for key in ("mass_kg", "centre_of_gravity_mm", "inertia_kg_m2"))
    m, i = float(now[mass]), now[inertia]
    moment = float(i[0] + i[3] + i[5]) / 2.0  # integral of the squared distance from the centre
    gyration, away = math.sqrt(moment / m), float(np.linalg.norm(now[centre]))
    ball = 0.6 * m * (0.75 * m / math.pi / DENSEST) ** (2.0 / 3.0)
    words = phrase(
        "too_dense",
        "no matter is dense enough for so small a body ({size} about its centre of gravity)",
        size=_mm(gyration),
    )
    yield Relation((inertia, mass), moment / ball, 1.0, math.inf, NEVER, words)
    low, high = (LEAST_SIZE, SIZE) if size is None else (size / 100.0, 10.0 * size)
    of = NOTHING if size is None else phrase("machine_size", ", the machine {size}", size=_mm(size))
    words = phrase("mass_lies", "mass lies {size} from its centre of gravity{machine}", size=_mm(gyration), machine=of)
    yield Relation((inertia, mass), gyration, low, high, HARDLY, words)
    words = phrase("it_lies", "it lies {size} from the origin of {{P}}{machine}", size=_mm(away), machine=of)
    yield Relation((centre,), away, 0.0, 10.0 * (SIZE if size is None else size), HARDLY, words)
    if 0.0 < away < MM and gyration > 20.0 * MM:  # nobody states tenths of a millimetre, but for 0
        words = phrase(
            "it_and_mass_lie",
            "it lies {size} from the origin of {{P}}, its mass {gyration} from it",
            size=_mm(away),
            gyration=_mm(gyration),
        )
        yield Relation((centre, inertia, mass), away / gyration, 0.05, 20.0, HARDLY, words)


def _times_the_other(ratio: float) -> Phrase:
    return phrase("times_the_other", "one is {times} times the other", times=f"{max(ratio, 1.0 / ratio):.3g}")


def _mm(length: float) -> str:
    return f"{length / MM:.4g} mm"


def of_geometry(machine: HexapodMachine | None, frame: SensorFrame, workspace: Workspace | None) -> Iterator[Doubt]:
    """Doubts about lengths and angles of joints, bars and struts, which look like metres or radians."""
    groups = [] if machine is None else [("machine.base", machine.base), ("machine.platform", machine.platform)]
    if frame.bars is not None:
        groups += [("sensor_frame.bars.lower", frame.bars.lower), ("sensor_frame.bars.upper", frame.bars.upper)]
    stated, angles, least = list[Stated](), list[Stated](), dict[str, float]()
    for table, joints in groups:
        if joints.ring is None:
            farthest = np.linalg.norm(np.array(joints.points_mm), axis=1).max()
            stated.append(
                Stated(
                    f"{table}.points_mm", np.array(farthest), phrase("at_most_from_origin", "at most from the origin")
                )
            )
            continue
        stated.append(Stated(f"{table}.ring.radius_mm", np.array(joints.ring.radius_mm)))
        for key in ("half_angle_deg", "included_angle_deg"):
            if (angle := getattr(joints.ring, key)) is not None:
                angles.append(Stated(f"{table}.ring.{key}", np.array(angle)))
                least[angles[-1].key] = LEAST_OF_PAIR
    if machine is not None:
        distance = np.linalg.norm(np.array([machine.home.x_mm, machine.home.y_mm, machine.home.z_mm]))
        straight = distance == abs(machine.home.z_mm)
        summary = NOTHING if straight else phrase("with_x_y", "with x and y, from the origin")
        stated.append(Stated("machine.home.z_mm", np.array(distance), summary))
    if workspace is not None:
        stated.append(Stated("workspace.strut_length_mm", np.array(workspace.strut_length_mm)))
        for key in ("base_joint_angle_deg", "platform_joint_angle_deg"):
            angles.append(Stated(f"workspace.{key}", np.array(getattr(workspace, key))))
            least[angles[-1].key] = LEAST_OF_JOINT

    def relations(now: Values) -> Iterator[Relation]:
        lengths = [value.key for value in stated]
        for key in lengths:
            size = _mm(_largest(now, key))
            words = phrase("too_small", "{size} is too small for a machine that carries sensors of force", size=size)
            yield Relation((key,), _largest(now, key), 5.0 * MM, math.inf, HARDLY, words)
        for one, other in pairwise(lengths):
            ratio = _largest(now, one) / _largest(now, other)
            yield Relation((one, other), ratio, 1.0, 1.0, WIDELY, _times_the_other(ratio))
        for angle in angles:
            degrees = _largest(now, angle.key) / DEG
            words = phrase("not_an_angle", "{angle} deg is not an angle of joints", angle=f"{degrees:.3g}")
            yield Relation((angle.key,), degrees, least[angle.key], 180.0, HARDLY, words)

    yield from contradictions([*stated, *angles], relations)


def of_times(stated: Mapping[str, float | None]) -> Iterator[Doubt]:
    """Doubts about rates and times, by the keys of `TIMES`; None where one is not stated."""
    statements = [Stated(key, np.array(value)) for key, value in stated.items() if value is not None]
    rate, cutoff = "recording.rate_Hz", "recording.filter_cutoff_Hz"
    block, cycle = "controller.block_ms", "controller.cycle_ms"

    def relations(now: Values) -> Iterator[Relation]:
        for key, value in now.items():
            low, high = TIMES[key]
            words = phrase("nobody_has", "no such controller or recorder has it")
            yield Relation((key,), float(value), low, high, HARDLY, words)
        if rate in now and cutoff in now:
            share = float(now[cutoff] / now[rate])
            words = phrase("half_the_rate", "half the rate is the highest frequency that samples hold")
            yield Relation((cutoff, rate), share, 0.0, 0.5, NEVER, words)
        if block in now and cycle in now:
            words = phrase("block_and_cycle", "a block lasts a cycle at least")
            yield Relation((block, cycle), float(now[block] / now[cycle]), 0.5, 1e4, HARDLY, words)

    yield from contradictions(statements, relations)


TIMES: Mapping[str, tuple[float, float]] = {
    "recording.rate_Hz": (0.5, 1e6),
    "recording.filter_cutoff_Hz": (0.01, 1e5),
    "controller.block_ms": (1e-4, 10.0),
    "controller.cycle_ms": (1e-5, 1.0),
    "controller.settle_s": (0.0, 60.0),
    "poses.settle_s": (0.0, 120.0),
    "poses.average_s": (1e-3, 120.0),
    "simulation.force_delay_ms": (0.0, 2.0),
}
"""Keys of times and rates, and what they have on machines [s, Hz]."""


def hardly_meant(chain: Chain | None, machine: HexapodMachine | None, gravity: Vector) -> Iterator[Phrase]:
    """Sentences on values that are sound on some machines, and a slip on most."""
    joints = () if chain is None else chain.joints
    without = [joint.name for joint in joints if joint.link is None]
    if without and any(joint.torque_Nm or joint.force_N for joint in joints):
        yield phrase(
            "torques_limit_nothing",
            "machine.chain.joints: torque_Nm and force_N limit nothing, for the link of {joints} is not stated; add "
            "its mass, centre of gravity and inertia",
            joints=", ".join(without),
        )
    if gravity[2] > 0.0:
        yield phrase(
            "gravity_points_up",
            "gravity_m_s2 = {value} points along +z of {{B}}; gravity points down: change its sign, unless the machine "
            "hangs",
            value=list(gravity),
        )
    if machine is not None and float(np.array(gravity) @ machine.home.vector[:3]) > 0.0:
        yield phrase(
            "platform_below_base",
            "machine.home.z_mm = {height}: the platform is below the base, as gravity_m_s2 = {value} points; change "
            "the sign of the height, unless the machine hangs",
            height=f"{machine.home.z_mm:g}",
            value=list(gravity),
        )
