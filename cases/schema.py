"""The validated case: all that hexcite knows about a machine and its sensors; properties without a unit are in SI."""

import hashlib
import json
import logging
import math
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, TypeVar

import numpy as np
from pydantic import ModelWrapValidatorHandler, PrivateAttr, ValidationError, field_validator, model_validator

from cases import doubts, numbering
from cases.acceptance import Acceptance
from cases.base.atomic import write_text
from cases.base.errors import CaseError, Code, option, printable
from cases.base.output_places import check_file
from cases.base.phrases import NOTHING, PURPOSE, Phrase, as_it_is, enumerated, phrase
from cases.base.text_formats import toml_text
from cases.base.units import DEG, MINUTE, MM, Array, as_html
from cases.bounds import Bounds
from cases.certificate import CertificateOf
from cases.chain import Box, Chain, JointMotionLimits, Limits, SerialMachine, joint_problems
from cases.contradictions import Doubt
from cases.controller import Controller, ControllerName, Settings, Sinumerik, TwinCat
from cases.earlier import LEFT, earlier_keys, without_earlier_keys
from cases.machine import Frame, HexapodMachine, MotionLimits, Workspace, box_problems, turned
from cases.poses import Poses
from cases.recording_format import STRUTS, RecordingFormat
from cases.sensors import Payloads, RigidBody, SensorFrame, Sensors, Simulation, together
from cases.tables import (
    Part,
    Text,
    Vector,
    built_in_cases,
    find_case,
    frozen,
    kind_of,
    lasting_name,
    read_tables,
    spelled,
)
from cases.tolerances import KINDS, Tolerances, tolerable_keys

# 9.76 on the highest mountain of the tropics to 9.83 at the poles; other values are typing errors or in another unit.
LEAST_GRAVITY, MOST_GRAVITY = 9.7, 9.9
LOG = logging.getLogger("hexcite")


def fingerprint(content: object) -> str:
    """Sixteen digits that differ where `content`, JSON, differs."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


NO_TITLE = "what it is, in a line"
"""The title of a new case, until its owner writes one."""
TITLE = "title"
"""Code of what a machine is called."""


class Heading(Part):
    """What a case is called."""

    schema_version: Literal[1]
    """Version of this description."""
    name: Annotated[
        str, spelled(r"[a-z][a-z0-9_]*", phrase("a_small_name", "a name: small letters, digits and _, a letter first"))
    ]
    """Small letters, digits and underscores."""
    title: Text
    """What it is, in a line."""

    @property
    def heading(self) -> str:
        """What its pages are called: its title; its name where the title is still that of a new case."""
        return self.name if self.title == NO_TITLE else self.title

    @property
    def heading_phrase(self) -> Phrase:
        """The same as a phrase, which knows the machine's name."""
        return phrase(TITLE, "{title}", title=self.heading, name=self.name)


class Case(Heading):
    """One machine. Parts that a setup lacks (a wrist sensor has no hexapod) are None.

    >>> case = hx.load_case("hexapod")
    >>> case.setup, case.limits.motion.x_mm, case.recording.filter_cutoff_Hz
    ('1b', (-250.0, 250.0), 40.0)
    """

    setup: Literal["1a", "1b", "2x", "R"]
    """Where the force sensors are: 1a in a frame that stands still, 1b in the moving platform, 2x in the struts, R one
    force/torque sensor; the numbers are those of the paper's Figure 1."""
    gravity_m_s2: Vector
    """Gravitational acceleration in {B}."""
    template: str | None = None
    """The built-in case that this one was begun from: `hexcite case check` names values that are still its own. Delete
    this line once all of them are yours."""
    sensor_frame: SensorFrame
    """Where forces are measured."""
    sensors: Sensors
    """What the sensors measure, and how well."""
    recording: RecordingFormat
    """How recordings are written down."""
    machine: Annotated[HexapodMachine | SerialMachine, kind_of(SerialMachine, HexapodMachine)] | None = None
    """A hexapod's joints and home, or a chain of joints."""
    workspace: Workspace | None = None
    """What a hexapod can reach."""
    limits: Limits | None = None
    """What an excitation may use."""
    poses: Poses | None = None
    """Candidates for measuring at standstills."""
    controller: Controller | None = None
    """How the controller is set up."""
    tolerances: Tolerances | None = None
    """How far the machine may be from all this; deviations of results count it."""
    bounds: Bounds | None = None
    """What is known of the body that the sensors carry, as from CAD."""
    accept: Acceptance | None = None
    """What a result has to be, to be accepted."""
    certificate: CertificateOf | None = None
    """What certificates say of the machine."""
    nominal: RigidBody | None = None
    """Expected values of the moving body: mass, centre of gravity, inertia."""
    simulation: Simulation | None = None
    """A simulated machine for rehearsals."""
    payloads: Payloads | None = None
    """Known weights, for a validation."""

    _origin: str = PrivateAttr("")
    _earlier: tuple[Doubt, ...] = PrivateAttr(())

    @property
    def origin(self) -> str:
        """Name or file that finds the case again from any folder; empty where it was not loaded."""
        return self._origin

    def found_at(self, origin: str) -> "Case":
        """The same case with another origin."""
        case = self.model_copy()
        case._origin = origin
        return case

    @classmethod
    def load(cls, name: str) -> "Case":
        """Loads and validates a case; see `load_case`."""
        name = str(name)  # a path does as well
        return read_tables(cls, find_case(name)).found_at(lasting_name(name))

    def save(self, path: Path | str, overwrite: bool = False) -> Path:
        """Writes the case as TOML, which `load` reads back; values at their defaults are left out.

        Raises:
            FileProblem: the file exists, or cannot be written.
        """
        check_file(file := Path(path), (".toml",), overwrite=overwrite)
        write_text(file, toml_text(self.model_dump(mode="json", exclude_defaults=True)) + "\n")
        return file

    def __repr__(self) -> str:
        """Two lines: what it is, and which parts it has."""
        optional = ("machine", "workspace", "limits", "poses", "controller", "nominal", "simulation", "payloads")
        parts = [part for part in optional if getattr(self, part) is not None]
        headline = f"Case {self.name}: {self.title} (setup {self.setup}, hash {self.hash})"
        return f"{headline}\nhas {', '.join(parts) or 'sensors only'}"

    __str__ = __repr__

    _repr_html_ = as_html

    @model_validator(mode="wrap")
    @classmethod
    def _of_any_version(cls, data: Any, read: ModelWrapValidatorHandler["Case"]) -> "Case":
        if not isinstance(data, Mapping):
            return read(data)
        data = _with_nominal_body(data)
        if not (stated := earlier_keys(data)):
            return read(data)
        case = read(without_earlier_keys(data))
        case._earlier = tuple(
            Doubt.on(phrase("earlier_key", "{key}, which {what}; delete the line", key=key, what=LEFT[key]), [key])
            for key in stated
        )
        return case

    @model_validator(mode="after")
    def _consistent(self) -> "Case":
        if problems := [
            *self._of_its_machine(),
            *self._of_its_sensors(),
            *self._of_its_tolerances(),
            *self._of_its_bounds(),
        ]:
            raise ValueError(enumerated("problems", problems))
        return self

    @field_validator("gravity_m_s2")
    @classmethod
    def _of_this_earth(cls, value: tuple[float, float, float]) -> tuple[float, float, float]:
        size = math.hypot(*value)
        if not LEAST_GRAVITY <= size <= MOST_GRAVITY:
            raise ValueError(
                phrase(
                    "gravity_size",
                    "is {size} m/s^2 long; on Earth it has {least} to {most}: give the local gravitational "
                    "acceleration in the frame {{B}}, such as [0.0, 0.0, -9.81]",
                    size=f"{size:.4g}",
                    least=f"{LEAST_GRAVITY:g}",
                    most=f"{MOST_GRAVITY:g}",
                )
            )
        return value

    @field_validator("template")
    @classmethod
    def _built_in(cls, value: str | None) -> str | None:
        if value is not None and value not in built_in_cases():
            raise ValueError(
                phrase("no_built_in", "{value} is not a built-in case; delete the line", value=repr(value))
            )
        return value

    def _of_its_machine(self) -> Iterator[str]:
        """Problems of tables that are those of another kind of machine, and of limits that do not fit it."""
        motion, chain = None if self.limits is None else self.limits.motion, self.chain
        grid = {} if self.poses is None else self.poses.model_dump(exclude={"settle_s", "average_s"})
        own_axes = {
            name: isinstance(settings, full) == (chain is not None)
            for name, full in ((ControllerName.SINUMERIK, Sinumerik), (ControllerName.TWINCAT, TwinCat))
            if (settings := getattr(self.controller, name, None)) is not None
        }
        of = phrase("a_chain", "a chain") if chain is None else phrase("a_hexapod", "a hexapod")
        add_chain = phrase("or_add_chain", "hexapod, or add [machine.chain]")
        like = add_chain if chain is None else "five_axis_table"
        for key, wrong in {
            "workspace": chain is not None and self.workspace is not None,
            "limits.motion": motion is not None and isinstance(motion, MotionLimits) == (chain is not None),
            "poses": any((value is None) == (chain is None) for value in grid.values()),
            **{f"controller.{name}": wrong for name, wrong in own_axes.items()},
        }.items():
            if wrong:
                yield phrase(
                    "of_other_machine",
                    "{key} is that of {of}, or incomplete; write it as in the case {like}",
                    key=key,
                    of=of,
                    like=like,
                ).about(key)
        if chain is not None and isinstance(motion, JointMotionLimits):
            yield from joint_problems(chain, motion)
        if chain is None and isinstance(motion, MotionLimits):
            if self.workspace is not None:
                yield from box_problems(self.workspace, motion)
            fastest = float(motion.rate[:3].min()) / MM * MINUTE
            if self.controller is not None and not 0.0 < (self.controller.safe_feed_mm_min or 0.0) <= fastest:
                yield phrase(
                    "safe_feed",
                    "controller.safe_feed_mm_min is missing or faster than limits.motion.velocity_mm_s; give the "
                    "feed of the first move, at most {most} mm/min",
                    most=f"{fastest:g}",
                ).about("controller.safe_feed_mm_min")

    def _of_its_sensors(self) -> Iterator[str]:
        """Problems of sensors that do not belong to the setup or the machine, or whose noise is half stated."""
        sensors, frame = self.sensors, self.sensor_frame
        if (self.setup == "2x") != (frame.struts is not None) or (frame.struts is not None and self.hexapod is None):
            yield phrase(
                "setup_2x",
                'setup "2x" goes with [sensor_frame.struts] and a hexapod: sensors in its struts; change one of them',
            ).about("setup")
        if (self.setup == "R" and self.chain is None and not frame.has_moments) or (
            self.chain is not None and (self.setup != "R" or not frame.has_moments)
        ):
            yield phrase(
                "setup_R",
                'setup "R", and machine.chain, go with a force/torque sensor: write setup = "R" and '
                "[sensor_frame.transducer], or the setup of the bars",
            ).about("setup")
        transducer = frame.transducer
        for key in ("flange", "tcp"):
            if self.chain is not None and transducer is not None and getattr(transducer, key) is not None:
                yield phrase(
                    "without_chain",
                    "sensor_frame.transducer.{key} is for cases without a chain; state it as machine.chain.{key}",
                    key=key,
                ).about(f"sensor_frame.transducer.{key}")
        if frame.struts is not None and sensors.acceleration_noise is not None:
            yield phrase(
                "no_shaking_in_struts",
                "sensors: noise of accelerations is not counted yet where sensors sit in struts; remove it",
            ).about("sensors.acceleration_noise_m_s2", "sensors.angular_acceleration_noise_rad_s2")
        if (sensors.moment_noise_Nm is not None) != (frame.has_moments and sensors.force_noise_N is not None):
            yield phrase(
                "moment_noise",
                "sensors.moment_noise_Nm goes with force_noise_N of a force/torque sensor, and sensors of forces do "
                "without it; add or remove one",
            ).about("sensors.moment_noise_Nm", "sensors.force_noise_N")
        if sensors.range_Nm is not None and (sensors.range_N is None or not frame.has_moments):
            yield phrase(
                "moment_range",
                "sensors.range_Nm goes with range_N of a force/torque sensor; add range_N, or remove range_Nm",
            ).about("sensors.range_Nm")
        if sensors.force_noise_N is None and (sensors.weights == "stated" or sensors.acceleration_noise is not None):
            yield phrase(
                "force_noise_missing",
                'sensors.force_noise_N is missing; weights = "stated" and noise of accelerations go with it, from '
                "the sensors' data sheet",
            ).about("sensors.force_noise_N", "sensors.weights")
        size = sensors.pose_error_N
        if (size is None) != (sensors.pose_error_length_mm is None):
            yield phrase(
                "pose_error_missing",
                "sensors: pose_error_N or pose_error_length_mm is missing; give both, as hexcite identify prints them",
            ).about("sensors.pose_error_N", "sensors.pose_error_length_mm")
        elif size is not None and (frame.bars is None or self.machine is None or self.setup == "1a"):
            yield phrase(
                "pose_error_of_bars",
                "sensors.pose_error_N = {size} is for bars that struts move (setup 1b); remove it and "
                "pose_error_length_mm",
                size=f"{size:g}",
            ).about("sensors.pose_error_N", "sensors.pose_error_length_mm")

    def _of_its_bounds(self) -> Iterator[str]:
        """Problems of bounds of a body that is not identified."""
        if self.bounds is not None and self.setup == "1a":
            yield phrase("bounds_in_1a", "bounds are of a body that moves; in setup 1a none is identified: remove them")

    def _of_its_tolerances(self) -> Iterator[str]:
        """Problems of tolerances of what the machine does not have: they would count for nothing."""
        for key, _ in () if self.tolerances is None else self.tolerances.stated():
            if key not in self.tolerable:
                tolerable = ", ".join(self.tolerable)
                yield phrase(
                    "not_tolerable",
                    "tolerances.{key} is of something that this machine does not have; it has {tolerable}",
                    key=key,
                    tolerable=tolerable,
                ).about(f"tolerances.{key}")

    @cached_property
    def doubts(self) -> tuple[Doubt, ...]:
        """Sentences on values that contradict others of the case, or that no machine has; see `cases.doubts`.

        Keys of earlier versions, which do nothing, are named first.
        """
        motion, chain, frame = None if self.limits is None else self.limits.motion, self.chain, self.sensor_frame
        doubtful = list(doubts.of_geometry(self.hexapod, frame, self.workspace))
        if self.hexapod is not None:
            doubtful += numbering.of_numbering(self.hexapod)
        if isinstance(motion, MotionLimits):
            doubtful += doubts.of_motion(motion, self.hexapod)
        elif motion is not None and chain is not None:
            doubtful += doubts.of_chain(chain, motion)
        if chain is not None:
            doubtful += doubts.of_links(chain)
        carried = doubts.Carried(dict(self._bodies()), self._size, frame, self.gravity, self._turns())
        doubtful += doubts.of_loads(carried, self.sensors)
        return (*self._earlier, *doubtful, *doubts.of_times({key: self._stated(key) for key in doubts.TIMES}))

    @property
    def remarks(self) -> tuple[Phrase, ...]:
        """What a person should look at: values that are hardly meant, then the doubts."""
        return (*doubts.hardly_meant(self.chain, self.hexapod, self.gravity_m_s2), *self.doubts)

    def _bodies(self) -> Iterator[tuple[str, RigidBody]]:
        """Bodies of the case with their tables."""
        if self.nominal is not None:
            yield "nominal", self.nominal
        if self.simulation is not None:
            yield "simulation.parameters.body", self.simulation.parameters.body
        for k, weight in enumerate(self.payloads.weights if self.payloads is not None else (), 1):
            yield f"payloads.weights[{k}]", weight

    def _turns(self) -> list[Array]:
        """Orientations of {P}: that of home, of other machines as it can hang, stand or lie."""
        if self.hexapod is not None:
            return [turned(self.hexapod.home.vector[3:])]
        angles = ((0.0, 0.0, 0.0),) if self.setup == "1a" else ((0.0, 0.0, 0.0), (180.0, 0.0, 0.0), (90.0, 0.0, 0.0))
        return [turned(np.array(angle) * DEG) for angle in (*angles, (0.0, 90.0, 0.0))]

    @property
    def _size(self) -> float | None:
        """How large the part is that carries the sensors [m]; None where the case does not tell."""
        bars = self.sensor_frame.bars
        points = [] if bars is None else [bars.lower.points, bars.upper.points]
        points += [] if self.hexapod is None else [self.hexapod.platform.points]
        return float(np.linalg.norm(np.vstack(points), axis=1).max()) if points else None

    def _stated(self, key: str) -> float | None:
        """A number of the case by its dotted key."""
        value: object = self
        for part in key.split("."):
            value = getattr(value, part, None)
        return value if isinstance(value, float) else None

    @cached_property
    def gravity(self) -> Array:
        """Gravitational acceleration in {B}, shape (3,) [m/s^2]."""
        return frozen(self.gravity_m_s2)

    @cached_property
    def hash(self) -> str:
        """Fingerprint of the case: comments and layout of the file do not matter, every value does.

        A setting left at its default and one that states the default are the same case, in later versions too. What
        `[controller]` says of programs has a fingerprint of its own, but for `cycle_ms`; `template` does not count.
        Artefacts are checked against what they were computed from (`cases.basis`), not against this.
        """
        content = self.model_dump(mode="json", exclude_defaults=True, exclude={"template"})
        cycle = {k: v for k, v in content.pop("controller", {}).items() if k == "cycle_ms"}
        return fingerprint(content | {f"controller.{key}": value for key, value in cycle.items()})

    def __hash__(self) -> int:  # type: ignore[override]  # its tables have none, for they are no keys
        """Equal cases have equal ones: functions can keep what they computed of the last cases."""
        return hash(self.hash)

    @cached_property
    def controller_hash(self) -> str:
        """Fingerprint of `[controller]`, on which programs and runs depend."""
        return fingerprint(self.model_dump(mode="json", exclude_defaults=True).get("controller"))

    def missing(self, part: str, purpose: str) -> NoReturn:
        """Raises CaseError: `part` of the case is needed for `purpose`."""
        raise CaseError(
            file=f"case {self.name}",
            key=part,
            problem=phrase("is_missing", "is missing"),
            remedy=phrase(
                "purpose_needs", "{purpose} needs it: add the table to the case file", purpose=_purpose(purpose)
            ),
            code=Code.MISSING,
        )

    @cached_property
    def tolerable(self) -> tuple[str, ...]:
        """Keys of `[tolerances]` that this machine has something for."""
        turns = [] if self.chain is None else [joint.turns for joint in self.chain.joints]
        bars, transducer = self.sensor_frame.bars is not None, self.sensor_frame.transducer is not None
        known, moves = self.machine is not None, self.setup != "1a"
        return tolerable_keys(turns, self.hexapod is not None, bars, transducer, known, moves)

    @property
    def not_counted(self) -> list[str]:
        """Kinds of tolerances that this machine has and the case does not state: no deviation counts them."""
        stated = set() if self.tolerances is None else {KINDS[key] for key, _ in self.tolerances.stated()}
        return [kind for kind in dict.fromkeys(KINDS[key] for key in self.tolerable) if kind not in stated]

    @property
    def hexapod(self) -> HexapodMachine | None:
        """The hexapod, where the machine is one."""
        return self.machine if isinstance(self.machine, HexapodMachine) else None

    @property
    def chain(self) -> Chain | None:
        """The chain of joints, where the machine is one."""
        return self.machine.chain if isinstance(self.machine, SerialMachine) else None

    @property
    def drive_columns(self) -> tuple[str, ...]:
        """Columns of recorded drives: struts of a hexapod, joints of a chain."""
        return STRUTS if self.chain is None else self.chain.columns

    @property
    def drive_words(self) -> tuple[str, str]:
        """What moves the sensors, and a thousandth of its unit."""
        if self.chain is None:
            return "struts", "mm"
        return "joints", "mrad" if self.chain.units.min() > MM else "mrad or mm"

    @property
    def flange_from_sensor(self) -> Array | None:
        """Axes and origin of {P} in the robot's flange, shape (4, 4) [-, m]; None where the case states no flange."""
        if self.chain is not None:
            flange, link_from_sensor = self.chain.flange, self.chain.sensor.parent_from_frame
        else:
            transducer = self.sensor_frame.transducer
            flange, link_from_sensor = None if transducer is None else transducer.flange, np.eye(4)
        return None if flange is None else frozen(np.linalg.solve(flange.parent_from_frame, link_from_sensor))

    @property
    def tcp(self) -> Frame | None:
        """The frame of the robot's tool in its flange; None where the case states none."""
        mounted = self.sensor_frame.transducer if self.chain is None else self.chain
        return None if mounted is None else mounted.tcp

    def need_flange(self, purpose: str) -> Array:
        """As `flange_from_sensor`; raises CaseError where the case states no flange."""
        if (place := self.flange_from_sensor) is not None:
            return place
        if self.chain is None and self.sensor_frame.transducer is None:
            raise CaseError(
                file=f"case {self.name}",
                key="setup",
                problem=phrase(
                    "not_a_robot",
                    "is that of no robot: {purpose} is for setup R, a force/torque sensor at a flange",
                    purpose=purpose,
                ),
                remedy=phrase(
                    "export_to_others", "export {option} c, linuxcnc, st or json", option=option("target", "to")
                ),
                code=Code.OTHER_SOURCE,
            )
        key, z = "machine.chain.flange", 116.5
        of = phrase("last_joints_frame", "the last joint's moved frame, as machine.chain.sensor does {{P}}")
        if self.chain is None:
            key, z, of = "sensor_frame.transducer.flange", -40.0, as_it_is("{P}")
        raise CaseError(
            file=f"case {self.name}",
            key=key,
            problem=phrase("flange_missing", "is missing"),
            remedy=phrase(
                "state_flange",
                "{purpose} counts from the robot's flange: state where it lies in {of}, such as "
                "flange = {{ origin_mm = [0.0, 0.0, {z}] }}",
                purpose=purpose,
                of=of,
                z=f"{z:g}",
            ),
            code=Code.MISSING,
        )

    def need_chain(self, purpose: str) -> tuple[Chain, JointMotionLimits]:
        """Chain and limits of motion; raises CaseError where the case lacks one of them."""
        if self.hexapod is not None:
            raise CaseError(
                file=f"case {self.name}",
                key="machine",
                problem=phrase(
                    "for_chains", "is a hexapod, and {purpose} is for a chain of joints", purpose=_purpose(purpose)
                ),
                remedy=f"choose another {option('dialect')}",
                code=Code.NOT_SUPPORTED,
            )
        chain = self.need_joints(purpose)
        if self.limits is None or not isinstance(self.limits.motion, JointMotionLimits):
            self.missing("limits.motion", purpose)
        return chain, self.limits.motion

    def need_joints(self, purpose: str) -> Chain:
        """The chain, whether it can be moved or not; raises CaseError where the case has none."""
        if self.chain is None:
            self.missing("machine.chain", purpose)
        return self.chain

    def need_sense(self) -> None:
        """Raises CaseError where a force/torque sensor may read one way or the other."""
        try:
            if self.sensor_frame.transducer is not None:
                self.sensor_frame.transducer.sign  # noqa: B018
        except CaseError as error:
            raise CaseError(
                file=f"case {self.name}",
                key=error.key,
                problem=error.said.problem,
                remedy=error.said.remedy,
                code=error.code,
            ) from None

    def need_motion(self, purpose: str) -> tuple[Array, MotionLimits | JointMotionLimits]:
        """Coordinates at home, shape (n,) [m or rad], and limits of motion; raises CaseError where one is missing."""
        if self.chain is not None:
            chain, limits = self.need_chain(purpose)
            return chain.home, limits
        machine, _, of_pose = self.need_machine(purpose)
        return machine.home.vector, of_pose

    def words(self, coordinates: Iterable[float]) -> str:
        """Coordinates of the machine, shape (n,) [m or rad], in words."""
        if self.chain is None:
            x, y, z, a, b, c = (value / unit for value, unit in zip(coordinates, (MM,) * 3 + (DEG,) * 3, strict=True))
            return f"x {x:.1f} y {y:.1f} z {z:.1f} mm, a {a:.2f} b {b:.2f} c {c:.2f} deg"
        return ", ".join(
            f"{joint.name} {value / joint.unit:.{2 if joint.turns else 1}f} {'deg' if joint.turns else 'mm'}"
            for value, joint in zip(coordinates, self.chain.joints, strict=True)
        )

    def with_jerk(self, jerk: Array) -> "Case":
        """The same with other limits of jerk of the coordinates, shape (n,) [m/s^3 or rad/s^3]."""
        assert self.limits is not None  # asked of cases that plan
        limits = self.limits.model_copy(update={"motion": self.limits.motion.with_jerk(jerk)})
        return self.model_copy(update={"limits": limits})

    def named_slow(self) -> "Case":
        """The same with names for slow programs, which must not replace the others in a controller's memory."""
        assert self.controller is not None  # asked of cases that write programs
        return self.model_copy(update={"controller": self.controller.named_slow()})

    def without_jerk(self) -> "Case":
        """The same where jerks are not limited, as for a controller whose accelerations step."""
        assert self.limits is not None
        return self.with_jerk(np.full(len(self.limits.motion.jerk), np.inf))

    def with_reserve(self, share: float) -> "Case":
        """The same with accelerations of struts, efforts of joints and ranges of sensors less by a share of them."""
        if self.limits is None:
            return self
        parts: dict[str, Part] = {"sensors": _reduced(self.sensors, share, "range_N", "range_Nm")}
        if isinstance(self.limits.motion, MotionLimits):
            motion = _reduced(self.limits.motion, share, "strut_acceleration_m_s2")
            parts["limits"] = self.limits.model_copy(update={"motion": motion})
        if isinstance(self.machine, SerialMachine):
            joints = tuple(_reduced(joint, share, "torque_Nm", "force_N") for joint in self.machine.chain.joints)
            chain = self.machine.chain.model_copy(update={"joints": joints})
            parts["machine"] = self.machine.model_copy(update={"chain": chain})
        return self.model_copy(update=parts)

    def within_margin(self) -> "Case":
        """The same with all ends of ways moved inwards by `limits.margin`: what searches keep. Proofs do not ask it."""
        if self.limits is None:
            return self
        margin, motion = self.limits.margin, self.limits.motion
        parts: dict[str, Part] = {}
        if isinstance(motion, MotionLimits):
            box: Box = margin.narrowed(motion)
        else:
            box = motion.model_copy(update={"joints": tuple(map(margin.narrowed, motion.joints))})
        if isinstance(self.machine, SerialMachine):
            joints = tuple(map(margin.narrowed, self.machine.chain.joints))
            chain = self.machine.chain.model_copy(update={"joints": joints})
            parts["machine"] = self.machine.model_copy(update={"chain": chain})
        if self.workspace is not None:
            parts["workspace"] = margin.narrowed(self.workspace)
        return self.model_copy(update={**parts, "limits": self.limits.model_copy(update={"motion": box})})

    def need_machine(self, purpose: str) -> tuple[HexapodMachine, Workspace, MotionLimits]:
        """Hexapod, workspace and limits of motion; raises CaseError where the case lacks one, or has a chain."""
        if self.chain is not None:
            raise CaseError(
                file=f"case {self.name}",
                key="machine.chain",
                problem=phrase("for_hexapods", "{purpose} is for hexapods only", purpose=_purpose(purpose)),
                remedy=phrase("none_of_a_chain", "a chain has none yet"),
                code=Code.NOT_SUPPORTED,
            )
        if self.setup == "1a":
            raise CaseError(
                file=f"case {self.name}",
                key="setup",
                problem=phrase(
                    "setup_1a",
                    "is 1a, a sensor frame that does not move: {purpose} needs one that does",
                    purpose=_purpose(purpose),
                ),
                remedy=phrase(
                    "tare_instead", "use hexcite tare, force, and identify with payload for what is put on it"
                ),
                code=Code.NOT_SUPPORTED,
            )
        if self.hexapod is None:
            self.missing("machine", purpose)
        if self.workspace is None:
            self.missing("workspace", purpose)
        if self.limits is None or not isinstance(self.limits.motion, MotionLimits):
            self.missing("limits.motion", purpose)
        return self.hexapod, self.workspace, self.limits.motion

    @cached_property
    def bodies(self) -> tuple[RigidBody, ...]:
        """The nominal body alone, with the first weight, with two and so on; empty where the case has none."""
        if self.nominal is None:
            return ()
        weights = self.payloads.weights if self.payloads is not None else ()
        return tuple(accumulate(weights, together, initial=self.nominal))

    def body(self, payloads: int) -> RigidBody:
        """The nominal body with a number of payloads; raises CaseError where there is none, or fewer payloads."""
        if not self.bodies:
            self.missing("nominal", "the expected load")
        if not 0 <= payloads < len(self.bodies):
            raise CaseError(
                file=f"case {self.name}",
                key="payloads.weights",
                problem=phrase("payloads_are", "are {count}", count=len(self.bodies) - 1),
                remedy=phrase(
                    "mountable",
                    "{payloads} cannot be mounted: choose 0 to {most}",
                    payloads=payloads,
                    most=len(self.bodies) - 1,
                ),
                code=Code.OUT_OF_RANGE,
            )
        return self.bodies[payloads]

    def need_poses(self, purpose: str) -> Poses:
        """Poses of quasi-static measurement; raises CaseError where the case has none."""
        if self.poses is None:
            self.missing("poses", purpose)
        return self.poses

    def need_controller(self, purpose: str) -> Controller:
        """Controller settings; raises CaseError where the case has none."""
        if self.controller is None:
            self.missing("controller", purpose)
        return self.controller

    def need_settings(self, kind: type[Settings], purpose: str) -> Settings:
        """Settings of a dialect, a table of `[controller]`; raises CaseError where the case has none."""
        settings: Settings | None = getattr(self.need_controller(purpose), kind.table)
        if settings is None:
            example = "ur10_wrist" if kind.table == ControllerName.URSCRIPT else "hexapod"
            others = [name for name in ControllerName if getattr(self.controller, name, None) is not None]
            for_case = phrase(
                "for_own_controller",
                "choose the case's own controller, {others}, or ",
                others=enumerated("or", others),
            )
            raise CaseError(
                file=f"case {self.name}",
                key=f"controller.{kind.table}",
                problem=phrase("settings_missing", "is missing"),
                remedy=phrase(
                    "add_settings",
                    "the dialect {dialect} needs it: {for_case}add the table to the case file, see "
                    "cases/{example}/case.toml",
                    dialect=kind.table,
                    for_case=for_case if others else NOTHING,
                    example=example,
                ),
                code=Code.MISSING,
            )
        return settings

    def need_simulation(self, purpose: str) -> Simulation:
        """The simulated machine; raises CaseError where the case has none."""
        if self.simulation is None:
            self.missing("simulation", purpose)
        return self.simulation


def _with_nominal_body(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Tables whose simulated body has the values of `[nominal]` where none of its own are stated."""
    simulation, nominal = data.get("simulation"), data.get("nominal")
    parameters = simulation.get("parameters") if isinstance(simulation, Mapping) else None
    body = parameters.get("body", {}) if isinstance(parameters, Mapping) else None
    if not isinstance(simulation, Mapping) or not isinstance(body, Mapping) or not isinstance(nominal, Mapping):
        return data
    if nominal.keys() <= body.keys():
        return data
    try:
        RigidBody.model_validate(nominal)
    except ValidationError:  # said once, of [nominal]
        return {key: value for key, value in data.items() if key != "simulation"}
    return {**data, "simulation": {**simulation, "parameters": {**(parameters or {}), "body": {**nominal, **body}}}}


def _purpose(purpose: str) -> Phrase:
    return phrase(PURPOSE, "{words}", words=purpose)


def load_case(name: str) -> Case:
    """Loads and validates a case.

    >>> hx.load_case("hexapod").name
    'hexapod'

    Args:
        name: built-in name, folder or file.

    What is odd about it (`Case.doubts`) is logged as warnings, which Python prints unless told otherwise.

    Raises:
        CaseError: not found, not TOML, or not a usable machine; the message names file, key, value and remedy.
    """
    case = Case.load(name)
    for doubt in case.doubts:
        LOG.warning("%s: look at %s", printable(str(name)), doubt)
    return case


AnyPart = TypeVar("AnyPart", bound=Part)


def _reduced(part: AnyPart, share: float, *keys: str) -> AnyPart:
    """A table with stated numbers less by a share of them."""
    stated = {key: value for key in keys if (value := getattr(part, key)) is not None}
    return part.model_copy(update={key: value * (1.0 - share) for key, value in stated.items()})
