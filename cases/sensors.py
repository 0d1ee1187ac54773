"""What measures, and what it is expected to carry: sensor frame, noise, rigid body and compensation factors."""

from functools import cached_property
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from cases.base.errors import CaseError, Code
from cases.base.phrases import Phrase, phrase
from cases.base.units import DEG, MM, Array
from cases.machine import Frame, Joints, require_flange, require_spanning
from cases.recording_format import BAR_FORCES, WRENCH
from cases.tables import NEEDED, NonNegative, Number, Part, Positive, Six, Text, Vector, frozen, si, si_value

MOST_BAND_HZ = 400.0  # of ripple, which simulated runs have at 1000 samples a second


class Disturbances(Part):
    """Imperfections of the simulated machine that no identification model contains; effective values for all loads."""

    source: Text
    """Where the values come from."""
    mode_Hz: Positive
    """Structural mode between drives and platform, without payload; it falls with the root of the moved mass."""
    mode_damping: Annotated[float, Field(strict=True, gt=0, lt=1)]
    """Share of critical damping."""
    strut_velocity_noise_percent: NonNegative
    """Rms of the struts' velocity ripple, which really moves the platform, as a share of each strut's own velocity."""
    strut_velocity_band_Hz: Annotated[float, Field(strict=True, gt=0, le=MOST_BAND_HZ)]
    """Highest frequency of that ripple."""
    pose_error_N: NonNegative
    """Rms of the force error that depends on the pose, in each sensor, without payload."""
    pose_error_of_load: NonNegative
    """The same of a payload, as a share of its weight; independent of the error without payload."""
    pose_error_length_mm: Positive
    """Distance over which the error changes, translations."""
    pose_error_angle_deg: Positive
    pose_error_seed: Annotated[int, Field(strict=True, ge=0)]
    """Chooses the error of this machine: it belongs to the machine, not to a run."""

    @property
    def ripple(self) -> float:
        """Rms of the struts' velocity ripple over their velocity."""
        return self.strut_velocity_noise_percent / 100.0


LEAST_LENGTH_MM, MOST_LENGTH_MM = 0.1, 10_000.0  # of errors that depend on the pose: others are metres or radians


Sense = Literal["compression", "tension"]


class Bars(Part):
    """Six single-axis force sensors, each in a bar that carries the platform from a lower to an upper point."""

    lower: Joints
    """Lower end of each bar in {P}, in the order of the channels."""
    upper: Joints
    """Upper end of each bar in {P}, in the same order."""
    sense: Sense | Annotated[tuple[Sense, ...], Field(min_length=6, max_length=6)] = "compression"
    """What a positive reading means: `"compression"`, the bar pushes its ends apart, or `"tension"`; one for all bars,
    or a list of six in the order of the channels."""

    @model_validator(mode="after")
    def _spans_space(self) -> "Bars":
        direction = self.upper.points - self.lower.points
        length = np.linalg.norm(direction, axis=1)
        if np.any(length == 0.0):
            raise ValueError(
                phrase(
                    "bar_no_length",
                    "bar {number} has no length; its lower and upper point coincide",
                    number=int(np.argmin(length)) + 1,
                )
            )
        problem = phrase("bars_not_spanning", "the six bars do not measure all forces and moments")
        remedy = phrase("bars_must", "bars must not all be parallel, coplanar or meet one line")
        require_spanning(self.lower.points, direction, problem, remedy)
        return self

    @cached_property
    def directions(self) -> Array:
        """What the bars do to the platform for a reading of 1 N: unit vectors along them in {P}, shape (6, 3)."""
        along = self.upper.points - self.lower.points
        senses = (self.sense,) * 6 if isinstance(self.sense, str) else self.sense
        signs = np.array([1.0 if sense == "compression" else -1.0 for sense in senses])
        return frozen(signs[:, None] * along / np.linalg.norm(along, axis=1)[:, None])


class Transducer(Part):
    """A six-axis force/torque sensor at the origin of {P}."""

    sense: Literal["load_on_sensor", "sensor_on_load"] | None = NEEDED
    """Which force a positive reading means: that of the load on the sensor, or its reaction. Whatever evaluates or
    predicts readings needs it."""
    flange: Frame | None = None
    """The robot's flange in {P}, as its controller counts it; of a chain, `machine.chain.flange` states it."""
    tcp: Frame | None = None
    """The frame of the robot's tool in the flange; of a chain, `machine.chain.tcp` states it."""

    @property
    def sign(self) -> float:
        """1 where it reads the support's push on the load, -1 where the load's pull; raises CaseError if not stated."""
        if self.sense is None:
            raise CaseError(
                file="case",
                key="sensor_frame.transducer.sense",
                problem=phrase("sense_missing", "is missing"),
                remedy=phrase(
                    "state_sense",
                    'state "load_on_sensor" if a hanging tool of 1 kg reads -9.81 N along the axis that points '
                    'up, else "sensor_on_load"',
                ),
                code=Code.MISSING,
            )
        return {"load_on_sensor": -1.0, "sensor_on_load": 1.0}[self.sense]

    @model_validator(mode="after")
    def _tcp_in_flange(self) -> "Transducer":
        require_flange(self.flange, self.tcp)
        return self


class StrutSensors(Part):
    """Six single-axis force sensors, one in each strut of the hexapod; a strut is a slender tube and a slender rod."""

    at: Literal["drive", "platform"]
    """The end of the rod where its sensor sits: between drive and rod, or between rod and platform joint."""
    each: bool = False
    """Whether every strut has parameters of its own; else all struts are alike."""
    rod_mass_kg: NonNegative
    """Mass of one rod, nominal like all that follows: predictions and simulated runs go by these values."""
    rod_first_moment_kg_m: NonNegative
    """First moment of the rod, from the platform joint towards the base joint."""
    tube_first_moment_kg_m: NonNegative
    """First moment of the tube, from the base joint towards the platform joint."""
    inertia_kg_m2: NonNegative
    """Sum of the moments of inertia of the rod about the platform joint and of the tube about the base joint."""
    viscous_friction_Nms: tuple[NonNegative, NonNegative] | None = None
    """Viscous friction in base and platform joints; part of the model where it is given."""
    coulomb_friction_Nm: tuple[NonNegative, NonNegative] | None = None
    """Friction in the same joints, independent of the speed; part of the model where it is given."""

    @property
    def carried_kg(self) -> float:
        """Mass of the rods beyond the sensors: forces count it as part of the body; 0 for sensors at the platform."""
        return 6.0 * self.rod_mass_kg if self.at == "drive" else 0.0


class SensorFrame(Part):
    """Where the forces are measured: a frame of bars, a force/torque sensor, or the struts; exactly one of them."""

    bars: Bars | None = None
    """Six bars with one force sensor each."""
    transducer: Transducer | None = None
    """A six-axis force/torque sensor."""
    struts: StrutSensors | None = None
    """Six force sensors in the struts."""

    @model_validator(mode="after")
    def _one_form(self) -> "SensorFrame":
        if sum(form is not None for form in (self.bars, self.transducer, self.struts)) != 1:
            raise ValueError(phrase("one_frame", "give one of bars, transducer and struts, not several or none"))
        return self

    @property
    def has_moments(self) -> bool:
        """Whether the last three channels are moments; else all six are forces."""
        return self.transducer is not None

    @property
    def structure(self) -> Array:
        """J^-T of (2), six sensor forces -> force and moment on the platform in {P}, shape (6, 6).

        Columns (n_k; h_k x n_k) of bars [-, m], n_k along bar k from its lower point h_k to its upper one (back, where
        tension is positive); 1 of a sensor that reads the support's push, -1 of one that reads the load's pull. Raises
        ValueError for sensors in struts.
        """
        if self.bars is not None:
            direction = self.bars.directions
            return np.vstack([direction.T, np.cross(self.bars.lower.points, direction).T])
        if self.transducer is None:
            raise ValueError("the structure matrix of sensors in struts depends on the pose: `strut_sensors.structure`")
        return np.eye(6) * self.transducer.sign

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the columns of what it measures."""
        return WRENCH if self.has_moments else BAR_FORCES

    @property
    def units(self) -> tuple[str, ...]:
        """SI units of the channels, in their order."""
        return ("N",) * 3 + ("N m" if self.has_moments else "N",) * 3


class PoseField(NamedTuple):
    """Force errors that depend on the pose: a random field over the struts' lengths."""

    size: float  # standard deviation of a channel's error [N]
    length: float  # distance in the space of the six strut lengths at which errors are half alike [m]

    @property
    def keys(self) -> dict[str, float]:
        """Size and length by the keys of `[sensors]`."""
        return {"pose_error_N": float(f"{self.size:.3g}"), "pose_error_length_mm": float(f"{self.length / MM:.3g}")}

    @property
    def words(self) -> str:
        """Size and length in words."""
        return f"{self.size:.3g} N over {self.length / MM:.3g} mm of strut lengths"


class Sensors(Part):
    """Properties of the six channels."""

    range_N: Positive | None = None
    """Largest force that a sensor measures; plans use 80 % of it at most."""
    range_Nm: Positive | None = None
    """Largest moment that a force/torque sensor measures; the number of `range_N` unless given."""
    weights: Literal["equal", "per_channel", "per_unit", "stated"]
    """`equal`: W = 1 (identical sensors); `per_channel`: W from the residual variance of each channel; `per_unit`: from
    that of all forces and that of all moments (a force/torque sensor whose residuals are more than its noise);
    `stated`: from the noise of forces and accelerations that is stated here, through the model."""
    force_noise_N: Positive | None = None
    """Standard deviation of white noise on a force, of one recorded sample."""
    moment_noise_Nm: Positive | None = None
    """The same on the moments of a force/torque sensor; the two are given together."""
    acceleration_noise_m_s2: Positive | None = None
    """Standard deviation of white accelerations of the origin of {P} that the recorded struts do not show, of one
    recorded sample and in each direction: vibration of the structure."""
    angular_acceleration_noise_rad_s2: Positive | None = None
    pose_error_N: Positive | None = None
    """Standard deviation of force errors that depend on the pose (of encoders, joints, frame), in each sensor; given
    together with their length."""
    pose_error_length_mm: Annotated[float, Field(strict=True, ge=LEAST_LENGTH_MM, le=MOST_LENGTH_MM)] | None = None
    """Distance in the space of the six strut lengths, the root of the sum of squares, at which they are half alike."""

    @property
    def range(self) -> Array | None:
        """Largest force or moment of each channel, shape (6,) [N, or N and N m]; None where the case does not say."""
        if self.range_N is None:
            return None
        return frozen([self.range_N] * 3 + [self.range_Nm or self.range_N] * 3)

    @property
    def force_noise(self) -> Array | None:
        """Standard deviation of each channel, shape (6,) [N, or N and N m]; None where the case states none."""
        if self.force_noise_N is None:
            return None
        others = self.force_noise_N if self.moment_noise_Nm is None else self.moment_noise_Nm
        return frozen([self.force_noise_N] * 3 + [others] * 3)

    @property
    def acceleration_noise(self) -> Array | None:
        """Standard deviation of each component of the twist rate, shape (6,) [m/s^2, rad/s^2]; None where none is."""
        if self.acceleration_noise_m_s2 is None and self.angular_acceleration_noise_rad_s2 is None:
            return None
        return frozen([self.acceleration_noise_m_s2 or 0.0] * 3 + [self.angular_acceleration_noise_rad_s2 or 0.0] * 3)

    @property
    def pose_field(self) -> PoseField | None:
        """Errors that depend on the pose; None where the case states none."""
        if self.pose_error_N is None or self.pose_error_length_mm is None:
            return None
        return PoseField(self.pose_error_N, self.pose_error_length_mm * MM)


class RigidBody(Part):
    """Mass, centre of gravity in {P} and inertia about the centre of gravity, axes of {P}."""

    mass_kg: Positive
    """Mass."""
    centre_of_gravity_mm: Vector
    """Centre of gravity in {P}."""
    inertia_kg_m2: Six
    """I11, I12, I13, I22, I23, I33 as in (17)."""

    @model_validator(mode="after")
    def _physical(self) -> "RigidBody":
        i11, i12, i13, i22, i23, i33 = self.inertia_kg_m2
        principal = np.linalg.eigvalsh([[i11, i12, i13], [i12, i22, i23], [i13, i23, i33]])
        if principal[0] <= 0.0 or principal[0] + principal[1] < principal[2] * (1.0 - 1e-9):
            raise ValueError(
                phrase(
                    "no_such_inertia",
                    "no rigid body has the principal inertias {values} kg m^2; all must be positive and none larger "
                    "than the sum of the others",
                    values=", ".join(f"{i:.4g}" for i in principal),
                ).about("inertia_kg_m2")
            )
        return self

    centre_of_gravity: ClassVar = si("centre_of_gravity_mm")  # centre of gravity in {P}, shape (3,) [m]

    @cached_property
    def inertia(self) -> Array:
        """Inertia tensor about the centre of gravity, shape (3, 3) [kg m^2]."""
        i11, i12, i13, i22, i23, i33 = self.inertia_kg_m2
        return frozen([[i11, i12, i13], [i12, i22, i23], [i13, i23, i33]])


def rigid_body(mass: float, centre: Array, inertia: Array) -> RigidBody:
    """A body of SI values: centre of gravity, shape (3,), and inertia about it, shape (3, 3)."""
    x, y, z = (float(v / MM) for v in centre)
    i11, i12, i13, i22, i23, i33 = (float(inertia[i, j]) for i in range(3) for j in range(i, 3))
    return RigidBody(mass_kg=mass, centre_of_gravity_mm=(x, y, z), inertia_kg_m2=(i11, i12, i13, i22, i23, i33))


def together(first: RigidBody, second: RigidBody) -> RigidBody:
    """Two bodies fixed to each other, as one: parallel axes."""
    mass = first.mass_kg + second.mass_kg
    centre = (first.mass_kg * first.centre_of_gravity + second.mass_kg * second.centre_of_gravity) / mass
    inertia = np.zeros((3, 3))
    for body in (first, second):
        arm = body.centre_of_gravity - centre
        inertia += body.inertia + body.mass_kg * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return rigid_body(mass, centre, inertia)


class Compensation(Part):
    """Factors k0..k3 of the platform's elastic deformation, (13) and (15) with the units of CONVENTIONS."""

    k0_N_m: Number
    """Force for each metre of displacement in x and y."""
    k1_Nm_m: Number
    """Moment for each metre of displacement in x and y."""
    k2_N: Number
    """Force for each radian of tilt."""
    k3_Nm: Number
    """Moment for each radian of tilt."""


class Truth(Part):
    """All parameters that the simulated machine has."""

    body: RigidBody
    """Mass, centre of gravity and inertia of what moves; those that are not stated are the ones of `[nominal]`."""
    offsets_N: Six
    """What the six sensors read without a load."""
    compensation: Compensation = Compensation(k0_N_m=0.0, k1_Nm_m=0.0, k2_N=0.0, k3_Nm=0.0)
    """Factors of the elastic deformation."""


class Simulation(Part):
    """The simulated machine: its parameters and how imperfectly it measures."""

    source: Text
    """Where the values come from."""
    parameters: Truth
    """The true parameters."""
    encoder_resolution_um: NonNegative
    """Step of the encoders of struts, and of joints that slide."""
    encoder_resolution_mdeg: NonNegative = 0.0
    """Step of the encoders of joints that turn."""
    force_noise_N: NonNegative
    """Standard deviation of white noise on a force sample."""
    moment_noise_Nm: NonNegative | None = None
    """Standard deviation on a moment of a force/torque sensor; the number of `force_noise_N` unless given."""
    force_delay_ms: NonNegative
    """Time by which forces are recorded later than the motion."""
    force_sampling_offset_cycles: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.0
    """Where between two samples of the struts the forces are sampled, as a share of the time between them."""
    encoder_rate_Hz: Positive
    """Samples of the struts per second."""
    acceleration_noise_m_s2: NonNegative = 0.0
    """White accelerations of the platform beside those of the struts, as in `Sensors`."""
    angular_acceleration_noise_rad_s2: NonNegative = 0.0
    disturbances: Disturbances | None = None
    """Disturbances of the structure; runs are simulated with them where that is asked for, as a validation does."""

    encoder_resolution: ClassVar = si_value("encoder_resolution_um")  # step of the encoders of drives that slide [m]
    force_delay: ClassVar = si_value("force_delay_ms")  # time by which forces are recorded later than the motion [s]

    @property
    def turning_resolution(self) -> float:
        """Step of the encoders of joints that turn [rad]."""
        return self.encoder_resolution_mdeg * MM * DEG

    @property
    def force_noise(self) -> Array:
        """Standard deviation of each channel, shape (6,) [N, or N and N m]."""
        moments = self.force_noise_N if self.moment_noise_Nm is None else self.moment_noise_Nm
        return frozen([self.force_noise_N] * 3 + [moments] * 3)

    @property
    def acceleration_noise(self) -> Array:
        """Standard deviation of each component of the twist rate, shape (6,) [m/s^2, rad/s^2]."""
        return frozen([self.acceleration_noise_m_s2] * 3 + [self.angular_acceleration_noise_rad_s2] * 3)


class Payloads(Part):
    """Known weights that are mounted one after the other to validate an identification."""

    source: Text
    """Where the values come from."""
    weights: Annotated[tuple[RigidBody, ...], Field(min_length=1)]
    """Weights in order of mounting; centres of gravity in {P}."""


def payload_words(count: int) -> Phrase:
    """How many payloads are mounted, in words."""
    if count == 1:
        return phrase("one_payload", "1 payload")
    return phrase("payloads", "{count} payloads", count=count)
