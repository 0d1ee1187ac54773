"""What a kind of run can show that its model leaves out: each effect on the forces, with the words of its cause."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from cases.base.units import DEG, MM, Array
from identification.estimation.alternatives import Alternative
from identification.findings.left_out import STEP, LeftOut, in_channel, ring_changes, structure_of
from identification.machines.hexapod import Hexapod
from identification.model.model import Model, regressors

SLOW = 0.05  # of the largest speed, below which friction grows with the speed
PERCENT, DEGREES, MILLIMETRES, MILLISECONDS = 0.01, DEG, MM, 1e-3

SPRING = "a hose, a cable or a spring between the load and its surroundings"
BY_PLACE = "a wrong dimension or zero in the case, an elastic frame, or errors of encoders and joints"
BY_ORIENTATION = "errors of the orientations, or sensors that are not straight"
BY_SHAKING = "a gain, a mode of what carries the sensor, or a low-pass in one of the streams"
BY_RATE = "friction, channels that are late against each other, or a cable"
BY_ACCELERATION = "a wrong dimension in the case, a gain, a mode of the frame, or a low-pass in one of the streams"


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
    if run.late is not None:
        yield from _of_clocks(run)
    yield from _of_drives(run)
    yield from _of_motion(run)


def _of_larger_model(run: LeftOut, larger: Model) -> Alternative:
    more = [k for k, name in enumerate(larger.names) if name not in run.model.names]
    names = ", ".join(larger.names[k] for k in more)
    cause = f"a model that is too small: {names} are not in it; choose model {larger.number}"
    follow = f"what model {larger.number} has beside model {run.model.number}"
    return Alternative("model", follow, cause, regressors(larger, run.load)[:, :, more])


def _of_channels(run: LeftOut) -> Iterator[Alternative]:
    for k, name in enumerate(run.names.channels):
        columns = in_channel(run.expected[:, k], k)
        yield Alternative("gain", f"the load on {name}", f"a gain of {name} that is {{}} % too high", columns, PERCENT)
    coupling = in_channels(run.of_load)
    cause = "cross-talk of the channels, or a wrong dimension of the sensor frame"
    yield Alternative(
        "coupling",
        "the loads on all channels",
        cause,
        coupling,
        each=_each("the load on {}", run.names.channels),
    )
    size = np.abs(run.expected).max(axis=0)
    bent = in_own_channel(run.expected**2 / np.where(size > 0.0, size, 1.0))
    yield Alternative(
        "bent",
        "the square of the load",
        "sensors that are not linear",
        bent,
        each=_of_itself("the square of its load"),
    )
    yield from _of_bars(run)


def couplings_of(run: LeftOut) -> Iterator[Alternative]:
    """Cross-talk of one channel into another, each pair of them as an effect of one size."""
    names = run.names.channels
    for source, target in permutations(range(6), 2):
        cause = f"cross-talk by which {names[target]} reads {{}} of the load on {names[source]}"
        columns = run.weighted(in_channel(run.of_load[:, source], target))
        yield Alternative("coupling", f"the load on {names[source]}", cause, columns)


def _each(words: str, names: tuple[str, ...]) -> tuple[tuple[str, int], ...]:
    """What columns of `in_channels` follow."""
    return tuple((words.format(name), k) for k in range(6) for name in names)


def _of_itself(words: str) -> tuple[tuple[str, int], ...]:
    """What columns of `own` follow."""
    return tuple((words, k) for k in range(6))


def _of_bars(run: LeftOut) -> Iterator[Alternative]:
    if run.bars is None:
        return
    into, (lower, upper) = run.into_channels[0], run.bars
    for ring, place in (("lower", lower), ("upper", upper)):
        for what, ways, unit, word in ring_changes(place):
            if ring == "upper" and what == "height":
                continue  # nearly the same as the lower ring's
            moved = (place + STEP * ways, upper) if ring == "lower" else (lower, place + STEP * ways)
            change = (structure_of(*moved) - structure_of(lower, upper)) / STEP
            columns = -(run.of_load @ (into @ change).T)[:, :, None]
            cause = f"a {what} of the bars' {ring} ring that is {{}} {word} larger than the case says"
            yield Alternative("bars", "the loads on all channels", cause, columns, unit)


def _of_frame(run: LeftOut) -> Iterator[Alternative]:
    for k, name in enumerate("xyz"):
        than = "the accelerometer" if run.motion.by_accelerometer else "the case says"
        cause = f"a sensor frame that is {{}} mm further along its {name} than {than}"
        yield Alternative("frame", "the turning of the load", cause, run.by_place[:, :, k : k + 1], MILLIMETRES)
    for k, name in enumerate("xyz"):
        against = "the orientations" if run.motion.by_accelerometer else "the case"
        cause = f"a sensor frame that is turned about its {name} by {{}} deg against {against}"
        yield Alternative("frame", "gravity and acceleration", cause, run.by_axes[:, :, k : k + 1], DEGREES)
    axes, columns = run.by_gravity
    for k, axis in enumerate(axes[1:], 1):
        along = ", ".join(f"{v + 0.0:.2g}" for v in axis)
        cause = f"gravity that leans by {{}} deg towards ({along})"
        yield Alternative("gravity", "the direction of gravity", cause, columns[:, :, k : k + 1], DEGREES)


def _of_surroundings(run: LeftOut) -> Iterator[Alternative]:
    position, speed = run.load.pose[:, :3], run.load.twist[:, :3]
    kinds = [("pull", "a constant force along {} of the base", "a hose or a cable that pulls", np.ones_like(speed))]
    if np.ptp(position, axis=0).any():
        kinds.append(("spring", "the position along {}", SPRING, position - position.mean(axis=0)))
        if run.late is not None:
            kinds.append(("drag", "the speed along {}", "a damper, or a hose that is dragged along", speed))
            cause = "friction of a cable chain or a seal"
            kinds.append(("friction", "the sign of the speed along {}", cause, rubbing(speed)))
    for key, follow, cause, forces in kinds:
        columns, each = run.pulled(forces), tuple((follow.format(axis), -1) for axis in "xyz")
        yield Alternative(key, follow.format("x, y and z"), cause, columns, each=each)
        for k in range(3):
            yield Alternative(key, each[k][0], cause, columns[:, :, k : k + 1])


def _of_clocks(run: LeftOut) -> Iterator[Alternative]:
    assert run.late is not None
    cause = "time stamps that are {} % too far apart"
    if not run.motion.by_accelerometer:  # then only the turning goes by the clock
        yield Alternative("clock", "the acceleration", cause, run.by_clock[:, :, None], PERCENT)
    span = (run.t - run.t.mean()) / max(float(np.ptp(run.t)), run.step)
    rate = run.derivative(run.expected, 1)
    cause = "clocks of forces and motion that drift apart by {} ms over the run"
    yield Alternative(
        "drift", "a delay that changes with time", cause, -(rate * span[:, None])[:, :, None], MILLISECONDS
    )
    yield Alternative(
        "skew",
        "the rate of the forces",
        "channels that are late against each other",
        in_own_channel(rate),
        each=_of_itself("its own rate"),
    )
    cause = "a low-pass in the streams, noise of the drives, or a mode of the frame below the cut-off"
    for order in (2, 3, 4) if run.motion.calm else ():
        bend, word = run.derivative(run.expected, order), {2: "second", 3: "third", 4: "fourth"}[order]
        follow = f"the {word} derivative of the forces"
        yield Alternative("smoothing", follow, cause, bend[:, :, None])
        yield Alternative(
            "smoothing", follow, cause, in_own_channel(bend), each=_of_itself(f"the {word} derivative of its own force")
        )
    yield Alternative(
        "hysteresis",
        "the sign of the rate of the forces",
        "hysteresis of the sensors",
        in_own_channel(rubbing(rate)),
        each=_of_itself("the sign of its own rate"),
    )
    loads = [k for k, name in enumerate(run.model.names) if name in ("m", "mxC", "myC", "mzC")]
    if loads:
        for share, word in ((span, "changes with time"), ((span > 0.0) * 1.0, "changes at once")):
            columns = run.matrices[:, :, loads] * share[:, None, None]
            yield Alternative("load", f"a load that {word}", "a payload that was lost, taken up or moved", columns)


def _of_drives(run: LeftOut) -> Iterator[Alternative]:
    if run.by_drives is None or run.motion.drives is None:
        return
    place, v, gains = run.by_drives[0], run.motion.drives[1], run.by_scales
    for k, name in enumerate(run.names.drives):
        unit, word = (DEGREES, "deg") if run.names.turns[k] else (MILLIMETRES, "mm")
        cause = f"a zero of {name} that is wrong by {{}} {word}"
        yield Alternative("zero", f"the position of {name}", cause, -place[:, :, k : k + 1], unit)
        cause = f"a scale of {name} that is wrong by {{}} %"
        yield Alternative("scale", f"the motion of {name}", cause, -gains[:, :, k : k + 1], PERCENT)
    if run.motion.of_pose:
        cause = "zeros of all struts that are wrong by {} mm"
        yield Alternative("zero", "the pose", cause, -place.sum(axis=2, keepdims=True), MILLIMETRES)
        cause = "a scale of all struts that is wrong by {} %"
        yield Alternative("scale", "the pose", cause, -gains.sum(axis=2, keepdims=True), PERCENT)
        yield from _of_joints(run)
    if run.late is not None:
        each = _each("the sign of the speed of {}", run.names.drives)
        yield Alternative(
            "friction",
            "the signs of the drives' speeds",
            "friction in joints or drives",
            in_channels(rubbing(v)),
            each=each,
        )


def _of_joints(run: LeftOut) -> Iterator[Alternative]:
    """Rings of joints of a hexapod that are not as the case says: then struts seem to have other lengths."""
    machine = run.motion.machine
    if not isinstance(machine, Hexapod):
        return
    for ring, points in (("base", machine.base), ("platform", machine.platform)):
        for what, ways, unit, word in ring_changes(points):
            if what == "height":
                continue  # of the base or of the platform, it moves the pose as a whole
            columns = -run.by_joints(machine, ring, ways)  # the run is of the larger ring
            cause = f"a {what} of the {ring} joints' ring that is {{}} {word} larger than the case says"
            yield Alternative("ring", "the pose", cause, columns, unit)


def _of_motion(run: LeftOut) -> Iterator[Alternative]:
    described = (run.load.pose, run.load.twist, run.load.twist_rate)
    if run.motion.by_accelerometer:
        yield from _of_orientation(run)
        return
    if run.motion.drives is not None and not run.motion.of_pose:
        described = run.motion.drives
    names = run.names.coordinates
    place, *moving = (scaled(values) for values in described)
    each = _each("the position of {}", names)
    yield Alternative("place", "the position", BY_PLACE, in_channels(place), each=each)
    first, second = np.triu_indices(place.shape[1])
    pairs = tuple(names[i] if i == j else f"{names[i]} and {names[j]}" for i, j in zip(first, second, strict=True))
    each = _each("products of the position of {}", pairs)
    yield Alternative(
        "place", "the position", BY_PLACE, in_channels(scaled(place[:, first] * place[:, second])), each=each
    )
    if run.late is not None:
        for key, values, cause in zip(("speed", "acceleration"), moving, (BY_RATE, BY_ACCELERATION), strict=True):
            yield Alternative(key, f"the {key}", cause, in_channels(values), each=_each(f"the {key} of {{}}", names))


def _of_orientation(run: LeftOut) -> Iterator[Alternative]:
    """Of a motion whose place is not known: how gravity lies in the sensor, and how that turns and is shaken."""
    m, into_sensor = run.load, run.turn.transpose(0, 2, 1)
    specific_force = into_sensor @ (m.twist_rate[:, :3] - run.model.gravity)[:, :, None]
    kinds = (
        ("place", "the orientation", "gravity along {} of the sensor", into_sensor[:, :, 2], BY_ORIENTATION),
        (
            "speed",
            "the speed",
            "the speed about {} of the sensor",
            (into_sensor @ m.twist[:, 3:, None])[:, :, 0],
            BY_RATE,
        ),
        (
            "acceleration",
            "the acceleration",
            "the acceleration along {} of the sensor",
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
