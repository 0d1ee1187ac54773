"""What the columns of a file mean by their names: the quantity that a family says, and which family is chosen.

Names say what is a set point, a speed or a torque of a joint as well as what is a position. A family has a meaning only
if its words say one, if it has as many columns as the machine has of that, and if no other family says the same. Where
two do, neither has a meaning, and a sentence names both.
"""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import NamedTuple

from cases.base.phrases import Phrase, enumerated, phrase
from cases.base.unit_names import ANGLES as ANGLE_UNITS
from cases.base.unit_names import FORCES, LENGTHS, MOMENTS
from cases.machine import POSE
from cases.orientation import ANGLES, QUATERNION, ROTATION
from cases.recording_format import (
    ACCELEROMETER,
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    DRIVES,
    OVERRIDE,
    ROLE_OF,
    ROLE_UNITS,
    STRUTS,
    TRIGGER,
    WRENCH,
    Role,
)
from cases.schema import Case
from identification.recording.formats.names import vocabulary as say
from identification.recording.formats.names.families import AXES, AXIS, JOINT, NUMBER, Family, families, words_of
from identification.recording.formats.names.labels import is_count, stated_unit, without_brackets

Group = tuple[str, ...]
_GROUPS: tuple[Group, ...] = (
    STRUTS, DRIVES, POSE, QUATERNION, ROTATION, ACCELEROMETER, BAR_FORCES, WRENCH, (CLOCK,), (TRIGGER,), (OVERRIDE,)
)  # fmt: skip
"""Columns that belong together: one of them is nothing without the others."""


@dataclass(frozen=True, slots=True)
class Meaning:
    """What the columns of a file mean."""

    places: Mapping[str, int]  # our name -> position in the file
    clocks: tuple[int, ...]  # positions of what may be the clock, the best first
    orientations: tuple[str, ...]  # conventions that the angles, or the quaternion, may have by their names
    candidates: Mapping[str, tuple[int, ...]]  # our name of a single column -> positions of what it may be
    doubts: tuple[Phrase, ...]  # what the names leave open, a sentence each


def meaning_of(names: Sequence[str], case: Case | None = None, units: Sequence[str] = ()) -> Meaning:
    """What the columns of a file mean by their names.

    Args:
        names: as the file has them; a column without a name is empty.
        units: what a row of units says of each, or empty.
        case: the machine: how many joints it has and what they are called, and what its sensors measure.
    """
    ours = {name: k for k, name in reversed([*enumerate(names)]) if name in COLUMNS}
    places = {name: ours[name] for group in groups_of(case) if all(n in ours for n in group) for name in group}
    words = {k: words_of(name) for k, name in enumerate(names) if name and name not in COLUMNS}
    groups = [*families(words, None if case is None or case.chain is None else case.chain.names)]
    doubts: list[Phrase] = []
    quantities = {k: _quantities(names[k], units[k] if k < len(units) else "") for k in words}
    for columns, readings in _readings(groups, quantities, case):
        if not any(column in places for column in columns):
            positions = {*places.values()}
            free = [r for r in readings if not positions & {*r.members} and _fits(columns, r, quantities)]
            places |= _best(columns, free, names, doubts)
    if not {*BAR_FORCES, *WRENCH} & {*places}:
        places |= _forces_in_odd_units(names, quantities, {*places.values()}, case, doubts)
    doubts += _other_count(groups, places, names, case)
    if case is None:
        doubts += _without_a_machine(groups, places, names)
    orientations: tuple[str, ...] = ()
    if not {*places} & {*STRUTS, *DRIVES, *POSE, *_joints(case)}:
        own = next((group for group in (QUATERNION, ROTATION, ANGLES) if all(name in ours for name in group)), ())
        position = {name: ours[name] for name in POSE[:3]} if all(name in ours for name in POSE[:3]) else {}
        position = position or _place(groups, _readable(words))
        if not own:
            pose, orientations = _pose(groups, words, quantities, case, position)
            places |= pose
            doubts += [] if pose else _sixteen(groups, names)
        elif case is not None and case.hexapod is not None:
            places |= {name: ours[name] for name in own} | position
    clocks = sorted((k for k, of in words.items() if _is_clock(of)), key=lambda k: _clock_rank(words[k]))
    clocks = [*([places[CLOCK]] if CLOCK in places else []), *clocks]
    single = {TRIGGER: _is_trigger, OVERRIDE: _is_override}
    candidates = {
        column: tuple(k for k, of in words.items() if says(of))
        for column, says in single.items()
        if column not in places
    }
    positions = {*places.values()}
    doubts += [s for family in groups if not positions & {*family.members.values()} for s in _computed(family, names)]
    return Meaning(places, tuple(clocks), orientations, candidates, tuple(dict.fromkeys(doubts)))


def known_among(names: Sequence[str]) -> int:
    """How many names of columns say something, whatever the machine is."""
    meaning = meaning_of(names)
    drives = {k for f in families({k: words_of(name) for k, name in enumerate(names)}) if [*_as_joints(f, False)]
              for k in f.members.values()}  # fmt: skip
    return len(
        {*meaning.places.values(), *meaning.clocks, *drives, *(k for of in meaning.candidates.values() for k in of)}
    )


def _joints(case: Case | None) -> Group:
    return () if case is None or case.chain is None else case.chain.columns


def groups_of(case: Case | None) -> Iterator[Group]:
    """Our names in groups of which one is nothing without the others, as a machine may have them."""
    yield from ([_joints(case)] if _joints(case) else [STRUTS, DRIVES])
    yield from (group for group in _GROUPS if group not in (STRUTS, DRIVES))


class _Reading(NamedTuple):
    """A family, or two that belong together, read as a group of columns."""

    members: tuple[int, ...]  # positions in the file, in the order of the group
    rank: tuple[int, ...]  # the smaller, the more its words say so


_ANY = "any"  # of counts and volts, which have the quantity of the channel by a factor


def _quantities(name: str, cell: str) -> frozenset[str]:
    """The quantities that the unit of a column may be of; none where it states no unit."""
    stated = [(units.quantity, stated_unit(name, cell, units)) for units in (LENGTHS, ANGLE_UNITS, FORCES, MOMENTS)]
    if known := frozenset(quantity for quantity, unit in stated if unit is not None and unit.symbol is not None):
        return known
    texts = {unit.text for _, unit in stated if unit is not None} - {*"ABCUVW"}  # of axes rather than ampere and volt
    by_factor = any(is_count(text) or text in ("V", "mV", "uV", "mV/V", "uV/V") for text in texts)
    return frozenset({_ANY} if by_factor else {"another"} if texts else ())


def _fits(columns: Group, reading: "_Reading", quantities: Mapping[int, frozenset[str]]) -> bool:
    """Whether the units that a file states are of what the columns hold."""
    for ours, k in zip(columns, reading.members, strict=True):
        role = ROLE_OF.get(ours)
        stated = quantities.get(k, frozenset())
        if role is not None and stated and not stated & {ROLE_UNITS[role].quantity, _ANY}:
            return role in (Role.FORCES, Role.MOMENTS) and stated == {"another"}  # the reader says that it is unknown
    return True


def _other_count(
    found: Sequence[Family], places: Mapping[str, int], names: Sequence[str], case: Case | None
) -> Iterator[Phrase]:
    """What to say of the joints of another robot than that of the case."""
    joints, used = _joints(case), {*places.values()}
    if not joints or joints[0] in places:
        return
    for family in found:
        members = [*family.members.values()]
        if NUMBER in family.words and len(members) >= 3 and len(members) != len(joints) and not used & {*members}:
            for _ in _as_joints(family, False):
                yield phrase(
                    "other_joint_count",
                    "{columns} look like positions of {count} joints, the machine of the case has {own}",
                    columns=span([names[k] for k in members]),
                    count=len(members),
                    own=len(joints),
                )


def _readings(
    found: Sequence[Family], quantities: Mapping[int, frozenset[str]], case: Case | None
) -> Iterator[tuple[Group, list[_Reading]]]:
    """What may be each group of columns."""
    numbered = [family for family in found if NUMBER in family.words]
    vectors = [family for family in found if family.axis is not None]
    six = [family for family in numbered if len(family.members) == len(STRUTS)]
    if joints := _joints(case):
        named = [reading for family in found if JOINT in family.words for reading in _as_joints(family, True)]
        counted = [family for family in numbered if len(family.members) == len(joints)]
        axes = ("a",)  # of KUKA: A1 to A6
        yield joints, named or [reading for family in counted for reading in _as_joints(family, family.rest == axes)]
    else:
        yield STRUTS, [reading for family in six for reading in _as_struts(family)]
    if case is not None and not joints:
        yield DRIVES, [reading for family in six for reading in _as_joints(family, False)]
    transducer = case is not None and case.sensor_frame.channels == WRENCH
    if case is None or transducer:
        yield WRENCH, [*_wrenches(vectors), *(r for family in six for r in _as_wrench(family, transducer))]
    if case is None or not transducer:
        bars = [reading for family in six for reading in _as_bars(family)]
        yield BAR_FORCES, bars or [r for family in six for r in _by_unit(family, "force", quantities)]
    of_acceleration = [family for family in vectors if _quantity(family) == "acceleration"]
    yield ACCELEROMETER, [_reading(f) for f in of_acceleration if not say.NO_READING.among(f.rest)]


def _forces_in_odd_units(
    names: Sequence[str],
    quantities: Mapping[int, frozenset[str]],
    used: Set[int],
    case: Case | None,
    doubts: list[Phrase],
) -> dict[str, int]:
    """Forces by their names without what stands in brackets, where that is a unit of another kind, as in `F1 [N rms]`.

    The reader names the unit then. Columns in units of forces whose names say that they are no readings are a doubt.
    """
    bare = {k: words_of(without_brackets(names[k])) for k, said in quantities.items() if said == {"another"}}
    places: dict[str, int] = {}
    for columns, readings in _readings([*families(bare)], {}, case):
        if columns in (BAR_FORCES, WRENCH) and not places:
            places = _best(columns, [r for r in readings if not used & {*r.members}], names, doubts)
    of_forces = [k for k, said in quantities.items() if said == {FORCES.quantity} and k not in used]
    for family in families({k: words_of(names[k]) for k in of_forces}):
        word = next((word for word in family.rest if word in say.NO_READING), None)
        if word is not None and len(family.members) in (len(AXES), len(BAR_FORCES)) and not places:
            doubts.append(
                phrase(
                    "no_readings_by_name",
                    "{columns} have units of forces, but by {word} they are not readings; if they are, name them in "
                    "[recording.columns]",
                    columns=span([names[k] for k in family.members.values()]),
                    word=repr(word),
                )
            )
    return places


def _best(columns: Group, readings: Sequence[_Reading], names: Sequence[str], doubts: list[Phrase]) -> dict[str, int]:
    """The reading whose words say most; none where there is none, or where two say as much, which is a doubt."""
    ranked = sorted(
        {reading.members: reading for reading in sorted(readings, key=_rank_of, reverse=True)}.values(), key=_rank_of
    )
    best = [reading for reading in ranked if reading.rank == ranked[0].rank]
    if len(best) > 1:
        several = enumerated("or", [span([names[k] for k in reading.members]) for reading in best])
        doubts.append(
            phrase(
                "may_be_several",
                "{columns} may be {several}: name those that they are in [recording.columns]",
                columns=span(columns),
                several=several,
            )
        )
    return dict(zip(columns, best[0].members, strict=True)) if len(best) == 1 else {}


def _rank_of(reading: _Reading) -> tuple[int, ...]:
    return reading.rank


def span(names: Sequence[str]) -> str:
    """The first and the last of some names."""
    return names[0] if len(names) == 1 else f"{names[0]} .. {names[-1]}"


def _reading(family: Family, *more: int) -> _Reading:
    """A family read as it stands, ranked by how much its words say that it is measured, and raw."""
    rest = family.rest
    rank = say.FILTERED.among(rest), not say.RAW.among(rest), not say.MEASURED.among(rest)
    return _Reading(tuple(family.members.values()), (*map(int, rank), *more))


def _as_joints(family: Family, named: bool) -> Iterator[_Reading]:
    """A family as positions of joints or drives; `named`: its labels name the joints of the case."""
    rest = family.rest
    excluded = (say.NO_READING, say.SPEED, say.ACCELERATION, say.EFFORT, say.OTHER, say.FORCE, say.WRENCH)
    if any(words.among(rest) for words in excluded):
        return
    known = (say.NEUTRAL, say.DRIVE, say.MEASURED, say.FILTERED, say.POSITION)
    clear = all(word.isdecimal() or word[0].isdecimal() or any(word in words for words in known) for word in rest)
    position = say.POSITION.among(rest)
    if position or (clear and (named or say.DRIVE.among(rest))):
        yield _reading(family, int(not position))


def _as_struts(family: Family) -> Iterator[_Reading]:
    """A family as lengths of struts."""
    excluded = (say.NO_READING, say.SPEED, say.ACCELERATION, say.EFFORT, say.OTHER, say.FORCE, say.WRENCH)
    if say.STRUT.among(family.rest) and not any(words.among(family.rest) for words in excluded):
        yield _reading(family)


def _as_bars(family: Family) -> Iterator[_Reading]:
    """A family as forces of six bars or struts."""
    rest = _joined(family.rest)
    excluded = (say.NO_READING, say.SPEED, say.ACCELERATION, say.OTHER, say.POSITION, say.NOT_OF_A_SENSOR, say.WRENCH)
    sensors = bool(rest) and all(word in ("sensor", "bar", "stab", "channel", "raw") for word in rest)
    forces = say.FORCE.among(rest) and not say.EFFORT.among(word for word in rest if word != "load")
    if (sensors or forces) and not any(words.among(rest) for words in excluded):
        yield _reading(family)


def _by_unit(family: Family, quantity: str, quantities: Mapping[int, frozenset[str]]) -> Iterator[_Reading]:
    """A family whose words do not say what it is, but whose units are of a quantity."""
    silent = (say.NO_READING, say.SPEED, say.ACCELERATION, say.OTHER, say.NOT_OF_A_SENSOR)
    stated = all(quantities.get(k) == frozenset({quantity}) for k in family.members.values())
    if stated and not any(words.among(_joined(family.rest)) for words in silent):
        yield _reading(family)


def _as_wrench(family: Family, transducer: bool) -> Iterator[_Reading]:
    """A family of six numbers as forces and moments; of a force/torque sensor `force 1` to `6` are likely these."""
    rest = _joined(family.rest)
    excluded = (say.NO_READING, say.SPEED, say.ACCELERATION, say.OTHER, say.POSITION, say.NOT_OF_A_SENSOR)
    if say.WRENCH.among(rest) and not any(words.among(rest) for words in excluded):
        yield _reading(family, 0)
    elif transducer:
        yield from (_Reading(reading.members, (*reading.rank, 1)) for reading in _as_bars(family))


def _joined(words: tuple[str, ...]) -> tuple[str, ...]:
    """Words in which force and torque side by side are one, as in `force_torque_sensor`."""
    text = f" {' '.join(words)} "
    for pair in ("force torque", "f t", "force moment", "kraft moment", "forces torques", "kraft drehmoment"):
        text = text.replace(f" {pair} ", " ft ")
    return tuple(text.split())


def _wrenches(vectors: Sequence[Family]) -> Iterator[_Reading]:
    """Pairs of a vector of forces and one of moments that differ in that word alone; the only two also without."""
    excluded = (say.NO_READING, say.SPEED, say.OTHER, say.NOT_OF_A_SENSOR)
    sound = [f for f in vectors if not any(words.among(_joined(f.rest)) for words in excluded)]
    forces, moments = ([f for f in sound if _quantity(f) == quantity] for quantity in ("force", "moment"))
    pairs = [(f, m) for f in forces for m in moments if _other_words(f) == _other_words(m)]
    if not pairs and len(forces) == len(moments) == 1:
        pairs = [(forces[0], moments[0])]
    for force, moment in pairs:
        yield _Reading((*force.members.values(), *moment.members.values()), (*_reading(force).rank, 0))


def _other_words(family: Family) -> tuple[str, ...]:
    """The words of a vector without those that say what it is of."""
    sentences = (say.FORCE_AXIS, say.MOMENT_AXIS, say.TURN_AXIS, say.PLACE_AXIS)
    return tuple(word for word in _joined(family.rest) if not any(word in words for words in sentences))


_QUANTITIES = {
    "force": say.FORCE_AXIS, "moment": say.MOMENT_AXIS, "acceleration": say.ACCELERATION_AXIS, "speed": say.SPEED_AXIS,
    "turn": say.TURN_AXIS, "place": say.PLACE_AXIS,
}  # fmt: skip


def _quantity(family: Family) -> str | None:
    """What a vector is of, by the beginning of the word that names its axis, else by the word next to it."""
    at = family.axis
    if at is None:
        return None
    stem = family.words[at].removesuffix(AXIS)
    near = [stem] if stem else [*family.words[:at][::-1], *family.words[at + 1 :]]
    quantities = (quantity for word in near for quantity, words in _QUANTITIES.items() if word in words)
    return next(quantities, None if near else "place")


_TRIPLES: tuple[tuple[Group, tuple[str, ...], tuple[str, ...]], ...] = (
    (("roll", "pitch", "yaw"), ("xyz extrinsic",), ("xyz extrinsic",)),
    (("a", "b", "c"), ("xyz extrinsic", "zyx intrinsic"), ("zyx intrinsic", "xyz extrinsic")),
    (("u", "v", "w"), ("xyz intrinsic",), ("xyz intrinsic",)),
    (("w", "p", "r"), ("xyz extrinsic",), ("xyz extrinsic",)),
    (("o", "a", "t"), ("zyz intrinsic",), ("zyz intrinsic",)),
    (("phi", "theta", "psi"), ("xyz extrinsic", "xyz intrinsic", "zyz intrinsic"),
     ("xyz extrinsic", "zyz intrinsic", "xyz intrinsic")),
    (("rx", "ry", "rz"), ("xyz extrinsic", "xyz intrinsic", "rotation vector"),
     ("rotation vector", "xyz extrinsic", "xyz intrinsic")),
)  # fmt: skip
"""Names of three angles; the conventions that they have on hexapods, and on robots, the usual one first."""


def _pose(
    found: Sequence[Family],
    words: Mapping[int, tuple[str, ...]],
    quantities: Mapping[int, frozenset[str]],
    case: Case | None,
    place: Mapping[str, int],
) -> tuple[dict[str, int], tuple[str, ...]]:
    """Pose of the platform or sensor, and the conventions that its orientation may have; `place`: its position."""
    read = _readable(words)
    hexapod = case is not None and case.hexapod is not None
    turned_only = case is not None and case.machine is None  # a sensor that somebody turns: what else would they be?
    turning = {k: of for k, of in read.items() if not quantities[k] or quantities[k] & {ANGLE_UNITS.quantity, _ANY}}
    for letters, of_hexapods, of_robots in _TRIPLES:
        if (angles := _each_once(letters, turning)) and (place or turned_only or letters[0] == "roll"):
            return {**place} | dict(zip(ANGLES, angles, strict=True)), of_hexapods if hexapod else of_robots
    if numbers := _quaternion(found, words):
        return {**place} | dict(zip(QUATERNION, numbers, strict=True)), ("quaternion",)
    if matrix := _matrix(found, words):
        return matrix | ({**(place or _translation(words))} if hexapod else {}), ("matrix",)
    tcp = [
        f for f in found if NUMBER in f.words and len(f.members) == len(POSE) and f.rest == ("actual", "tcp", "pose")
    ]
    if len(tcp) == 1:
        return dict(zip(POSE, tcp[0].members.values(), strict=True)), ("rotation vector",)
    return {}, ()


def _readable(words: Mapping[int, tuple[str, ...]]) -> dict[int, tuple[str, ...]]:
    """Columns that may hold a pose by their names: no set points, speeds or forces."""
    excluded = (say.NO_READING, say.SPEED, say.ACCELERATION, say.EFFORT, say.OTHER, say.FORCE)
    return {k: of for k, of in words.items() if not any(bad.among(_shortened(of)) for bad in excluded)}


def _place(found: Sequence[Family], read: Mapping[int, tuple[str, ...]]) -> dict[str, int]:
    """The position of the platform or sensor, where only one family of columns says that it is one."""
    positions = [f for f in found if _quantity(f) == "place" and {*f.members.values()} <= {*read}]
    return dict(zip(POSE[:3], positions[0].members.values(), strict=True)) if len(positions) == 1 else {}


def _quaternion(found: Sequence[Family], words: Mapping[int, tuple[str, ...]]) -> tuple[int, ...]:
    """Positions of the four numbers of a quaternion, its scalar part first; empty where there is none, or several."""
    quaternion_words = {"orientation", "quat", "quaternion", "rotation"}
    named = _each_once(QUATERNION, words) or _each_once(
        ("w", "x", "y", "z"), {k: of for k, of in words.items() if quaternion_words & {*of}}
    )
    counted = [
        f
        for f in found
        if NUMBER in f.words and len(f.members) == 4 and (f.rest == ("q",) or {"quat", "quaternion"} & {*f.rest})
    ]
    return named or (tuple(counted[0].members.values()) if len(counted) == 1 else ())


def _shortened(words: tuple[str, ...]) -> tuple[str, ...]:
    """Words without the last, which names an angle."""
    return words[:-1]


def _each_once(letters: Group, words: Mapping[int, tuple[str, ...]]) -> tuple[int, ...]:
    """Positions of columns whose names differ in one word that is each of the letters; empty where that is not so."""
    places_of_names: dict[tuple[str, ...], dict[str, list[int]]] = {}
    for k, of in words.items():
        for i, word in enumerate(of):
            if word in letters:
                places_of_names.setdefault((*of[:i], AXIS, *of[i + 1 :]), {}).setdefault(word, []).append(k)
    whole = [
        tuple(of[letter][0] for letter in letters)
        for of in places_of_names.values()
        if len(of) == len(letters) and all(len(columns) == 1 for columns in of.values())
    ]
    return whole[0] if len(whole) == 1 else ()


_MATRICES = frozenset({"r", "rot", "rotation", "matrix", "dcm"})
_TRANSFORMS = _MATRICES | {"t", "tf", "h", "pose", "transform", "trafo"}
_BY_COLUMNS = ("o", "t", "ee")  # O_T_EE of libfranka, 16 numbers column by column


def _matrix(found: Sequence[Family], words: Mapping[int, tuple[str, ...]]) -> dict[str, int]:
    """The elements of a rotation matrix, alone or within a homogeneous one; empty where there is none."""
    for side, names in ((3, _MATRICES), (4, _TRANSFORMS)):
        if elements := _elements(words, names, side):
            return {ours: elements[divmod(number, 3)] for number, ours in enumerate(ROTATION)}
    for family in found:
        rest, count = family.rest, len(family.members)
        if NUMBER in family.words and {*family.members} == {*range(count)}:
            if count == 9 and {*rest} & _MATRICES:
                return {ours: family.members[number] for number, ours in enumerate(ROTATION)}
            if count == 16 and rest[-3:] == _BY_COLUMNS:
                return {ours: family.members[number // 3 + 4 * (number % 3)] for number, ours in enumerate(ROTATION)}
    return {}


def _sixteen(found: Sequence[Family], names: Sequence[str]) -> Iterator[Phrase]:
    """What to say of a homogeneous matrix by 16 numbers, of which nobody says in which order they are."""
    for family in found:
        if NUMBER in family.words and len(family.members) == 16 and {*family.rest} & _TRANSFORMS:
            yield phrase(
                "rows_or_columns",
                "{columns}: a homogeneous matrix by its 16 numbers, row by row or column by column; map r11 to r33 in "
                "[recording.columns]",
                columns=span([names[k] for k in family.members.values()]),
            )


def _translation(words: Mapping[int, tuple[str, ...]]) -> dict[str, int]:
    """The position in the last column of a homogeneous matrix; empty where there is none."""
    elements = _elements(words, _TRANSFORMS, 4)
    return {ours: elements[row, 3] for row, ours in enumerate(POSE[:3])} if elements else {}


def _elements(words: Mapping[int, tuple[str, ...]], names: Set[str], side: int) -> dict[tuple[int, int], int]:
    """Positions of the elements of a square matrix, rows and columns from 0; empty where they are not all there.

    Names count them from 1 or from 0: `R11` to `R33`, `R00` to `R22`.
    """
    elements = {place: k for k, of in words.items() if (place := _element(of, names)) is not None}
    for first in (1, 0):
        numbers = range(first, first + side)
        if {*elements} == {(i, j) for i in numbers for j in numbers}:
            return {(i - first, j - first): k for (i, j), k in elements.items()}
    return {}


def _element(words: tuple[str, ...], names: Set[str]) -> tuple[int, int] | None:
    """Row and column of a matrix element by the two digits of its name; None: it is not one."""
    digits = "".join(word for word in words if word.isdecimal())
    named = [word for word in words if not word.isdecimal()]
    if len(digits) != 2 or not {*named} <= names or not named:
        return None
    return int(digits[0]), int(digits[1])


def _without_a_machine(found: Sequence[Family], places: Mapping[str, int], names: Sequence[str]) -> Iterator[Phrase]:
    """What to say of columns that are joints of a robot or drives of a hexapod: only the machine tells."""
    for family in found:
        members = [*family.members.values()]
        if NUMBER in family.words and len(members) >= 3 and not {*members} & {*places.values()}:
            for _ in _as_joints(family, False):
                yield phrase(
                    "joints_or_drives",
                    "{columns} may be joints or drives; name the machine",
                    columns=span([names[k] for k in members]),
                )


def _computed(family: Family, names: Sequence[str]) -> Iterator[Phrase]:
    """What to say of a wrench that is not a reading of a sensor."""
    words = {*family.rest, *_joined(family.rest)}
    force = say.FORCE.among(words) or say.WRENCH.among(words) or _quantity(family) in ("force", "moment")
    if not force or len(family.members) not in (len(AXES), len(WRENCH)) or say.SPEED.among(words):
        return
    members = span([names[k] for k in family.members.values()])
    what = None if say.NO_READING.among(words) else say.computed(words)
    if what is not None:
        yield phrase(
            "not_readings",
            "{columns}: not readings of the sensor but {what}; {remedy}",
            columns=members,
            what=what[0],
            remedy=what[1],
        )


def _is_clock(words: tuple[str, ...]) -> bool:
    """Whether a column is a clock: a word says so, and no other word says something else."""
    named = [word for word in words if not word.isdecimal()]
    others = [word for word in named if word not in say.CLOCK]
    if named == ["x", "value"]:  # of LabVIEW
        return True
    return len(named) > len(others) and all(word in say.BESIDE_A_CLOCK for word in others)


def _clock_rank(words: tuple[str, ...]) -> tuple[int, int]:
    """Order of clocks: what the sensor's driver stamped, then the name with the fewest words."""
    return int(not {"header", "stamp"} <= {*words}), len(words)


def _is_trigger(words: tuple[str, ...]) -> bool:
    distinct = {*words}
    return bool(
        distinct & {"trig", "ttl", "gate", "marker"}
        or any(word.startswith("trigger") for word in words)
        or {"digital", "out"} <= distinct
        or {"digital", "output", "bits"} <= distinct
        or {"an", "a", "out"} <= distinct
    )


def _is_override(words: tuple[str, ...]) -> bool:
    return bool({"ovr", "override"} & {*words}) and not say.NO_READING.among(words)
