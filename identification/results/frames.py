"""Results in the frames of their receivers: of the sensor, of the robot's flange or its tool, along the axes of {B}.

Mass, first moments and inertia about the origin of a frame depend linearly on those of another one, so that covariances
and what tolerances do are carried over exactly; from there physical values follow as everywhere.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.errors import CaseError, Code, HexciteError, IdentificationError, choice
from cases.base.phrases import phrase
from cases.base.units import DEG, MM, Array, as_html
from cases.schema import Case
from cases.tolerances import kind_of
from identification.estimation.fit import Value
from identification.findings.left_out import LeftOut
from identification.findings.told import LeftOpen, Together
from identification.findings.tolerances import UNITS, turns_of
from identification.machines.of_case import machine_of
from identification.model.blocks import FIRST_MOMENT, INERTIA, MASS, Block
from identification.model.model import Model
from identification.options import FRAMES, FrameName
from identification.results.estimate import physical_values
from identification.samples.samples import MotionOfSamples
from identification.texts import aligned, budget_cells, parameter_lines


class Place(NamedTuple):
    """A frame, and where that of the sensor, {P}, lies in it."""

    name: FrameName
    words: str  # what it is, for people
    frame_from_sensor: Array  # axes and origin of {P} in it, shape (4, 4) [-, m]

    @property
    def fixed(self) -> bool:
        """Whether the load stands still in it."""
        return self.name != "base"

    @property
    def map(self) -> Array:
        """Force and moment about its origin of those about that of {P}, each along the axes, shape (6, 6)."""
        turn, (x, y, z) = self.frame_from_sensor[:3, :3], self.frame_from_sensor[:3, 3]
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.block([[turn, np.zeros((3, 3))], [across @ turn, turn]])

    def to_json(self) -> dict[str, Any]:
        """Name, words, and where the sensor's frame is in it."""
        sensor = {"origin_m": self.frame_from_sensor[:3, 3].tolist(), "axes": self.frame_from_sensor[:3, :3].tolist()}
        return {"frame": self.name, "words": self.words, "sensor": sensor}


def frame_named(name: str) -> FrameName:
    """The frame of a name; raises HexciteError, with those that there are, where it is none."""
    known = next((frame for frame in FRAMES if frame == name), None)
    if known is None:
        raise HexciteError(problem=f"frame {name!r} is unknown", remedy=choice(name, FRAMES), code=Code.UNKNOWN)
    return known


def place_of(case: Case, frame: str, at_home: bool = True) -> Place:
    """A frame of a machine.

    Args:
        case: as the machine is; of a result `Result.case_as_told`.
        frame: one of `FRAMES`. That of the base has the origin of {P} and the axes of {B}.
        at_home: whether the load is meant that stands at home; else axes of {B} are left to each instant.

    Raises:
        HexciteError: no such frame.
        CaseError: the case does not state it.
    """
    name = frame_named(frame)
    if name == "sensor":
        return Place(name, "{P}" if case.hexapod is None else "{P}, the platform", np.eye(4))
    if name == "flange":
        return Place(name, "the robot's flange", _of_robot(case, name))
    if name == "tool":
        flange_from_sensor = _of_robot(case, name)
        if case.tcp is None:
            key = "machine.chain.tcp" if case.chain is not None else "sensor_frame.transducer.tcp"
            where = "frame tool is the robot's TCP: state where it lies in the flange"
            raise CaseError(
                file=f"case {case.name}",
                key=key,
                problem="is missing",
                remedy=f"{where}, such as tcp = {{ origin_mm = [0.0, 0.0, 150.0] }}",
                code=Code.MISSING,
            )
        tool_from_sensor = np.asarray(np.linalg.solve(case.tcp.parent_from_frame, flange_from_sensor))
        return Place(name, "the robot's tool (TCP)", tool_from_sensor)
    if at_home:
        return Place(name, "the axes of {B} at home, the origin of {P}", _at_home(case))
    return Place(name, "the axes of {B}, the origin of {P}", np.eye(4))


def _of_robot(case: Case, name: FrameName) -> Array:
    if case.chain is None and case.sensor_frame.transducer is None:
        problem = f"is that of no robot: frame {name} is for a force/torque sensor at a flange"
        raise CaseError(
            file=f"case {case.name}",
            key="setup",
            problem=problem,
            remedy="choose sensor, which is {P}, or base",
            code=Code.NOT_SUPPORTED,
        )
    return case.need_flange(f"frame {name}")


def _at_home(case: Case) -> Array:
    """Axes of {P} in {B} at home, shape (4, 4), the origin left where it is."""
    if (case.hexapod is None and case.chain is None) or case.setup == "1a":
        problem = "has no machine that moves the sensor: how it stands in {B} follows from no home"
        raise CaseError(
            file=f"case {case.name}",
            key="machine",
            problem=problem,
            remedy="choose sensor, flange or tool",
            code=Code.NOT_SUPPORTED,
        )
    home = case.hexapod.home.vector if case.hexapod is not None else None
    if home is None:
        assert case.chain is not None
        if not np.all(np.isfinite(case.chain.home)):
            raise CaseError(
                file=f"case {case.name}",
                key="machine.chain.joints",
                problem="home is missing",
                remedy="frame base is meant at home: add home_deg of each joint, or choose another frame",
                code=Code.MISSING,
            )
        still = np.zeros((1, len(case.chain.home)))
        home = machine_of(case).kinematics(case.chain.home[None], still, still).pose[0]
    place = np.eye(4)
    place[:3, :3] = Rotation.from_euler("xyz", home[3:]).as_matrix()
    return place


class Mounting(NamedTuple):
    """How uncertain the place of the sensor on its flange is: by where it is less where it was taken to be.

    Six sizes: its origin along its own axes [m], then turns about them [rad].
    """

    biases: Mapping[str, Array]  # by one standard deviation of each size of a tolerance, shapes (6, k), by its key
    # covariance of the six by noise where a run has told them, shapes (6, 6), and with the error of u, shapes (u, 6)
    white: tuple[Array, Array] | None = None  # of white noise
    robust: tuple[Array, Array] | None = None


@dataclass(frozen=True, repr=False)
class Body:
    """A rigid body in a frame, as a run determines it.

    Args:
        place: the frame.
        model: mass, first moments and, where the run determines it, inertia.
        values: these about the frame's origin and along its axes, shape (4,) or (10,) [SI].
        covariance: by (28), shape (u, u).
        covariance_robust: allows for noise with memory, tolerances and what residuals show.
        biases: of the values by one standard deviation of each size of a tolerance, shapes (u, k), by its key.
    """

    place: Place
    model: Model
    values: Array
    covariance: Array
    covariance_robust: Array
    biases: Mapping[str, Array] = field(default_factory=dict)

    @cached_property
    def parameters(self) -> dict[str, Value]:
        """Mass, centre of gravity in the frame, and inertia about it along the frame's axes [SI]."""
        return physical_values(self.model, self.values, self.covariance, self.covariance_robust)

    @cached_property
    def budget(self) -> dict[str, dict[str, float]]:
        """Of each parameter the parts of its deviation by their causes [SI], whose squares add up to that of the
        reported one; empty where no tolerances are counted. "other noise" has memory, or is what residuals show.
        """
        if not self.biases:
            return {}
        by_kind: dict[str, Array] = {}
        for key, bias in self.biases.items():
            by_kind[kind_of(key)] = by_kind.get(kind_of(key), 0.0) + bias @ bias.T
        parts = {kind: physical_values(self.model, self.values, c, c) for kind, c in by_kind.items()}
        rows = {}
        for name, value in self.parameters.items():
            stated = {kind: part[name].std for kind, part in parts.items()}
            rest = value.reported**2 - sum(v**2 for v in stated.values())
            white = min(value.std**2, max(rest, 0.0))
            noise = {"noise": white**0.5, "other noise": max(rest - white, 0.0) ** 0.5}
            rows[name] = noise | stated
        return rows

    def seen_from(self, place: Place, mounting: Mounting | None = None) -> "Body":
        """The same body, of {P}, in another frame.

        Args:
            place: the frame.
            mounting: what is not known of the place of the sensor, which counts in all frames but its own.
        """
        moved = moved_body(place.frame_from_sensor, len(self.values))
        white, robust, biases = self.covariance, self.covariance_robust, dict(self.biases)
        if mounting is not None and place.name != "sensor":
            by_place = _by_mounting(self.values, place.fixed)
            robust = robust - sum((b @ b.T for b in biases.values()), np.zeros_like(robust))
            for key, sizes in mounting.biases.items():
                biases[key] = biases.get(key, np.zeros((len(self.values), sizes.shape[1]))) - by_place @ sizes
            white, robust = (
                c if noise is None else _less(c, by_place, *noise)
                for c, noise in ((white, mounting.white), (robust, mounting.robust))
            )
            robust = robust + sum((b @ b.T for b in biases.values()), np.zeros_like(robust))
        return Body(
            place,
            self.model,
            moved @ self.values,
            moved @ white @ moved.T,
            moved @ robust @ moved.T,
            {key: moved @ bias for key, bias in biases.items()},
        )

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        return {
            **self.place.to_json(),
            "parameters": {name: value._asdict() for name, value in self.parameters.items()},
            **({"budget": self.budget} if self.budget else {}),
        }

    def __repr__(self) -> str:
        """A table of the parameters, and the parts of their deviations."""
        frame = f"in the frame of {self.place.words}" if self.place.fixed else f"along {self.place.words}"
        return "\n".join(
            [
                f"the body {frame}:",
                *parameter_lines(self.parameters),
                *aligned(*budget_cells({n: p.unit for n, p in self.parameters.items()}, self.budget)),
            ]
        )

    def _repr_html_(self) -> str:
        return as_html(self)


def _less(covariance: Array, by_place: Array, square: Array, cross: Array) -> Array:
    """Covariance of x - G y, of that of x, shape (u, u), G (u, 6), that of y (6, 6) and of x with y (u, 6)."""
    both = cross @ by_place.T
    return np.asarray(covariance - both - both.T + by_place @ square @ by_place.T)


def body_alone(model: Model, source: str) -> tuple[Model, list[int]]:
    """The part of a model that is the load's rigid body, and the places of its parameters in u.

    Raises:
        IdentificationError: it has none, or sensors in struts at the drive, whose body is the platform with the rods.
    """
    if MASS not in model.blocks:
        raise IdentificationError(
            place=source,
            problem=phrase("offsets_alone", "has offsets alone, no body to state in a frame"),
            remedy=phrase("identify_moving", "identify a moving run"),
            code=Code.NO_EXCITATION,
        )
    if model.struts is not None and model.struts.sensors.at == "drive":
        problem = "its body is the platform with the rods of the struts, no load alone"
        raise IdentificationError(
            place=source, problem=problem, remedy="its parameters are in {P}", code=Code.NOT_SUPPORTED
        )
    blocks: tuple[Block, ...] = tuple(block for block in (MASS, FIRST_MOMENT, INERTIA) if block in model.blocks)
    body = Model(model.number, blocks, model.structure, model.gravity)
    return body, [model.names.index(name) for name in body.names]


def mounting_by(place: Place, wrenches: Array) -> dict[str, Array]:
    """How forces and moments in a frame that moves with the sensor change with its place on the flange.

    Args:
        place: the frame.
        wrenches: forces and moments in it, shape (n, 6) [N, N m].

    Returns:
        By 1 m of its origin along its axes, and 1 rad about each, shapes (n, 6, 3), by keys of tolerances.
    """
    turn, none = place.frame_from_sensor[:3, :3], np.zeros((len(wrenches), 3, 3))
    along: Array = np.asarray(np.linalg.solve(place.map, wrenches.T).T, dtype=float)

    def crossed(vectors: Array) -> Array:  # each axis of the sensor times a vector along them, shape (n, 3, 3)
        return np.asarray(np.cross(np.eye(3)[None], vectors[:, None, :])).transpose(0, 2, 1)

    arms = np.asarray(turn @ crossed(along[:, :3]))
    rotated = np.concatenate([crossed(along[:, :3]), crossed(along[:, 3:])], axis=1)
    return {"sensor_mm": np.concatenate([none, arms], axis=1), "sensor_deg": place.map @ rotated}


def moved_body(place: Array, size: int = 10) -> Array:
    """Matrix from mass, first moments and inertia in {P} to those in a frame, shape (size, size).

    Args:
        place: axes and origin of {P} in the frame, shape (4, 4) [-, m].
        size: 10, or 4 without inertia.
    """
    turn, origin = place[:3, :3], place[:3, 3]
    columns = []
    for unit in np.eye(10)[:size]:
        mass, first, inertia = unit[0], turn @ unit[1:4], np.zeros((3, 3))
        if size == 10:
            xx, xy, xz, yy, yz, zz = unit[4:]
            inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
        # about the frame's origin: sum of m ((r.r) 1 - r r^T), r = R r_P + p
        across = np.outer(first, origin)
        inertia = inertia + 2.0 * (first @ origin) * np.eye(3) - across - across.T
        inertia = inertia + mass * (origin @ origin * np.eye(3) - np.outer(origin, origin))
        upper = inertia[np.triu_indices(3)]
        columns.append(np.r_[mass, first + mass * origin, upper][:size])
    return np.transpose(columns)


def _by_mounting(values: Array, fixed: bool) -> Array:
    """How a body in {P} seems to move with the sensor: by its six sizes of `Mounting`, shape (u, 6).

    Args:
        fixed: whether the frame that it is seen from moves with the robot; along {B}, the origin stays that of {P}.
    """
    columns = np.zeros((len(values), 6))
    for k in range(0 if fixed else 3, 6):
        ends = []
        for sign in (1.0, -1.0):  # the map is a polynomial of second order: this difference is its derivative
            place = np.eye(4)
            if k < 3:
                place[k, 3] = sign
            else:
                axis = np.eye(3)[k - 3]
                place[:3, :3] += sign * np.cross(np.eye(3), axis)
            ends.append(moved_body(place, len(values)) @ values)
        columns[:, k] = (ends[0] - ends[1]) / 2.0
    return columns


def turning_at_home(case: Case, model: Model, values: Array, counted: Collection[str]) -> dict[str, Array]:
    """By how much {P} is turned at home against where the case has it in {B}, about axes of {P}.

    Shapes (3, k) [rad], by one deviation of each size of the tolerances of zeros, encoders and joints, by their keys;
    none where the machine has none of these.
    """
    at = case.hexapod.home.vector if case.hexapod is not None else case.chain.home if case.chain is not None else None
    if at is None:
        return {}
    machine, still = machine_of(case), np.zeros((1, len(at)))
    drives = machine.drives(at[None])
    load = machine.kinematics(drives, still, still, at[None] if machine.of_pose else None)
    motion = MotionOfSamples(np.ones(1, dtype=bool), load, (drives, still, still), machine)
    left_out = LeftOut.in_use(model, motion, values, np.zeros((1, 6)), case)
    stated = {} if case.tolerances is None else dict(case.tolerances.stated())
    rotations = {}
    for key in counted:
        turns = turns_of(left_out, key) if key in stated and key != "sensor_deg" else np.zeros((1, 3, 0))
        if turns.shape[2]:
            rotations[key] = stated[key] * UNITS[key.rpartition("_")[2]] * left_out.turn[0].T @ turns[0]
    return rotations


def mounting_of_both(
    case: Case, one: LeftOpen, other: LeftOpen, bodies: tuple[Sequence[int], Sequence[int]]
) -> Mounting:
    """What two runs leave open of the place of the sensor, beside the difference of their parameters, other less one.

    Args:
        case: case of both.
        one: what the first leaves open of the sizes that both told.
        other: what the second leaves open of them.
        bodies: places of the parameters of the body in u of each.
    """
    stated = {} if case.tolerances is None else dict(case.tolerances.stated())
    rows = {"sensor_mm": (MM, slice(0, 3)), "sensor_deg": (DEG, slice(3, 6))}
    of_place = {k: np.eye(6)[:, at] * stated[k] * unit for k, (unit, at) in rows.items() if k in one.counts}
    into = one.of_keys({k: of_place.get(k, np.zeros((6, count))) for k, count in one.counts.items()})
    both = Together.of(one, other)
    parts = (
        (into @ both.first @ one.gain, -one.of_values[list(bodies[0])], one),
        (into @ both.second @ other.gain, other.of_values[list(bodies[1])], other),
    )
    white, robust = (
        (
            sum((s @ of.noise_of(kind) @ s.T for s, _, of in parts), np.zeros((6, 6))),
            sum((v @ of.noise_of(kind) @ s.T for s, v, of in parts), np.zeros((len(bodies[0]), 6))),
        )
        for kind in (False, True)
    )
    return Mounting({key: into @ remainder for key, remainder in both.remains.items()}, white, robust)


def mounting_of(
    case: Case,
    counted: Collection[str],
    left_open: LeftOpen | None,
    body: Sequence[int],
    turning: Mapping[str, Array] | None = None,
) -> Mounting:
    """What is left open of the place of the sensor on its flange, or of its axes in {B}.

    Args:
        case: case of the result.
        counted: keys of tolerances that its deviations count.
        left_open: what its run leaves open of the sizes that it told; None where it told nothing.
        body: places of the parameters of the body in u.
        turning: what else turns the sensor in {B}, as of `turning_at_home`; where the load is seen along {B}.
    """
    stated = {} if case.tolerances is None else dict(case.tolerances.stated())
    rows = {"sensor_mm": (MM, slice(0, 3)), "sensor_deg": (DEG, slice(3, 6))}
    of_place = {k: np.eye(6)[:, of_size] * stated[k] * unit for k, (unit, of_size) in rows.items() if k in counted}
    of_place |= {key: np.vstack([np.zeros_like(turns), turns]) for key, turns in (turning or {}).items()}
    estimated_keys = set() if left_open is None else of_place.keys() & left_open.counts.keys()
    plain = {key: sizes for key, sizes in of_place.items() if key not in estimated_keys}
    if left_open is None or not estimated_keys:
        return Mounting(plain)
    into = left_open.of_keys({k: of_place.get(k, np.zeros((6, count))) for k, count in left_open.counts.items()})
    biases = plain | {key: into @ remainder for key, remainder in left_open.remains.items()}
    noise = [left_open.noise_of(robust) for robust in (False, True)]
    of_sizes, of_values = into @ left_open.gain, left_open.of_values[list(body)]
    white, robust = ((of_sizes @ n @ of_sizes.T, of_values @ n @ of_sizes.T) for n in noise)
    return Mounting(biases, white, robust)
