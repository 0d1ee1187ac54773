"""Settings of the case's controllers; anything uncertain is a required setting, never a guess."""

from enum import StrEnum
from typing import Annotated, ClassVar, Literal, TypeVar

from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from cases.base.phrases import phrase
from cases.base.units import DEG, MINUTE, MM
from cases.tables import Part, Positive, kind_of, si_value, spelled


class ControllerName(StrEnum):
    """Controllers that programs are written and plans are made for; the built-in one runs programs of all others."""

    VIRTUAL = "virtual"
    LINUXCNC = "linuxcnc"
    SINUMERIK = "sinumerik"
    TWINCAT = "twincat"
    SETPOINTS = "setpoints"
    URSCRIPT = "urscript"
    ROS2 = "ros2"


Kept = Literal["velocity", "acceleration", "jerk", "strut velocity", "strut acceleration"]


Promises = tuple[Kept, ...]
"""Families of limits; each covers translations and rotations. An empty list promises nothing."""


class UrScript(Part):
    """Settings of programs for robots of Universal Robots."""

    table: ClassVar = "urscript"

    program_name: Annotated[
        str,
        spelled(r"[A-Za-z][A-Za-z0-9_]{0,30}", phrase("a_ros_name", "a name: letters, digits and _, a letter first")),
    ]
    """Name of the function that the program is: letters, digits and underscores."""
    trigger_output: Annotated[int, Field(strict=True, ge=0, le=7)]
    """Standard digital output that is on while the excitation runs; RTDE records it with the robot's clock."""


RosName = Annotated[
    str, spelled(r"/?[A-Za-z_][A-Za-z0-9_]*(?:/[A-Za-z_][A-Za-z0-9_]*)*", phrase("name_of_ros", "a name of ROS"))
]


class Ros2(Part):
    """How `joint_trajectory_controller` is set up; a program for it needs none of this."""

    table: ClassVar = "ros2"

    controller: RosName = "joint_trajectory_controller"
    """Name of the controller."""
    joint_states: RosName = "/joint_states"
    """Topic of the joints' positions."""
    interpolation: Literal["splines", "none"] = "splines"
    """Its `interpolation_method`: `splines` joins points with accelerations by polynomials of degree five, in all
    releases that state accelerations; `none` (since Galactic) steps from point to point."""
    path_tolerance_deg: Positive | None = None
    """Its `constraints.<joint>.trajectory`: it stops where a joint is further off its path."""
    path_tolerance_mm: Positive | None = None
    goal_tolerance_deg: Positive | None = None
    """Its `constraints.<joint>.goal`."""
    goal_tolerance_mm: Positive | None = None
    goal_time_s: Positive | None = None
    """Its `constraints.goal_time`: how late the goal may be reached; not stated: it waits without end."""
    controller_keeps: Promises = ()
    """Limits that ros2_control enforces behind it (`enforce_command_limits`, limits of joints); by default none: the
    controller itself enforces none."""
    command_interfaces: tuple[Literal["position", "velocity", "acceleration", "effort"], ...] = ("position",)
    """Its `command_interfaces`. Without positions a control loop of its own follows the set points, more or less."""
    state_interfaces: tuple[Literal["position", "velocity", "acceleration"], ...] = ("position", "velocity")
    """Its `state_interfaces`: what the hardware states of a joint decides how smooth the way to the first point is."""
    interpolate_from_desired_state: Annotated[bool, Field(strict=True)] = False
    """Whether it starts from its last command (until 2025 `open_loop_control`), not from where the joints are."""
    decelerate_on_cancel: Annotated[bool, Field(strict=True)] = False
    """Its `constraints.decelerate_on_cancel`: whether it slows down where a motion is cancelled or leaves its path.
    That takes speeds among its `state_interfaces`, and `max_deceleration_on_cancel` above 0 of every joint."""
    speed_scaling: Annotated[bool, Field(strict=True)] = False
    """Whether a slider of speed stretches trajectories: a scaled controller, or `speed_scaling.state_interface`."""


class Setpoints(Part):
    """Settings of setpoint tables for external setpoint generation."""

    table: ClassVar = "setpoints"

    cycle_ms: Positive
    """Cycle of the task that feeds them: a whole multiple of the drives' own cycle."""
    most_rows: Annotated[int, Field(strict=True, ge=10)]
    """What its memory holds."""
    controller_keeps: Promises
    """Limits that it enforces; a generator that copies setpoints to the drives usually enforces none: `[]`."""

    cycle: ClassVar = si_value("cycle_ms")  # control cycle [s]


SHORTEST_NAME = 24
"""Characters that every controller takes in the name of a program."""
SLOW = "_SLOW"
"""How the name of a program at a share of its speed ends."""
SINUMERIK_NAME = r"^(?:[A-Z]{2}|_[A-Z])[A-Z0-9_]{0,22}$"
_KEYWORDS = ("LEAD", "TILT", "THETA", "PHI", "PSI", "AR", "CR", "PL", "PO", "PW", "SD", "ACC", "OVR")
_VECTORS = {f"{axis}{k}" for axis in "ABC" for k in range(3, 8)}  # they take components of vectors
_NOT_ANGLES = {*"DFGHIJKLMNPRSTXYZ", *_KEYWORDS, *_VECTORS}


def _angle_words(words: tuple[str, str, str]) -> tuple[str, str, str]:
    if len(set(words)) < 3 or _NOT_ANGLES & set(words):
        raise ValueError(
            phrase(
                "not_three_angles",
                "{words} do not name three angles; write those of roll, pitch, yaw: A2, B2, C2",
                words=", ".join(words),
            )
        )
    return words


Word = Annotated[
    str, spelled(r"[A-Z]{1,7}[0-9]?", phrase("a_word", "a word: one to seven capitals, a digit may follow"))
]
Call = Annotated[
    str,
    spelled(r"[A-Z][A-Z0-9_]*(?:\([0-9](?:,[0-9])*\))?", phrase("a_command", "a command such as TRAORI or TRAORI(1)")),
]
AngleWords = Annotated[tuple[Word, Word, Word], AfterValidator(_angle_words)]


class BlockMemory(Part):
    """What controllers that read programs block by block hold, and keep by themselves."""

    shortest_block_ms: Positive
    """The controller's cycle, or block cycle time: shorter blocks starve it."""
    most_blocks: Annotated[int, Field(strict=True, ge=10)]
    """What its program memory holds."""
    controller_keeps: Promises
    """Limits that the controller keeps by itself in what it times; what is not named here is `NOT enforced`."""


class SinumerikAxes(BlockMemory):
    """Settings of SINUMERIK programs in the machine's own axes, of a chain that is named as they are."""

    table: ClassVar = "sinumerik"

    program_name: Annotated[
        str, spelled(SINUMERIK_NAME, phrase("name_of_sinumerik", "a name of a SINUMERIK program such as EXCITE_1"))
    ]
    """Internal name: 2 to 24 capitals, digits and underscores that begin with two letters or `_` and a letter."""
    trigger_output: Annotated[int, Field(strict=True, ge=1, le=1024)]
    """Number of the digital output $A_OUT that a synchronised action switches."""
    trace: Annotated[bool, Field(strict=True)] = False
    """Whether the program starts and stops the control's trace, by $AN_SLTRACE = 1 and 2. The session must be prepared
    at the control, with this variable as its start and stop trigger, and be armed."""


class Sinumerik(SinumerikAxes):
    """Settings of SINUMERIK programs. The transformation of a hexapod is the machine builder's: ask for these words."""

    transformation: Call
    """What switches the transformation on: `TRAORI`, `TRAORI(2)` or the builder's own name."""
    transformation_off: Call
    """What switches it off."""
    orientation_words: AngleWords
    """Roll, pitch, yaw in blocks: `A2 B2 C2` (written `A2=`, read under ORIRPY), or `A B C` if the transformation
    takes the angles as axes."""
    orientation_axes: AngleWords
    """Names of the axes behind them, for FGROUP( ) and PO[ ]."""
    path: Literal["poly", "lines"]
    """Motions that are not straight moves: polynomial blocks (POLY), or dense G1 with the compressor COMPCAD."""
    poly_degree: Literal[3, 5]
    """Degree of the polynomials that the controller takes."""
    poly_axes: Annotated[int, Field(strict=True, ge=1, le=9)]
    """Most axes that one POLY block may hold; fewer than six cannot carry a hexapod's motion."""
    poly_block_ms: Positive
    """Longest POLY block. Shorter blocks leave the controller less to decide, and cost it more of them a second."""
    poly_tolerance_mm: Positive
    """Largest distance of POLY blocks from a motion that no polynomial of their degree describes."""
    poly_tolerance_deg: Positive
    contour_tolerance_mm: Positive
    """CTOL of the compressor."""
    orientation_tolerance_deg: Positive
    """OTOL of the compressor."""

    @property
    def poly_tolerance(self) -> tuple[float, float]:
        """Tolerances of POLY blocks: positions [m] and angles [rad]."""
        return self.poly_tolerance_mm * MM, self.poly_tolerance_deg * DEG


TWINCAT_NAME = r"^[A-Za-z0-9_][A-Za-z0-9_.-]{0,62}$"
_TAKEN = {0, 1, 2, 3, 4, 5, 6, 17, 19, 29, 30}


def _free(number: int) -> int:
    if number in _TAKEN:
        raise ValueError(
            phrase(
                "m_taken", "M{number} means something else to the controller; choose a user M function", number=number
            )
        )
    return number


MFunction = Annotated[int, Field(strict=True, ge=7, le=999), AfterValidator(_free)]


class TwinCatAxes(BlockMemory):
    """Settings of TF5200 / ISG programs in the machine's own axes, of a chain that is named as they are."""

    table: ClassVar = "twincat"

    program_name: Annotated[
        str, spelled(TWINCAT_NAME, phrase("name_of_twincat", "a name of a TwinCAT program such as EXCITE_1"))
    ]
    """Name in the `%` line."""
    slope: Literal["STEP", "TRAPEZ"]
    """`#SLOPE TYPE`: TRAPEZ limits the jerk, STEP does not."""
    trigger_on_m: MFunction
    """M functions that the PLC makes the trigger's two ends of; they need a synchronisation type (P-CHAN-00041)."""
    trigger_off_m: MFunction

    @model_validator(mode="after")
    def _two_functions(self) -> "TwinCatAxes":
        if self.trigger_on_m == self.trigger_off_m:
            raise ValueError(
                phrase(
                    "m_twice",
                    "trigger_on_m and trigger_off_m are both {number}; give two M functions",
                    number=self.trigger_on_m,
                ).about("trigger_on_m", "trigger_off_m")
            )
        return self


class TwinCat(TwinCatAxes):
    """Settings of TF5200 / ISG programs. Channel parameters are named as in Beckhoff's manuals."""

    kinematic_id: Annotated[int, Field(strict=True, ge=1, le=999)]
    """Of the hexapod's transformation: no manual names one, it is what `trafo[i].id` says."""
    angle_sign_b: Literal[-1, 1]
    """-1: B turns negatively, R = Rz(C) Ry(-B) Rx(A) (P-CHAN-00112 = 0, the default). +1: the kinematics takes the
    angles as R = Rz(C) Ry(B) Rx(A). Try it with a single small B before anything else."""
    path: Literal["akima", "hsc", "contour"]
    """Dense paths: `#SPLINE TYPE AKIMA` through the points, `#HSC ON [BSPLINE ..]` or `#CONTOUR MODE [DEV ..]` near
    them."""
    path_deviation_mm: Positive
    """PATH_DEV of `#HSC` and `#CONTOUR MODE`."""
    track_deviation_deg: Positive
    """TRACK_DEV of `#HSC` and `#CONTOUR MODE`."""


LEAST_PATH_JERK = 1.0  # [mm/s^3] LinuxCNC 2.10 falls back to trapezoids below it


class LinuxCnc(Part):
    """Settings of the LinuxCNC configuration that is generated from the case."""

    table: ClassVar = "linuxcnc"

    acceleration_headroom: Positive
    """The controller's acceleration limits as a multiple of `[limits.motion]`. LinuxCNC has no look-ahead for paths
    that turn: at 1 it stretches dense paths; far above 1 it runs in the program's time, and only the program's proof
    ensures the limits."""
    planner: Literal["trapezoidal", "s_curve"] = "trapezoidal"
    """`[TRAJ]PLANNER_TYPE` of the machine: `trapezoidal` (0, that of all versions), or `s_curve` (1, since 2.10), which
    limits jerk along the path and, by `MAX_JERK` of `[AXIS_a]`, that of each axis. Programs for it are straight moves
    from rest to rest; no program was tried on it."""
    max_linear_jerk_mm_s3: Annotated[float, Field(strict=True, ge=LEAST_PATH_JERK)] | None = None
    """`s_curve`: `[TRAJ]MAX_LINEAR_JERK`, along X, Y, Z together, in deg/s^3 along A, B, C where these alone move.
    Below 1 LinuxCNC runs trapezoids."""

    @model_validator(mode="after")
    def _jerk_of_its_planner(self) -> "LinuxCnc":
        smooth, stated = self.planner == "s_curve", self.max_linear_jerk_mm_s3 is not None
        if smooth and not stated:
            raise ValueError(
                phrase(
                    "needs_linear_jerk",
                    "max_linear_jerk_mm_s3 is missing; state [TRAJ]MAX_LINEAR_JERK of the machine's INI file, which "
                    'planner = "s_curve" keeps',
                ).about("planner")
            )
        if stated and not smooth:
            raise ValueError(
                phrase(
                    "linear_jerk_alone",
                    'max_linear_jerk_mm_s3 goes with planner = "s_curve"; remove it, or state that planner',
                ).about("max_linear_jerk_mm_s3", "planner")
            )
        return self


Settings = TypeVar("Settings", LinuxCnc, SinumerikAxes, TwinCatAxes, Setpoints, UrScript, Ros2)


class Controller(Part):
    """Settings of programs."""

    block_ms: Positive
    """Duration of the blocks that a dense path is written in."""
    safe_feed_mm_min: Positive | None = None
    """Feed of the first move of a hexapod, at most, in a program that checks no place."""
    safe_speed_percent: Annotated[Positive, Field(le=100.0)] = 10.0
    """Share of the speeds and accelerations of `[limits.motion]` for a chain's first move in a program that checks no
    place."""
    settle_s: Positive
    """Stood still before the trigger goes on and after it went off."""
    cycle_ms: Positive = 1.0
    """The controller's interpolation cycle. Phases of planned moves last three of them or more."""
    most_override_percent: Annotated[Positive, Field(le=1000.0)] | None = None
    """Largest feed override that an operator can turn. Proofs hold up to 100 %: unless this key says that the knob ends
    there, programs for LinuxCNC switch the override off, and those for SINUMERIK and TwinCAT come with a remark."""
    plan_for: Annotated[ControllerName, WithJsonSchema({"enum": [*ControllerName], "type": "string"})] | None = None
    """The controller whose time law point-to-point plans are made for (`hexcite plan --for`). Without it all limits of
    `[limits.motion]` count, those of jerk too."""
    linuxcnc: LinuxCnc | None = None
    """Programs with timed blocks run under this multiple of the acceleration limits: 1 stretches dense paths, far above
    1 they run in their own time, and only the program's proof ensures the limits."""
    sinumerik: Annotated[Sinumerik | SinumerikAxes, kind_of(Sinumerik, SinumerikAxes)] | None = None
    """Settings of SINUMERIK programs."""
    twincat: Annotated[TwinCat | TwinCatAxes, kind_of(TwinCat, TwinCatAxes)] | None = None
    """Settings of TwinCAT CNC (TF5200) and ISG programs."""
    setpoints: Setpoints | None = None
    """Settings of tables of set points."""
    urscript: UrScript | None = None
    """Settings of URScript programs."""
    ros2: Ros2 | None = None
    """How the controller of joint trajectories is set up; none of it is needed."""

    cycle: ClassVar = si_value("cycle_ms")  # interpolation cycle [s]
    block: ClassVar = si_value("block_ms")  # duration of a block on a timed path [s]

    def named_slow(self) -> "Controller":
        """The same with `_SLOW` behind the names of programs, which are cut where a controller takes no longer ones."""
        named = {part.table: part for part in (self.sinumerik, self.twincat, self.urscript) if part is not None}
        names = {table: f"{part.program_name[: SHORTEST_NAME - len(SLOW)]}{SLOW}" for table, part in named.items()}
        parts = {table: part.model_copy(update={"program_name": names[table]}) for table, part in named.items()}
        return self.model_copy(update=parts)

    @property
    def overdriven(self) -> bool:
        """Whether an operator may turn the feed override above 100 %."""
        return self.most_override_percent is None or self.most_override_percent > 100.0

    @property
    def safe_feed(self) -> float:
        """Most for the feed of a first move of a hexapod from anywhere [m/s]; its case states one."""
        assert self.safe_feed_mm_min is not None
        return self.safe_feed_mm_min * MM / MINUTE

    @property
    def safe_share(self) -> float:
        """Share of the limits of motion that the first move of a chain may use."""
        return self.safe_speed_percent / 100.0
