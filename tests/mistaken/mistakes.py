"""Mistakes that people make with a recording or a case, each with words by which its cause is known again."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.machine import turned
from cases.schema import Case
from identification.recording.recording import Recording, read
from tests.mistaken.machines import WRIST, Run, machine, run, wrist_case

Array = NDArray[np.float64]
FILES = TemporaryDirectory()  # of the recordings that are read from a file
Wrong = tuple[Recording, Case]


@dataclass(frozen=True)
class Mistake:
    """One mistake: what it makes of a recording and its case, and a pattern of the words that name it.

    Args:
        of: what it concerns; two mistakes of one kind are not made at once.
        words: the pattern; # stands for a size, with or without its standard deviation.
        sizes: the true sizes.
    """

    name: str
    of: str
    make: Callable[[Run, Recording, Case], Wrong]
    words: str
    sizes: tuple[float, ...] = ()

    def named_in(self, text: str) -> bool:
        """Whether a sentence names it, with sizes that are right by the deviations which it states, if it states any.

        A size without a deviation is one of a convention, as 90 deg, and has to be the true one.
        """
        found = re.search(self.words.replace("#", SIZE), text)
        if found is None:
            return False
        stated = zip(found.groups()[::2], found.groups()[1::2], strict=True)
        return all(
            value is None or _as_stated(float(value), float(std or 0.0), true)
            for (value, std), true in zip(stated, self.sizes, strict=True)
        )


SIZE = r"(-?\d+(?:\.\d+)?)(?: ± (\d+(?:\.\d+)?))?"
FAR = 4.0  # standard deviations from the truth, within which a size is right
ROUNDED = 1e-6


def _as_stated(value: float, std: float, true: float) -> bool:
    away = (value - true + 180.0) % 360.0 - 180.0  # angles that differ by a turn are the same
    return abs(away) <= max(FAR * std, ROUNDED)


def mistakes_of(name: str) -> list[Mistake]:
    """The mistakes that can be made with a machine: of its case, those that its validation lets pass."""
    some = run(name, 0)
    possible = []
    for mistake in _every(name):
        with suppress(ValueError):
            mistake.make(some, some.recording, some.case)
            possible.append(mistake)
    return possible


def _every(name: str) -> list[Mistake]:
    if name == WRIST:
        return [*_channels(True), *_sensor(), *_wrist()]
    of = machine(name)
    if of.case.chain is not None:
        return [*_channels(True), *_sensor(), *_surroundings(True), *_joints(of.case), *_clock()]
    return [*_channels(False), *_surroundings(False), *_struts(), *_drawing(of.case), *_clock()]


def _forces(change: Callable[[Array], Array]) -> Callable[[Run, Recording, Case], Wrong]:
    return lambda run, recording, case: (replace(recording, forces=change(recording.forces)), case)


def _drives(change: Callable[[Array], Array]) -> Callable[[Run, Recording, Case], Wrong]:
    return lambda run, recording, case: (replace(recording, drives=change(recording.drives)), case)


def _in_case(change: Callable[[dict[str, Any]], None]) -> Callable[[Run, Recording, Case], Wrong]:
    def make(run: Run, recording: Recording, case: Case) -> Wrong:
        del run
        tables = case.model_dump(mode="json", exclude_defaults=True)
        change(tables)
        other = Case.model_validate(tables)
        return replace(recording, case=other), other

    return make


def _order(columns: Array, order: Sequence[int]) -> Array:
    return columns[:, list(order)]


def _swapped(one: int, other: int, count: int = 6) -> list[int]:
    order = list(range(count))
    order[one], order[other] = other, one
    return order


def _channels(moments: bool) -> Iterator[Mistake]:
    what = "force channels"
    pairs = ((0, 1), (1, 2), (3, 4)) if moments else ((0, 1), (0, 3), (2, 5))
    for one, other in pairs:
        order = _swapped(one, other)
        yield Mistake(
            f"channels {one + 1}-{other + 1} exchanged", "channels", _forces(lambda f, o=order: _order(f, o)),
            rf"{what} {one + 1} and {other + 1} are exchanged",
        )  # fmt: skip
    yield Mistake(
        "channels 1-2, 4-5 exchanged", "channels", _forces(lambda f: _order(f, [1, 0, 2, 4, 3, 5])),
        rf"{what} 1 and 2, 4 and 5 are exchanged",
    )  # fmt: skip
    if not moments:
        yield Mistake(
            "channels shifted", "channels", _forces(lambda f: np.roll(f, 1, axis=1)), rf"{what} are shifted by 1"
        )
    for k in (0, 2) if moments else (1, 4):
        signs = np.where(np.arange(6) == k, -1.0, 1.0)
        yield Mistake(
            f"sign of channel {k + 1}", "signs", _forces(lambda f, s=signs: f * s),
            rf"signs of force channels {k + 1} are turned",
        )  # fmt: skip
    every = r"signs of force channels 1, 2, 3, 4, 5, 6 are turned"
    yield Mistake("all signs", "signs", _forces(lambda f: -f), every)


def _sensor() -> Iterator[Mistake]:
    for axis, angle in (("z", 90.0), ("z", 180.0), ("z", 30.0), ("z", -72.0), ("x", 180.0), ("y", -90.0)):
        turn = np.kron(np.eye(2), Rotation.from_euler(axis, angle, degrees=True).as_matrix())
        yield Mistake(
            f"sensor turned {angle:g} about {axis}", "sensor", _forces(lambda f, m=turn: f @ m),
            rf"the sensor is turned by # deg about its {axis} axis", (angle,),
        )  # fmt: skip


def _surroundings(moments: bool) -> Iterator[Mistake]:
    for word, vector in (("-x", (-9.81, 0.0, 0.0)), ("+z", (0.0, 0.0, 9.81))):
        # the machine hangs as the case does not say: the case has gravity along another axis than it acts
        yield Mistake(
            f"gravity {word} in the case", "gravity", _in_case(lambda t, v=vector: t.update(gravity_m_s2=list(v))),
            r"gravity points along -z of \{B\}",
        )  # fmt: skip
    slope = (0.0, 9.81 * np.sin(np.radians(25.0)), -9.81 * np.cos(np.radians(25.0)))
    yield Mistake(
        "slope of 25 deg", "gravity", _in_case(lambda t: t.update(gravity_m_s2=list(slope))),
        r"gravity points (?:# deg away|along -z of)", (25.0,),
    )  # fmt: skip
    yield Mistake(
        "compensated", "gravity", lambda run, r, c: (replace(r, forces=r.forces - _weight_as(run, r)), c),
        r"the forces are compensated",
    )  # fmt: skip
    if moments:
        yield Mistake(
            "axes of the base", "axes", lambda run, r, c: (replace(r, forces=_in_base(run, r.forces)), c),
            r"in the axes of the base",
        )  # fmt: skip
        yield Mistake(
            "40 % compensated", "gravity", lambda run, r, c: (replace(r, forces=r.forces - 0.4 * run.weight), c),
            r"they lack # % of the weight", (40.0,),
        )  # fmt: skip
        yield Mistake(
            "moments about the tool", "point", _forces(lambda f: _about(f, np.array([0.02, -0.03, 0.14]))),
            r"about a point \(#, #, #\) mm", (20.0, -30.0, 140.0),
        )  # fmt: skip


def _about(forces: Array, point: Array) -> Array:
    """Moments about a point that is fixed in the sensor."""
    return np.hstack([forces[:, :3], forces[:, 3:] - np.cross(point, forces[:, :3])])


def _weight_as(run: Run, recording: Recording) -> Array:
    """The weight as a recorder has it that exchanged or turned what it recorded: compensation comes first."""
    del recording
    return run.weight


def _in_base(run: Run, forces: Array) -> Array:
    vectors = forces.reshape(-1, 2, 3)
    return np.einsum("nij,nbj->nbi", run.turns, vectors).reshape(-1, 6)


def _wrist() -> Iterator[Mistake]:
    yield Mistake(
        "axes of the base", "axes", lambda run, r, c: (replace(r, forces=_in_base(run, r.forces)), c),
        r"in the axes of the base",
    )  # fmt: skip
    for sequence, name in (
        ("ZYX", "zyx intrinsic"),
        ("XYZ", "xyz intrinsic"),
        ("ZYZ", "zyz intrinsic"),
        ("", "rotation vector"),
    ):

        def make(run: Run, recording: Recording, case: Case, sequence: str = sequence) -> Wrong:
            true = Rotation.from_matrix(run.turns)
            values = np.degrees(true.as_euler(sequence) if sequence else true.as_rotvec())
            file = Path(FILES.name) / f"{sequence or 'vector'}.csv"
            rows, names = np.hstack([values, recording.forces]), ("A", "B", "C", *case.sensor_frame.channels)
            np.savetxt(file, rows, delimiter=",", header=",".join(names), comments="", fmt="%.9g")
            return read(file, case), case

        yield Mistake(f"orientation as {name}", "orientation", make, rf"orientations are written as '{name}'")
    yield Mistake(
        "orientation from base to sensor", "orientation",
        lambda run, r, c: (replace(r, rotations=r.rotations.transpose(0, 2, 1)), c),
        r"orientations are written as 'xyz extrinsic inverse'",
    )  # fmt: skip
    yield Mistake(
        "matrix transposed", "orientation",
        lambda run, r, c: (replace(r, rotations=r.rotations.transpose(0, 2, 1), case=_by_matrix()), _by_matrix()),
        r"orientations are written as 'matrix inverse'",
    )  # fmt: skip


def _by_matrix() -> Case:
    tables = wrist_case().model_dump(mode="json", exclude_defaults=True)
    tables["recording"]["columns"] = {}
    return Case.model_validate(tables)


def _joints(case: Case) -> Iterator[Mistake]:
    chain = case.chain
    assert chain is not None
    yield Mistake(
        "sensor 70 mm off",
        "point",
        _in_case(_moved_sensor),
        r"about a point \(#, #, #\) mm",
        _from_moved(case),
    )
    count, turning = len(chain.joints), [k for k, joint in enumerate(chain.joints) if joint.turns]
    names = {k: rf"{k + 1} \({chain.joints[k].name}\)" for k in range(count)}
    alike = [(a, b) for a in turning for b in turning if a < b]
    sliding = [k for k in range(count) if k not in turning]
    alike += [(a, b) for a in sliding for b in sliding if a < b]
    for one, other in alike[:: max(1, len(alike) // 4)]:
        order = _swapped(one, other, count)
        yield Mistake(
            f"joints {one + 1}-{other + 1} exchanged", "joints", _drives(lambda q, o=order: _order(q, o)),
            rf"joints {names[one]} and {names[other]} are exchanged",
        )  # fmt: skip
    for k in (turning[len(turning) // 2], turning[-1]):
        signs = np.where(np.arange(count) == k, -1.0, 1.0)
        yield Mistake(
            f"joint {k + 1} turns the other way", "sign of joints", _drives(lambda q, s=signs: q * s),
            rf"joint {names[k]} turns the other way",
        )  # fmt: skip
    signs = np.where(np.isin(np.arange(count), turning), -1.0, 1.0)
    every = ", ".join(names[k] for k in turning)
    yield Mistake(
        "all joints that turn, the other way", "sign of joints", _drives(lambda q: q * signs),
        rf"joints {every} turn the other way",
    )  # fmt: skip
    turns = np.isin(np.arange(count), turning)
    which = "joints" if turns.all() else "joints that turn"
    yield Mistake(
        "joints in rad",
        "unit of joints",
        _drives(lambda q: np.where(turns, q * np.pi / 180.0, q)),
        rf"{which} are in rad",
    )
    for k, angle in ((turning[1], 90.0), (turning[-1], 180.0), (turning[-1], 90.0)):
        offset = np.where(np.arange(count) == k, np.radians(angle), 0.0)
        # true = recorded + angle
        yield Mistake(
            f"joint {k + 1} off by {angle:g}", "offset of joints", _drives(lambda q, o=offset: q - o),
            rf"joint {names[k]} stands at # deg where it reads 0", (angle,),
        )  # fmt: skip


def _struts() -> Iterator[Mistake]:
    for one, other in ((0, 1), (0, 3), (2, 5)):
        order = _swapped(one, other)
        yield Mistake(
            f"struts {one + 1}-{other + 1} exchanged", "struts", _drives(lambda q, o=order: _order(q, o)),
            rf"struts {one + 1} and {other + 1} are exchanged",
        )  # fmt: skip
    yield Mistake("struts shifted", "struts", _drives(lambda q: np.roll(q, 1, axis=1)), r"struts are shifted by 1")


def _drawing(case: Case) -> Iterator[Mistake]:
    assert case.hexapod is not None

    def ring(part: str, which: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
        return lambda t: (t["machine"] if part == "machine" else t["sensor_frame"]["bars"])[which]["ring"]

    def times(
        of: Callable[[dict[str, Any]], dict[str, Any]], key: str, factor: float
    ) -> Callable[[dict[str, Any]], None]:
        return lambda t: of(t).update({key: factor * of(t)[key]})

    def other_way(of: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[dict[str, Any]], None]:
        return lambda t: of(t).update(half_angle_deg=60.0 - of(t)["half_angle_deg"])

    names = {
        ("machine", "base"): "joints of the base", ("machine", "platform"): "joints of the platform",
        ("bars", "lower"): "lower ends of the bars", ("bars", "upper"): "upper ends of the bars",
    }  # fmt: skip
    for (part, which), words in names.items():
        of, kind = ring(part, which), f"{part} {which}"
        yield Mistake(
            f"{kind}: half-angle the other way",
            kind,
            _in_case(other_way(of)),
            rf"half-angle of the {words} is measured the other way",
        )
        if 2.0 * of(case.model_dump())["half_angle_deg"] < 58.0:
            yield Mistake(
                f"{kind}: full angle",
                kind,
                _in_case(times(of, "half_angle_deg", 2.0)),
                rf"half-angle of the {words} is the full angle",
            )
        yield Mistake(
            f"{kind}: diameter", kind, _in_case(times(of, "radius_mm", 2.0)), rf"radius of the {words} is a diameter"
        )
        if of(case.model_dump()).get("z_mm"):
            yield Mistake(
                f"{kind}: other side",
                kind,
                _in_case(times(of, "z_mm", -1.0)),
                rf"the {words} are on the other side of the origin",
            )

    def radii(t: dict[str, Any]) -> None:
        one, other = ring("machine", "base")(t), ring("machine", "platform")(t)
        one["radius_mm"], other["radius_mm"] = other["radius_mm"], one["radius_mm"]

    yield Mistake(
        "rings exchanged",
        "machine",
        _in_case(radii),
        r"radii of joints of the base and joints of the platform are exchanged",
    )
    yield Mistake(
        "home upside down", "home", _in_case(lambda t: t["machine"]["home"].update(z_mm=-t["machine"]["home"]["z_mm"])),
        r"home is upside down",
    )  # fmt: skip

    def one_end(t: dict[str, Any]) -> None:
        points = (case.sensor_frame.bars.upper.points * 1e3).tolist()
        points[2], points[3] = points[3], points[2]
        t["sensor_frame"]["bars"]["upper"] = {"points_mm": points}

    yield Mistake(
        "upper ends 3-4 exchanged", "bars upper", _in_case(one_end), r"upper ends of the bars 3 and 4 are exchanged"
    )


def _clock() -> Iterator[Mistake]:
    for unit, factor in (("ms", 1e3), ("us", 1e6)):
        yield Mistake(
            f"time in {unit}", "clock", lambda run, r, c, k=factor: (replace(r, t=r.t * k), c),
            rf"time stamps are in {unit}",
        )  # fmt: skip
    yield Mistake(
        "time twice too slow",
        "clock",
        lambda run, r, c: (replace(r, t=r.t * 2.0), c),
        r"samples are # ms apart",
        (2.0,),
    )
    yield Mistake(
        "forces 150 ms late", "clock", lambda run, r, c: (replace(r, forces=_after(r.forces, round(0.15 / r.step))), c),
        r"forces are stamped 1[45]\d ms late",
    )  # fmt: skip


def _after(forces: Array, rows: int) -> Array:
    """Forces so many rows later."""
    return np.concatenate([np.repeat(forces[:1], rows, axis=0), forces[:-rows]])


def others_of(name: str) -> list[Mistake]:
    """What is wrong with a run or case, and is no cause that hexcite knows: none may be named for it."""
    nothing = r"(?!)"
    if name == WRIST:
        return [
            Mistake("hysteresis", "other", _forces(lambda f: f + 0.08 * np.abs(f[:, [2, 0, 1, 5, 3, 4]])), nothing),
            Mistake("crosstalk", "other", _forces(lambda f: f + 0.1 * f[:, [1, 2, 3, 4, 5, 0]]), nothing),
        ]
    of = machine(name)
    late = np.arange(6) * 0.004
    found = [
        Mistake("crosstalk", "other", _forces(lambda f: f + 0.07 * f[:, [1, 2, 0, 4, 5, 3]]), nothing),
        Mistake("channels one after the other", "other", _forces(lambda f: _delayed(f, late)), nothing),
        Mistake("vibration of 9 Hz", "other", _forces(lambda f: f + _vibration(f, 9.0)), nothing),
        Mistake("contact again and again", "other", _forces(lambda f: f + _contacts(f)), nothing),
        Mistake("forces low-passed at 1 Hz", "other", _forces(lambda f: _slow(f)), nothing),
    ]
    if of.case.chain is not None:
        found += [
            Mistake("third link 15 % longer", "other", _in_case(_longer_link), nothing),
        ]
        return found
    return [
        *found,
        Mistake(
            "base radius 4 % off",
            "other",
            _in_case(lambda t: _scaled_ring(t["machine"]["base"], "radius_mm", 1.04)),
            nothing,
        ),
        Mistake(
            "half-angle 4 deg off",
            "other",
            _in_case(lambda t: _added(t["machine"]["platform"], "half_angle_deg", 4.0)),
            nothing,
        ),
        Mistake(
            "bars' radius 5 % off",
            "other",
            _in_case(lambda t: _scaled_ring(t["sensor_frame"]["bars"]["lower"], "radius_mm", 1.05)),
            nothing,
        ),
        Mistake("a joint 12 mm off", "other", _in_case(_moved_joint), nothing),
    ]


def _delayed(forces: Array, late: Array) -> Array:
    rows = np.arange(len(forces))
    return np.column_stack([np.interp(rows - 500.0 * d, rows, f) for f, d in zip(forces.T, late, strict=True)])


def _vibration(forces: Array, frequency: float) -> Array:
    size = 0.3 * forces.std(axis=0)
    t = np.arange(len(forces)) / 500.0
    return size * np.sin(2 * np.pi * frequency * t[:, None] + np.arange(6))


def _contacts(forces: Array) -> Array:
    t = np.arange(len(forces)) / 500.0
    on = (np.mod(t, 0.9) < 0.4).astype(float)[:, None]
    return 0.6 * forces.std(axis=0) * on * np.array([1.0, -0.5, 0.3, 0.8, -1.0, 0.2])


def _slow(forces: Array) -> Array:
    share, values = np.exp(-2 * np.pi * 1.0 / 500.0), forces.copy()
    for k in range(1, len(values)):
        values[k] = share * values[k - 1] + (1.0 - share) * forces[k]
    return values


def _scaled_ring(joints: dict[str, Any], key: str, factor: float) -> None:
    joints["ring"][key] *= factor


def _added(joints: dict[str, Any], key: str, value: float) -> None:
    joints["ring"][key] += value


def _moved_joint(tables: dict[str, Any]) -> None:
    ring = tables["machine"]["platform"]["ring"]
    angles = np.radians([c + s * ring["half_angle_deg"] for c in ring["pair_centres_deg"] for s in (-1, 1)])
    points = np.column_stack(
        [ring["radius_mm"] * np.cos(angles), ring["radius_mm"] * np.sin(angles), np.full(6, ring.get("z_mm", 0.0))]
    )
    points[3] += [12.0, 0.0, 0.0]
    tables["machine"]["platform"] = {"points_mm": points.tolist()}


def _longer_link(tables: dict[str, Any]) -> None:
    joint = tables["machine"]["chain"]["joints"][3]
    joint["origin_mm"] = [1.15 * v for v in joint.get("origin_mm", [0.0, 0.0, 0.0])]


MOVED = np.array([60.0, 0.0, -40.0])  # of a sensor in its case [mm]


def _moved_sensor(tables: dict[str, Any]) -> None:
    sensor = tables["machine"]["chain"].setdefault("sensor", {})
    x, y, z = sensor.get("origin_mm", [0.0, 0.0, 0.0])
    sensor["origin_mm"] = (np.array([x, y, z]) + MOVED).tolist()


def _from_moved(case: Case) -> tuple[float, ...]:
    """Where moments are about, from the origin of a sensor that the case has elsewhere, in its axes [mm]."""
    assert case.chain is not None
    return tuple(-turned(case.chain.sensor.rpy).T @ MOVED)
