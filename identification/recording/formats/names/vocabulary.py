"""Words of recorders, in English and German: what a column's name says by each of them."""

from collections.abc import Iterable
from dataclasses import dataclass

from cases.base.phrases import OPEN, Phrase, phrase


@dataclass(frozen=True, slots=True)
class Words:
    """Words that say a thing: whole ones, and parts of longer ones."""

    whole: frozenset[str]
    parts: tuple[str, ...] = ()

    def among(self, words: Iterable[str]) -> bool:
        """Whether one of some words says the thing."""
        return any(word in self.whole or any(part in word for part in self.parts) for word in words)

    def __contains__(self, word: str) -> bool:
        """Whether a word says the thing."""
        return self.among([word])


def words(whole: str, parts: str = "") -> Words:
    """Words from two lists with blanks between them."""
    return Words(frozenset(whole.split()), tuple(parts.split()))


# What a column holds instead of a reading: set points, errors, statistics, what is added or taken off.
NO_READING = words(
    "soll set sp cmd ref des dem goal sol as err dif diff dev lag std rms min max lim seq mode flag valid d cov "
    "frame name id counter fault gain w ff",
    "soll target command setp desired refer demand planned nominal predict error fehler deviat abweich follow schlepp "
    "offset bias limit status gravit stiff damp",
)
SPEED = words("v vel qd dq dl ld dp dx speed feed twist omega rpm", "velo speed geschw drehzahl jerk ruck")
ACCELERATION = words("acc qdd ddq ldd ddl", "accel beschl")
EFFORT = words("tau trq mom curr amp amps i power load", "effort torque moment current strom leistung power auslast")
OTHER = words("temp volt humidity druck", "temper voltage spannung battery pressure")
POSITION = words("pos q angle angles winkel lage weg theta qpos", "position istpos lageist angle")
DRIVE = words(
    "joint joints j axis achse axes drive antrieb motor actuator aktor enc encoder jnt gelenk gelenke",
    "encod antrieb gelenk",
)
STRUT = words("strut struts leg legs bein beine strebe streben l len length laenge länge", "strut streb")
FORCE = words("f fs lc dms cell cells", "force kraft kräfte loadcell wägezelle messdose")
WRENCH = words("wrench ft fts netft tcpf", "wrench")
MEASURED = words("act ist fb meas msr real raw ai aa va im iw", "actual istw feedb measur gemess present roh")
RAW = words("raw unfiltered", "roh")
FILTERED = words("lp", "filter smooth glatt")
NEUTRAL = words(
    "s u states robot arm data field value values val main plc nc to lbr iiwa the of number nr no j a app "
    "application prg program gvl deg rad mm meas can ec r rob"
)
"""Words that say neither what a column of a drive holds, nor that it is something else."""

FORCE_AXIS = words("f force forces kraft fs kräfte")
MOMENT_AXIS = words("m t torque torques moment moments mom tau drehmoment tq trq momente")
TURN_AXIS = words("r rot rotation rotvec rotations orientation quat quaternion euler rpy")
ACCELERATION_AXIS = words("a acc accel accelerometer acceleration beschleunigung")
SPEED_AXIS = words("v vel velocity w omega speed gyro angular linear twist")
PLACE_AXIS = words("pos position tcp pose p translation trans istposition lage ee")

NOT_OF_A_SENSOR = words(
    "ext est hat comp tcp contact tared zeroed cart", "external extern compens kompens estimat unbias contact"
)
"""Words that say of a wrench that it is computed from readings, or estimated."""
_ESTIMATED = phrase(
    "estimated_wrench", "an external wrench that {who} estimates from the torques of the joints", who=OPEN
)
_ON_THE_FLANGE = phrase("sensor_on_flange", "record a sensor on the flange")
_COMPUTED: tuple[tuple[frozenset[str], Phrase, Phrase], ...] = (
    (
        frozenset({"actual", "tcp", "force"}),
        phrase(
            "wrench_of_tcp",
            "a wrench that the controller of Universal Robots turns into the axes of the base, without the payload "
            "that is set, and zeroes",
        ),
        phrase("record_ft_raw", "record ft_raw_wrench"),
    ),
    (
        frozenset({"tcpf"}),
        phrase("force_at_tool", "the force at the tool, which a controller computes"),
        phrase("record_own_channels", "record the sensor's own channels, as ft_raw_wrench"),
    ),
    (frozenset({"ext", "hat"}), _ESTIMATED.filled(who="libfranka"), _ON_THE_FLANGE),
    (frozenset({"ext", "est"}), _ESTIMATED.filled(who="KUKA's FRI"), _ON_THE_FLANGE),
    (frozenset({"cart", "force"}), _ESTIMATED.filled(who="KUKA Sunrise"), _ON_THE_FLANGE),
    (frozenset({"cart", "torque"}), _ESTIMATED.filled(who="KUKA Sunrise"), _ON_THE_FLANGE),
)
"""Words of wrenches that are not readings, what they are, and what to record instead."""


def computed(said: Iterable[str]) -> tuple[Phrase, Phrase] | None:
    """What a wrench is that is not what a sensor reads, by the words of its name, and what to record instead.

    None: by its name it may be readings.
    """
    named = {*said}
    for of, what, remedy in _COMPUTED:
        if of <= named:
            return what, remedy
    if NOT_OF_A_SENSOR.among(named):
        computed_wrench = phrase("computed_wrench", "by its name a wrench that was computed from readings")
        return computed_wrench, phrase("record_raw_channels", "record the sensor's own, raw channels")
    return None


CLOCK = words(
    "t ts time zeit timestamp stamp zeitstempel elapsed millis micros uhrzeit datetime", "timestamp zeitstempel"
)
BESIDE_A_CLOCK = words(
    "default sample rate messrate standardmessrate schnelle langsame fast slow field header rel relative since start "
    "in s ms us ns sec secs nsec nsecs nano nanosec seconds robot sys system utc epoch unix elapsed the of x value "
    "wall ros run global date standardmessrates pc host iso local computer"
)
CLOCK_UNITS = {
    "millis": "ms", "micros": "us", "ns": "ns", "nsec": "ns", "nsecs": "ns", "nano": "ns", "nanosec": "ns", "ms": "ms",
    "us": "us", "sec": "s", "secs": "s", "seconds": "s",
}  # fmt: skip
"""Units that words of a clock's name say."""
