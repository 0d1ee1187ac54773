"""What a kind of run can show that its model leaves out: each effect on the forces, with the words of its cause."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from cases.base.phrases import OPEN, Phrase, phrase
from cases.base.units import DEG, MM, Array
from identification.estimation.alternatives import Alternative
from identification.findings.left_out import STEP, LeftOut, in_channel, ring_changes, structure_of
from identification.machines.hexapod import Hexapod
from identification.model.model import Model, regressors

SLOW = 0.05  # of the largest speed, below which friction grows with the speed
PERCENT, DEGREES, MILLIMETRES, MILLISECONDS = 0.01, DEG, MM, 1e-3

SPRING = phrase("by_spring", "a hose, a cable or a spring between the load and its surroundings")
BY_PLACE = phrase(
    "by_place", "a wrong dimension or zero in the case, an elastic frame, or errors of encoders and joints"
)
BY_ORIENTATION = phrase("by_orientation", "errors of the orientations, or sensors that are not straight")
BY_SHAKING = phrase("by_shaking", "a gain, a mode of what carries the sensor, or a low-pass in one of the streams")
BY_RATE = phrase("by_rate", "friction, channels that are late against each other, or a cable")
BY_ACCELERATION = phrase(
    "by_acceleration",
    "a wrong dimension in the case, a gain, a mode of the frame, or a low-pass in one of the streams",
)
BY_COUPLING = phrase("by_coupling", "cross-talk of the channels, or a wrong dimension of the sensor frame")
BY_LOW_PASS = phrase(
    "by_low_pass", "a low-pass in the streams, noise of the drives, or a mode of the frame below the cut-off"
)
LATE_CHANNELS = phrase("late_channels", "channels that are late against each other")
ALL_LOADS = phrase("all_loads", "the loads on all channels")
POSE = phrase("the_pose", "the pose")


def alternatives_of(run: LeftOut) -> Iterator[Alternative]:
    """All that this kind of run can show."""
    for alternative in _all(run):
        yield alternative._replace(columns=run.weighted(alternative.columns))


def _all(run: LeftOut) -> Iterator[Alternative]:
    """The same, as the forces alone say it."""
    if run.larger is not None:
        yield _of_larger_model(run, run.larger)
    yield from _of_channels(run)
    yield from _of_frame(run)
    yield from _of_surroundings(run)
    if run.moves:
        yield from _of_clocks(run)
    yield from _of_drives(run)
    yield from _of_motion(run)


def _of_larger_model(run: LeftOut, larger: Model) -> Alternative:
    more = [k for k, name in enumerate(larger.names) if name not in run.model.names]
    cause = phrase(
        "small_model",
        "a model that is too small: {names} are not in it; choose model {number}",
        names=", ".join(larger.names[k] for k in more),
        number=larger.number,
    )
    follow = phrase(
        "beside_model", "what model {larger} has beside model {own}", larger=larger.number, own=run.model.number
    )
    return Alternative("model", follow, cause, regressors(larger, run.load)[:, :, more])


def _of_channels(run: LeftOut) -> Iterator[Alternative]:
    for k, name in enumerate(run.names.channels):
        columns = in_channel(run.expected[:, k], k)
        cause = phrase("gain_high", "a gain of {name} that is {size} % too high", name=name, size=OPEN)
        yield Alternative("gain", _LOAD_ON.filled(of=name), cause, columns, PERCENT)
    coupling = in_channels(run.of_load)
    yield Alternative("coupling", ALL_LOADS, BY_COUPLING, coupling, each=_each(_LOAD_ON, run.names.channels))
    size = np.abs(run.expected).max(axis=0)
    bent = in_own_channel(run.expected**2 / np.where(size > 0.0, size, 1.0))
    yield Alternative(
        "bent",
        phrase("load_squared", "the square of the load"),
        phrase("not_linear", "sensors that are not linear"),
        bent,
        each=_of_itself(phrase("own_load_squared", "the square of its load")),
    )
    yield from _of_bars(run)


def couplings_of(run: LeftOut) -> Iterator[Alternative]:
    """Cross-talk of one channel into another, each pair of them as an effect of one size."""
    names = run.names.channels
    for source, target in permutations(range(6), 2):
        cause = phrase(
            "cross_talk",
            "cross-talk by which {target} reads {size} of the load on {source}",
            target=names[target],
            size=OPEN,
            source=names[source],
        )
        columns = run.weighted(in_channel(run.of_load[:, source], target))
        yield Alternative("coupling", _LOAD_ON.filled(of=names[source]), cause, columns)


_LOAD_ON = phrase("load_on", "the load on {of}", of=OPEN)


def _each(words: Phrase, names: tuple[str, ...]) -> tuple[tuple[Phrase, int], ...]:
    """What columns of `in_channels` follow; words with an open place `of`."""
    return tuple((words.filled(of=name), k) for k in range(6) for name in names)


def _of_itself(words: Phrase) -> tuple[tuple[Phrase, int], ...]:
    """What columns of `own` follow."""
    return tuple((words, k) for k in range(6))


def _of_bars(run: LeftOut) -> Iterator[Alternative]:
    if run.bars is None:
        return
    into, (lower, upper) = run.into_channels[0], run.bars
    ends = {phrase("lower", "lower"): lower, phrase("upper", "upper"): upper}
    for ring, place in ends.items():
        for what, ways, unit, word in ring_changes(place):
            if ring == "upper" and what == "height":
                continue  # nearly the same as the lower ring's
            moved = (place + STEP * ways, upper) if ring == "lower" else (lower, place + STEP * ways)
            change = (structure_of(*moved) - structure_of(lower, upper)) / STEP
            columns = -(run.of_load @ (into @ change).T)[:, :, None]
            cause = phrase(
                "ring_of_bars",
                "a {what} of the bars' {ring} ring that is {size} {unit} larger than the case says",
                what=what,
                ring=ring,
                size=OPEN,
                unit=word,
            )
            yield Alternative("bars", ALL_LOADS, cause, columns, unit)


def _of_frame(run: LeftOut) -> Iterator[Alternative]:
    accelerometer = run.motion.by_accelerometer
    than = phrase("accelerometer", "the accelerometer") if accelerometer else phrase("case_says", "the case says")
    turning = phrase("load_turning", "the turning of the load")
    for k, name in enumerate("xyz"):
        cause = phrase(
            "frame_further",
            "a sensor frame that is {size} mm further along its {axis} than {than}",
            size=OPEN,
            axis=name,
            than=than,
        )
        yield Alternative("frame", turning, cause, run.by_place[:, :, k : k + 1], MILLIMETRES)
    against = phrase("orientations", "the orientations") if accelerometer else phrase("the_case", "the case")
    shaking = phrase("gravity_acceleration", "gravity and acceleration")
    for k, name in enumerate("xyz"):
        cause = phrase(
            "frame_turned",
            "a sensor frame that is turned about its {axis} by {size} deg against {against}",
            axis=name,
            size=OPEN,
            against=against,
        )
        yield Alternative("frame", shaking, cause, run.by_axes[:, :, k : k + 1], DEGREES)
    axes, columns = run.by_gravity
    direction = phrase("gravity_direction", "the direction of gravity")
    for k, axis in enumerate(axes[1:], 1):
        along = ", ".join(f"{v + 0.0:.2g}" for v in axis)
        cause = phrase("gravity_leans", "gravity that leans by {size} deg towards ({along})", size=OPEN, along=along)
        yield Alternative("gravity", direction, cause, columns[:, :, k : k + 1], DEGREES)


def _of_surroundings(run: LeftOut) -> Iterator[Alternative]:
    position, speed = run.load.pose[:, :3], run.load.twist[:, :3]
    kinds = [
        (
            "pull",
            phrase("constant_force", "a constant force along {of} of the base", of=OPEN),
            phrase("by_pull", "a hose or a cable that pulls"),
            np.ones_like(speed),
        )
    ]
    if np.ptp(position, axis=0).any():
        follow = phrase("position_along", "the position along {of}", of=OPEN)
        kinds.append(("spring", follow, SPRING, position - position.mean(axis=0)))
        if run.moves:
            cause = phrase("by_damper", "a damper, or a hose that is dragged along")
            kinds.append(("drag", phrase("speed_along", "the speed along {of}", of=OPEN), cause, speed))
            follow = phrase("sign_along", "the sign of the speed along {of}", of=OPEN)
            cause = phrase("by_chain", "friction of a cable chain or a seal")
            kinds.append(("friction", follow, cause, rubbing(speed)))
    axes = phrase("x_y_z", "x, y and z")
    for key, follow, cause, forces in kinds:
        columns, each = run.pulled(forces), tuple((follow.filled(of=axis), -1) for axis in "xyz")
        yield Alternative(key, follow.filled(of=axes), cause, columns, each=each)
        for k in range(3):
            yield Alternative(key, each[k][0], cause, columns[:, :, k : k + 1])


def _of_clocks(run: LeftOut) -> Iterator[Alternative]:
    assert run.moves
    if not run.motion.by_accelerometer:  # then only the turning goes by the clock
        cause = phrase("stamps_apart", "time stamps that are {size} % too far apart", size=OPEN)
        yield Alternative("clock", _ACCELERATION, cause, run.by_clock[:, :, None], PERCENT)
    span = (run.t - run.t.mean()) / max(float(np.ptp(run.t)), run.step)
    rate = run.derivative(run.expected, 1)
    follow = phrase("changing_delay", "a delay that changes with time")
    cause = phrase("clocks_drift", "clocks of forces and motion that drift apart by {size} ms over the run", size=OPEN)
    yield Alternative("drift", follow, cause, -(rate * span[:, None])[:, :, None], MILLISECONDS)
    yield Alternative(
        "skew",
        phrase("rate_of_forces", "the rate of the forces"),
        LATE_CHANNELS,
        in_own_channel(rate),
        each=_of_itself(phrase("own_rate", "its own rate")),
    )
    orders = {
        2: phrase("second", "second"),
        3: phrase("third", "third"),
        4: phrase("fourth", "fourth"),
    }
    for order, word in orders.items() if run.motion.calm else ():
        bend = run.derivative(run.expected, order)
        follow = phrase("derivative_of_forces", "the {order} derivative of the forces", order=word)
        yield Alternative("smoothing", follow, BY_LOW_PASS, bend[:, :, None])
        of_channel = phrase("derivative_of_own", "the {order} derivative of its own force", order=word)
        yield Alternative("smoothing", follow, BY_LOW_PASS, in_own_channel(bend), each=_of_itself(of_channel))
    yield Alternative(
        "hysteresis",
        phrase("sign_of_rate", "the sign of the rate of the forces"),
        phrase("by_hysteresis", "hysteresis of the sensors"),
        in_own_channel(rubbing(rate)),
        each=_of_itself(phrase("sign_of_own_rate", "the sign of its own rate")),
    )
    loads = [k for k, name in enumerate(run.model.names) if name in ("m", "mxC", "myC", "mzC")]
    if loads:
        cause = phrase("by_payload", "a payload that was lost, taken up or moved")
        slowly = phrase("load_changing", "a load that changes with time")
        at_once = phrase("load_leaping", "a load that changes at once")
        for share, follow in ((span, slowly), ((span > 0.0) * 1.0, at_once)):
            columns = run.matrices[:, :, loads] * share[:, None, None]
            yield Alternative("load", follow, cause, columns)


_ACCELERATION = phrase("the_acceleration", "the acceleration")


def _of_drives(run: LeftOut) -> Iterator[Alternative]:
    if run.by_drives is None or run.motion.drives is None:
        return
    place, v, gains = run.by_drives[0], run.motion.drives[1], run.by_scales
    for k, name in enumerate(run.names.drives):
        unit, word = (DEGREES, "deg") if run.names.turns[k] else (MILLIMETRES, "mm")
        cause = phrase("zero_wrong", "a zero of {name} that is wrong by {size} {unit}", name=name, size=OPEN, unit=word)
        yield Alternative("zero", _POSITION_OF.filled(of=name), cause, -place[:, :, k : k + 1], unit)
        follow = phrase("motion_of", "the motion of {of}", of=name)
        cause = phrase("scale_wrong", "a scale of {name} that is wrong by {size} %", name=name, size=OPEN)
        yield Alternative("scale", follow, cause, -gains[:, :, k : k + 1], PERCENT)
    if run.motion.of_pose:
        cause = phrase("zeros_wrong", "zeros of all struts that are wrong by {size} mm", size=OPEN)
        yield Alternative("zero", POSE, cause, -place.sum(axis=2, keepdims=True), MILLIMETRES)
        cause = phrase("scales_wrong", "a scale of all struts that is wrong by {size} %", size=OPEN)
        yield Alternative("scale", POSE, cause, -gains.sum(axis=2, keepdims=True), PERCENT)
        yield from _of_joints(run)
    if run.moves:
        yield Alternative(
            "friction",
            phrase("drive_signs", "the signs of the drives' speeds"),
            phrase("by_drives", "friction in joints or drives"),
            in_channels(rubbing(v)),
            each=_each(phrase("sign_of_speed", "the sign of the speed of {of}", of=OPEN), run.names.drives),
        )


_POSITION_OF = phrase("position_of", "the position of {of}", of=OPEN)


def _of_joints(run: LeftOut) -> Iterator[Alternative]:
    """Rings of joints of a hexapod that are not as the case says: then struts seem to have other lengths."""
    machine = run.motion.machine
    if not isinstance(machine, Hexapod):
        return
    rings = {phrase("base", "base"): machine.base, phrase("platform", "platform"): machine.platform}
    for ring, points in rings.items():
        for what, ways, unit, word in ring_changes(points):
            if what == "height":
                continue  # of the base or of the platform, it moves the pose as a whole
            columns = -run.by_joints(machine, ring, ways)  # the run is of the larger ring
            cause = phrase(
                "ring_of_joints",
                "a {what} of the {ring} joints' ring that is {size} {unit} larger than the case says",
                what=what,
                ring=ring,
                size=OPEN,
                unit=word,
            )
            yield Alternative("ring", POSE, cause, columns, unit)


def _of_motion(run: LeftOut) -> Iterator[Alternative]:
    described = (run.load.pose, run.load.twist, run.load.twist_rate)
    if run.motion.by_accelerometer:
        yield from _of_orientation(run)
        return
    if run.motion.drives is not None and not run.motion.of_pose:
        described = run.motion.drives
    names = run.names.coordinates
    place, *moving = (scaled(values) for values in described)
    position = phrase("the_position", "the position")
    yield Alternative("place", position, BY_PLACE, in_channels(place), each=_each(_POSITION_OF, names))
    first, second = np.triu_indices(place.shape[1])
    pairs = tuple(
        names[i] if i == j else phrase("pair", "{one} and {other}", one=names[i], other=names[j])
        for i, j in zip(first, second, strict=True)
    )
    each = _each(phrase("products_of", "products of the position of {of}", of=OPEN), pairs)
    products = in_channels(scaled(place[:, first] * place[:, second]))
    yield Alternative("place", position, BY_PLACE, products, each=each)
    if run.moves:
        speed, acceleration = moving
        of = phrase("speed_of", "the speed of {of}", of=OPEN)
        yield Alternative("speed", _SPEED, BY_RATE, in_channels(speed), each=_each(of, names))
        of = phrase("acceleration_of", "the acceleration of {of}", of=OPEN)
        columns = in_channels(acceleration)
        yield Alternative("acceleration", _ACCELERATION, BY_ACCELERATION, columns, each=_each(of, names))


_SPEED = phrase("the_speed", "the speed")


def _of_orientation(run: LeftOut) -> Iterator[Alternative]:
    """Of a motion whose place is not known: how gravity lies in the sensor, and how that turns and is shaken."""
    m, into_sensor = run.load, run.turn.transpose(0, 2, 1)
    specific_force = into_sensor @ (m.twist_rate[:, :3] - run.model.gravity)[:, :, None]
    kinds = (
        (
            "place",
            phrase("the_orientation", "the orientation"),
            phrase("gravity_in_sensor", "gravity along {of} of the sensor", of=OPEN),
            into_sensor[:, :, 2],
            BY_ORIENTATION,
        ),
        (
            "speed",
            _SPEED,
            phrase("speed_about", "the speed about {of} of the sensor", of=OPEN),
            (into_sensor @ m.twist[:, 3:, None])[:, :, 0],
            BY_RATE,
        ),
        (
            "acceleration",
            _ACCELERATION,
            phrase("acceleration_along", "the acceleration along {of} of the sensor", of=OPEN),
            specific_force[:, :, 0],
            BY_SHAKING,
        ),
    )
    for key, follow, each, values, cause in kinds:
        yield Alternative(key, follow, cause, in_channels(scaled(values)), each=_each(each, ("x", "y", "z")))


def in_own_channel(series: Array) -> Array:
    """A series of each channel, shape (n, 6), as columns in that channel alone, shape (n, 6, 6)."""
    return np.asarray(series[:, :, None] * np.eye(6))


def in_channels(series: Array) -> Array:
    """Series, shape (n, s), each as a column in each channel alone, shape (n, 6, 6 s); channel after channel."""
    return np.asarray(np.concatenate([series[:, None, :] * np.eye(6)[k][:, None] for k in range(6)], axis=2))


def scaled(values: Array) -> Array:
    """Series about their means, largest size 1, shape (n, s)."""
    centred = values - values.mean(axis=0)
    size = np.abs(centred).max(axis=0)
    return np.asarray(centred / np.where(size > 0.0, size, 1.0))


def rubbing(speed: Array) -> Array:
    """The sign of a speed, smooth where it is slow, shape (n, s)."""
    size = SLOW * np.abs(speed).max(axis=0)
    return np.asarray(np.tanh(speed / np.where(size > 0.0, size, 1.0)))
