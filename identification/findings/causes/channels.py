"""Hypotheses about recorded forces: channels in another order, with another sign, unit or scale, or in other axes."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.phrases import NOTHING, Phrase, enumerated, phrase
from cases.base.units import Array
from cases.machine import Frame, turned
from cases.recording_format import ROLE_OF, ROLE_UNITS, Role
from cases.schema import Case
from cases.sensors import Transducer
from identification.findings.causes.hypothesis import Edit, Family, Hypothesis
from identification.texts import number, with_deviation

ORDER = tuple(range(6))
AXES = ("x", "y", "z")


def orders(count: int) -> Iterator[tuple[int, ...]]:
    """For each column the place in which it was recorded: exchanged pairs, up to three at once, and shifts."""
    straight = tuple(range(count))
    for pairs in _pairs(straight, 3):
        order = list(straight)
        for one, other in pairs:
            order[one], order[other] = other, one
        yield tuple(order)
    for shift in range(1, count):
        if 2 * shift != count:  # that is three pairs of six
            yield tuple((k + shift) % count for k in straight)


def _pairs(places: Sequence[int], most: int) -> Iterator[tuple[tuple[int, int], ...]]:
    """Sets of one to `most` pairs of places that have none in common."""
    for k, one in enumerate(places):
        for other in places[k + 1 :]:
            yield ((one, other),)
            if most > 1:
                remaining = [place for place in places[k + 1 :] if place != other]
                yield from (((one, other), *more) for more in _pairs(remaining, most - 1))


def order_words(order: Sequence[int], what: Phrase, names: Sequence[str]) -> Phrase:
    """What is wrong where an order of columns is the right one."""
    pairs = [
        phrase("pair", "{one} and {other}", one=names[k], other=names[place])
        for k, place in enumerate(order)
        if k < place and order[place] == k
    ]
    moved = sum(place != k for k, place in enumerate(order))
    if 2 * len(pairs) == moved:
        return phrase("exchanged", "{what} {pairs} are exchanged", what=what, pairs=enumerated("comma", pairs))
    shift = {(place - k) % len(order) for k, place in enumerate(order)}
    if len(shift) == 1:
        return phrase("shifted", "{what} are shifted by {places}", what=what, places=shift.pop())
    return _reordered(what, [(names[k], names[place]) for k, place in enumerate(order) if place != k])


def _reordered(what: Phrase, moved: Sequence[tuple[str, str]]) -> Phrase:
    places = [phrase("in_place_of", "{one} is in the place of {other}", one=a, other=b) for a, b in moved]
    cycle = enumerated("comma", places)
    return phrase("reordered", "{what} are in another order: {cycle}", what=what, cycle=cycle)


def matrix_of(order: Sequence[int], signs: Sequence[float] | None = None) -> Array:
    """The matrix that brings columns in order, and changes their signs afterwards, shape (n, n)."""
    matrix = np.eye(len(order))[list(order)]
    return matrix if signs is None else np.asarray(np.diag(signs) @ matrix)


def mapped(names: Sequence[str], order: Sequence[int]) -> Edit:
    """The edit that reads each of our columns from the place in which it was recorded."""

    def edit(case: Case) -> Case:
        form = case.recording
        entries = {names[k]: form.file_name(names[place]) for k, place in enumerate(order) if place != k}
        return case.model_copy(update={"recording": form.model_copy(update={"columns": {**form.columns, **entries}})})

    return edit


def in_unit(role: Role, unit: str) -> Edit:
    """The edit that reads columns of a role in a unit."""

    def edit(case: Case) -> Case:
        units = {**case.recording.units, role: unit}
        return case.model_copy(update={"recording": case.recording.model_copy(update={"units": units})})

    return edit


def other_units(case: Case, role: Role) -> Iterator[tuple[str, float]]:
    """Other units of a role than the case says, one of those alike, with what values are to be multiplied by."""
    units = ROLE_UNITS[role]
    usual = units.usual
    now = units[units.symbol(case.recording.units.get(role, usual)) or usual]
    factors = {1.0}
    for unit, factor in units.items():
        if (ratio := float(f"{factor / now:.12g}")) not in factors:
            factors.add(ratio)
            yield unit, ratio


def of_channels(case: Case) -> Iterator[Hypothesis]:
    """Hypotheses about the channels of a case's sensors."""
    names = case.sensor_frame.channels
    numbers = [str(k + 1) for k in ORDER]
    what = phrase("force_channels", "force channels")
    for order in orders(6):
        pairs = sum(place != k for k, place in enumerate(order)) // 2
        swapped = all(order[place] == k for k, place in enumerate(order))
        axes = case.sensor_frame.has_moments and swapped and _exchanged_axes(order)
        yield Hypothesis(
            family=Family.CHANNELS, words=order_words(order, what, numbers), channels=matrix_of(order),
            edit=mapped(names, order), mistakes=pairs if swapped and not axes else 1.5,
            single=pairs > 1 and swapped and not axes,
        )  # fmt: skip
    yield from _cycles(case) if case.sensor_frame.has_moments else ()
    yield from _signs(case)
    if case.sensor_frame.has_moments:
        yield from _moment_units(case)


def _cycles(case: Case) -> Iterator[Hypothesis]:
    """Axes of force and moment in another cyclic order, both alike."""
    names = case.sensor_frame.channels
    for shift in (1, 2):
        order = [(k % 3 + shift) % 3 + 3 * (k // 3) for k in ORDER]
        what = phrase("forces_and_moments", "forces and moments")
        words = _reordered(what, [(AXES[k], AXES[(k + shift) % 3]) for k in range(3)])
        yield Hypothesis(
            family=Family.CHANNELS, words=words,
            channels=matrix_of(order), edit=mapped(names, order), mistakes=1.5,
        )  # fmt: skip


def _exchanged_axes(order: Sequence[int]) -> bool:
    """Whether an order exchanges two axes of force and moment alike: one mistake, though it moves four channels."""
    return all(order[k + 3] == order[k] + 3 for k in range(3))


def _signs(case: Case) -> Iterator[Hypothesis]:
    """Channels with the other sign, any number of them; all of them are the sense of the sensor."""
    frame = case.sensor_frame
    for signs in product((1.0, -1.0), repeat=6):
        turned_ones = [k for k in ORDER if signs[k] < 0.0]
        if not turned_ones:
            continue
        every = len(turned_ones) == 6
        in_frame = frame.bars is not None or (every and frame.transducer is not None)  # which have a sense
        numbers = ", ".join(str(k + 1) for k in turned_ones)
        names = [frame.channels[k] for k in turned_ones]
        yield Hypothesis(
            family=Family.CHANNELS, channels=np.diag(signs),
            words=phrase("channel_signs", "the signs of force channels {numbers} are turned", numbers=numbers),
            edit=other_sense(turned_ones) if in_frame else scaled(dict.fromkeys(names, -1.0)),
            place="either" if in_frame else "recording",
            mistakes=1.0 if every else len(turned_ones), single=1 < len(turned_ones) < 6,
        )  # fmt: skip


def scaled(factors: Mapping[str, float]) -> Edit:
    """The edit that reads columns times factors."""

    def edit(case: Case) -> Case:
        form, scale = case.recording, dict(case.recording.scale)
        for ours, factor in factors.items():
            units = ROLE_UNITS[ROLE_OF[ours]]
            scale[ours] = float(f"{factor * form.factor(ours) / units[units.usual]:.6g}")
        return case.model_copy(update={"recording": form.model_copy(update={"scale": scale})})

    return edit


def other_sense(channels: Sequence[int]) -> Edit:
    """The edit that takes channels the other way, by the sense of bars or of a force/torque sensor."""

    def edit(case: Case) -> Case:
        frame = case.sensor_frame
        if frame.transducer is not None:
            sense = "sensor_on_load" if frame.transducer.sense == "load_on_sensor" else "load_on_sensor"
            frame = frame.model_copy(update={"transducer": Transducer(sense=sense)})
        elif frame.bars is not None:
            senses = [frame.bars.sense] * 6 if isinstance(frame.bars.sense, str) else list(frame.bars.sense)
            for k in channels:
                senses[k] = "tension" if senses[k] == "compression" else "compression"
            alike = senses[0] if len({*senses}) == 1 else tuple(senses)
            frame = frame.model_copy(update={"bars": frame.bars.model_copy(update={"sense": alike})})
        return case.model_copy(update={"sensor_frame": frame})

    return edit


def _moment_units(case: Case) -> Iterator[Hypothesis]:
    """Moments in another unit, beside forces in the right one: where a motion shows it."""
    for unit, ratio in other_units(case, Role.MOMENTS):
        scale = np.diag(np.repeat([1.0, ratio], 3))
        words = phrase("moments_in", "moments are in {unit}", unit=unit)
        yield Hypothesis(family=Family.UNITS, words=words, channels=scale, edit=in_unit(Role.MOMENTS, unit))


def excess_of(gain: float) -> float:
    """What a channel reads too much that is to be multiplied by a gain [%]."""
    return 100.0 * (1.0 / gain - 1.0)


def of_gain(case: Case, channel: int, gain: float, std: float | None = None) -> Hypothesis:
    """One channel is to be multiplied by a gain; std: standard deviation of what it reads too much [%]."""
    scale = np.ones(6)
    scale[channel] = gain
    ours = case.sensor_frame.channels[channel]
    name = case.recording.file_name(ours)
    size = number(abs(excess_of(gain)), std, 3)
    if gain > 1.0:
        words = phrase("gain_small", "{name} is {size} % smaller than the other channels say", name=name, size=size)
    else:
        words = phrase("gain_large", "{name} is {size} % larger than the other channels say", name=name, size=size)
    return Hypothesis(
        family=Family.GAINS, words=words,
        channels=np.diag(scale), edit=scaled({ours: float(f"{gain:.4g}")}), mistakes=1.5,
    )  # fmt: skip


CUBE = tuple(turn for turn in Rotation.create_group("O") if np.degrees(turn.magnitude()) > 1.0)
"""Turns by right angles, about axes, diagonals of faces and of the cube."""


def angle_and_axis(turn: Rotation) -> Array:
    """Angle [deg] and axis of a turn, shape (4,)."""
    vector = np.degrees(turn.as_rotvec())
    angle = float(np.linalg.norm(vector))
    return np.append(angle, vector / angle)


def of_turn(
    case: Case, turn: Rotation, mistakes: float = 1.0, single: bool = False, stds: Sequence[float] | None = None
) -> Hypothesis:
    """A force/torque sensor is turned: forces in the axes of the case are `turn` times the recorded ones.

    Args:
        case: the case.
        turn: as above.
        mistakes: that it counts for.
        single: whether it is tried alone only.
        stds: standard deviations of `angle_and_axis`; None where they are not known.
    """
    angle, *axis = (float(value) for value in angle_and_axis(turn))
    main = int(np.argmax(np.abs(axis)))
    deviations = (None,) * 4 if stds is None else tuple(stds)
    if abs(axis[main]) > 0.9999:
        size = number(np.sign(axis[main]) * angle, deviations[0], 4)
        about = phrase("about_axis", "{angle} deg about its {axis} axis", angle=size, axis=AXES[main])
    else:
        along = ", ".join(
            f"{value + 0.0:.2f}" if std is None else with_deviation(value, std)
            for value, std in zip(axis, deviations[1:], strict=True)
        )
        about = phrase("about", "{angle} deg about ({along})", angle=number(angle, deviations[0], 4), along=along)
    matrix = np.kron(np.eye(2), turn.as_matrix())
    edit: Edit | None = None
    remedy = phrase("turn_it", "turn forces and moments in the recorder by {about}", about=about)
    if case.chain is not None:
        edit, remedy = _sensor_turned(turn), NOTHING
    words = phrase("sensor_turned", "the sensor is turned by {about}", about=about)
    return Hypothesis(
        family=Family.SENSOR, words=words, channels=matrix, edit=edit,
        place="either" if edit is not None else "recording", remedy=remedy, mistakes=mistakes, single=single,
    )  # fmt: skip


def _sensor_turned(turn: Rotation) -> Edit:
    def turned_by(sensor: Frame) -> dict[str, object]:
        matrix = turned(sensor.rpy) @ turn.as_matrix()
        return {"rpy_deg": tuple(float(round(v, 3)) + 0.0 for v in np.degrees(rpy_of(matrix)))}

    return _with_sensor(turned_by)


def of_point(case: Case, point: Array, mistakes: float, stds: Sequence[float] | None = None) -> Hypothesis:
    """Moments are about another point than the sensor's origin.

    Args:
        case: the case.
        point: from the sensor's origin, in its axes, shape (3,) [m].
        mistakes: that it counts for.
        stds: standard deviations of the point [mm]; None where they are not known.
    """
    if stds is None:
        place = ", ".join(f"{float(round(value, 1)) + 0.0:g}" for value in np.asarray(point) * 1e3)
    else:
        place = ", ".join(with_deviation(1e3 * value, std) for value, std in zip(point, stds, strict=True))
    matrix = np.eye(6)
    matrix[3:, :3] = np.cross(np.eye(3), point)  # M about the origin = M about the point + point x F
    edit: Edit | None = None
    remedy = phrase("record_about_origin", "record moments about the origin of the sensor")
    if case.chain is not None:
        edit, remedy = _sensor_moved(point), NOTHING
    words = "moments are about a point ({place}) mm from the sensor's origin, in its axes"
    return Hypothesis(
        family=Family.POINT, channels=matrix, edit=edit, place="either" if edit is not None else "recording",
        words=phrase("moments_about", words, place=place), remedy=remedy, mistakes=mistakes,
    )  # fmt: skip


def _sensor_moved(point: Array) -> Edit:
    def moved_by(sensor: Frame) -> dict[str, object]:
        origin = np.array(sensor.origin_mm) + turned(sensor.rpy) @ point * 1e3
        return {"origin_mm": tuple(float(round(v, 2)) + 0.0 for v in origin)}

    return _with_sensor(moved_by)


def _with_sensor(update: Callable[[Frame], dict[str, object]]) -> Edit:
    """The edit that places the sensor of a chain otherwise."""

    def edit(case: Case) -> Case:
        assert case.chain is not None
        assert case.machine is not None
        sensor = case.chain.sensor
        chain = case.chain.model_copy(update={"sensor": sensor.model_copy(update=update(sensor))})
        return case.model_copy(update={"machine": case.machine.model_copy(update={"chain": chain})})

    return edit


def rpy_of(matrix: Array) -> Array:
    """Roll, pitch, yaw of a rotation matrix, shape (3,) [rad]."""
    level = float(np.hypot(matrix[2, 1], matrix[2, 2]))
    pitch = float(np.arctan2(-matrix[2, 0], level))
    if level < 1e-9:
        return np.array([0.0, pitch, np.arctan2(-matrix[0, 1], matrix[1, 1])])
    return np.array([np.arctan2(matrix[2, 1], matrix[2, 2]), pitch, np.arctan2(matrix[1, 0], matrix[0, 0])])


def of_sensor(case: Case) -> Iterator[Hypothesis]:
    """A force/torque sensor that is turned by right angles."""
    if not case.sensor_frame.has_moments:
        return
    for turn in CUBE:
        vector = np.abs(turn.as_rotvec())
        about_axis = np.count_nonzero(vector > 1e-6) == 1
        yield of_turn(case, turn, mistakes=1.0 if about_axis else 1.2, single=not about_axis)
