"""Damages of recordings, each in sizes from harmless to hopeless."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import bilinear, lfilter

from tests.damaged.runs import Change, Machine
from tests.machines_in_numpy import Array, ChainPlant, HexapodPlant, Motion, _turn


@dataclass(frozen=True)
class Damage:
    """A damage in ascending sizes."""

    name: str
    unit: str
    sizes: tuple[float, ...]
    change: Callable[[Machine, float], Change]
    # no data can show it: it looks like another mass, another offset, or another place of the load
    invisible: bool = False
    model: int | None = None
    what: frozenset[str] = frozenset({"hexapod", "chain"})  # kinds of machines


def _forces(function: Callable[[Machine, float, Motion, Array], Array]) -> Callable[[Machine, float], Change]:
    return lambda of, size: Change(forces=lambda now, own, _: function(of, size, now, own))


def _drives(
    function: Callable[[float, Motion, Array, np.random.Generator], Array],
) -> Callable[[Machine, float], Change]:
    return lambda of, size: Change(drives=lambda now, own, draw: function(size, now, own, draw))


def _plant(
    function: Callable[[HexapodPlant | ChainPlant, float], HexapodPlant | ChainPlant],
) -> Callable[[Machine, float], Change]:
    return lambda of, size: Change(plant=function(of.plant, size))


def _pull(function: Callable[[Machine, float, Motion], Array]) -> Callable[[Machine, float], Change]:
    """A force on the origin of {P} in the axes of {B}."""

    def change(of: Machine, size: float) -> Change:
        def wrench(now: Motion) -> Array:
            force = (now.turn.transpose(0, 2, 1) @ function(of, size, now)[:, :, None])[:, :, 0]
            return np.hstack([force, np.zeros_like(force)])

        return Change(pull=wrench)

    return change


def lagged(values: Array, step: float, tau: float) -> Array:
    """Behind a first-order low-pass of a time constant [s]."""
    share = np.exp(-step / tau)
    return np.asarray(lfilter([1.0 - share], [1.0, -share], values - values[0], axis=0) + values[0])


def ringing(values: Array, step: float, frequency: float, damping: float) -> Array:
    """What comes through a mode of a frame."""
    omega = 2.0 / step * np.tan(np.pi * frequency * step)
    b, a = bilinear([omega**2], [1.0, 2.0 * damping * omega, omega**2], 1.0 / step)
    return np.asarray(lfilter(b, a, values - values[0], axis=0) + values[0])


def step_of(now: Motion) -> float:
    return float(now.t[1] - now.t[0])


def _gain(of: Machine, size: float, now: Motion, own: Array, channel: int) -> Array:
    return own * (1.0 + 0.01 * size * np.eye(6)[channel])


def _gains(channel: int) -> Callable[[Machine, float], Change]:
    def change(of: Machine, size: float) -> Change:
        truth = of.truth
        truth[f"f_q0_{channel + 1}"] *= 1.0 + 0.01 * size
        return Change(forces=lambda now, own, _: _gain(of, size, now, own, channel), truth=truth)

    return change


def _crossed(of: Machine, size: float, now: Motion, own: Array) -> Array:
    units = of.noise / of.noise[0]
    return own + 0.01 * size * np.roll(own / units, 1, axis=1) * units


def _bent(of: Machine, size: float) -> Change:
    def forces(now: Motion, own: Array, draw: np.random.Generator) -> Array:
        del draw
        return own + 0.01 * size * own**2 / np.abs(own).max(axis=0)

    # what a bent channel reads without a load is not the offset of the line that fits it best
    return Change(forces=forces, truth={k: v for k, v in of.truth.items() if not k.startswith("f_q0")})


def _sluggish(of: Machine, size: float, now: Motion, own: Array) -> Array:
    """Play of so many deviations of the noise."""
    half, out = size * of.noise / 2.0, own.copy()
    for k in range(1, len(own)):
        out[k] = np.clip(out[k - 1], own[k] - half, own[k] + half)
    return out


def _touching(of: Machine, size: float, now: Motion) -> Array:
    on = (now.t % 0.9 < 0.25) & (now.t > 0.6)
    return on[:, None] * size * of.noise[0] * np.array([0.5, 0.3, -0.8])


def _steps(size: float, of: Array) -> Array:
    return np.round(of / size) * size


def _gravity(plant: HexapodPlant | ChainPlant, degrees: float) -> HexapodPlant | ChainPlant:
    turn = _turn(np.array([1.0, 0.0, 0.0]), np.radians([degrees]))[0]
    return replace(plant, gravity=turn @ plant.gravity)


def _hexapod(function: Callable[[HexapodPlant, float], HexapodPlant]) -> Callable[[Machine, float], Change]:
    def change(of: Machine, size: float) -> Change:
        assert isinstance(of.plant, HexapodPlant)
        return Change(plant=function(of.plant, size))

    return change


def _wider(points: Array, share: float) -> Array:
    return points * [1.0 + share, 1.0 + share, 1.0]


def _pairs(points: Array, degrees: float) -> Array:
    """Pairs opened by an angle each side."""
    turns = [_turn(np.array([0.0, 0.0, 1.0]), np.radians([degrees if k % 2 else -degrees]))[0] for k in range(6)]
    return np.array([turn @ point for turn, point in zip(turns, points, strict=True)])


def _bars(plant: HexapodPlant, lower: Array) -> HexapodPlant:
    assert plant.bars is not None
    return replace(plant, bars=(lower, plant.bars[1]))


def _lower(plant: HexapodPlant) -> Array:
    assert plant.bars is not None
    return plant.bars[0]


def _height(plant: HexapodPlant) -> float:
    assert plant.bars is not None
    return float(plant.bars[1][0, 2])


def _chain(function: Callable[[ChainPlant, float], ChainPlant]) -> Callable[[Machine, float], Change]:
    def change(of: Machine, size: float) -> Change:
        assert isinstance(of.plant, ChainPlant)
        return Change(plant=function(of.plant, size))

    return change


def _zero(plant: ChainPlant, degrees: float) -> ChainPlant:
    turning = [k for k, joint in enumerate(plant.joints) if not joint.slides]
    return replace(plant, zeros=np.radians(degrees) * np.eye(len(plant.joints))[turning[-2]])


def _lost(of: Machine, size: float) -> Change:
    """A payload that is lost half way; its mass in % of the load."""
    body = of.plant.body
    heavy = body.and_point(0.01 * size * body.mass, 1.3 * body.centre)

    def wrench(now: Motion) -> Array:
        before = (now.t < now.t.mean())[:, None]
        return before * (of.plant.wrench(now, heavy) - of.plant.wrench(now))

    return Change(pull=wrench)


def _rattling(of: Machine, size: float) -> Change:
    """A tenth of the load that shifts along x with the acceleration, by up to so many mm."""

    def wrench(now: Motion) -> Array:
        most = max(float(np.abs(now.acceleration[:, 0]).max()), 1e-9)
        side = np.tanh(now.acceleration[:, 0] / (0.2 * most))
        force = of.plant.wrench(now)[:, :3] * 0.1
        arm = np.zeros_like(force)
        arm[:, 0] = side * size * 1e-3
        return np.hstack([np.zeros_like(force), np.cross(arm, force)])

    return Change(pull=wrench)


HEXAPOD, CHAIN = frozenset({"hexapod"}), frozenset({"chain"})

DAMAGES: tuple[Damage, ...] = (
    Damage("gain of channel 1", "%", (0.1, 0.5, 1.0, 2.0, 5.0, 10.0), _gains(0)),
    Damage("gain of channel 3", "%", (0.5, 2.0, 5.0), _gains(2)),
    Damage("gain of channel 5", "%", (0.5, 2.0, 5.0), _gains(4)),
    Damage("cross-talk to the neighbour", "%", (0.2, 1.0, 3.0), _forces(_crossed)),
    Damage("sensors that are not linear", "%", (0.1, 0.5, 2.0), _bent),
    Damage("play of the sensors", "noise", (1.0, 5.0, 20.0), _forces(_sluggish)),
    Damage(
        "clock scale",
        "ppm",
        (100, 1e3, 5e3, 1e4, 2e4),
        lambda of, size: Change(clock=lambda t: t * (1.0 + 1e-6 * size)),
    ),
    Damage(
        "clocks that drift apart",
        "ppm",
        (20, 100, 1e3),
        lambda of, size: Change(forces=lambda now, own, _: _sheared(now, own, 1e-6 * size)),
    ),
    Damage("channel 2 late", "ms", (0.2, 1.0, 5.0), lambda of, size: Change(late=1e-3 * size * np.eye(6)[1])),
    Damage("gravity leans", "deg", (0.1, 0.3, 1.0, 5.0), _plant(_gravity)),
    Damage(
        "forces low-passed",
        "ms",
        (1.0, 3.0, 10.0, 30.0),
        _forces(lambda of, size, now, own: lagged(own, step_of(now), 1e-3 * size)),
    ),
    Damage(
        "drives low-passed",
        "ms",
        (1.0, 5.0, 20.0),
        _drives(lambda size, now, own, _: lagged(own, step_of(now), 1e-3 * size)),
    ),
    Damage(
        "mode of the frame, damping 0.02",
        "Hz",
        (80.0, 25.0),
        _forces(lambda of, size, now, own: ringing(own, step_of(now), size, 0.02)),
    ),
    Damage(
        "mode of the frame, damping 0.05",
        "Hz",
        (40.0, 12.0, 6.0),
        _forces(lambda of, size, now, own: ringing(own, step_of(now), size, 0.05)),
    ),
    Damage(
        "steps of the encoders",
        "um",
        (10.0, 50.0, 100.0, 300.0),
        _drives(lambda size, now, own, _: _steps(1e-6 * size, own)),
    ),
    Damage(
        "noise of the drives",
        "um",
        (5.0, 20.0, 50.0, 100.0),
        _drives(lambda size, now, own, draw: own + 1e-6 * size * draw.normal(size=own.shape)),
    ),
    Damage(
        "warm-up of all channels",
        "noise",
        (0.5, 1.0, 5.0),
        _forces(lambda of, size, now, own: own + size * of.noise * np.exp(-now.t / 3.0)[:, None]),
    ),
    Damage(
        "drift of channel 4",
        "noise",
        (0.2, 1.0, 5.0),
        _forces(lambda of, size, now, own: own + np.outer(now.t / now.t[-1], size * of.noise * np.eye(6)[3])),
    ),
    Damage(
        "step of channel 2",
        "noise",
        (0.5, 2.0, 10.0),
        _forces(lambda of, size, now, own: own + np.outer(now.t > now.t.mean(), size * of.noise * np.eye(6)[1])),
    ),
    Damage("contact again and again", "noise", (2.0, 5.0, 20.0), _pull(_touching)),
    Damage(
        "constant pull in {B}, along x",
        "noise",
        (1.0, 5.0, 20.0),
        _pull(lambda of, size, now: np.outer(np.ones(len(now.t)), size * of.noise[0] * np.array([1.0, 0.0, 0.0]))),
    ),
    Damage(
        "constant pull in {B}, down",
        "noise",
        (1.0, 5.0, 20.0),
        _pull(lambda of, size, now: np.outer(np.ones(len(now.t)), size * of.noise[0] * np.array([0.0, 0.0, -1.0]))),
    ),
    Damage(
        "hose spring",
        "noise over the way",
        (1.0, 5.0, 20.0),
        _pull(
            lambda of, size, now: (
                -size * of.noise[0] * (now.p - now.p.mean(axis=0)) / np.abs(now.p - now.p.mean(axis=0)).max()
            )
        ),
    ),
    Damage(
        "friction of a cable along x",
        "noise",
        (1.0, 5.0, 20.0),
        _pull(
            lambda of, size, now: np.outer(
                -np.tanh(now.velocity[:, 0] / 0.005), size * of.noise[0] * np.array([1.0, 0.0, 0.0])
            )
        ),
    ),
    Damage(
        "friction of the drives on the forces",
        "noise",
        (0.5, 2.0, 10.0),
        _forces(
            lambda of, size, now, own: (
                own + size * of.noise * np.tanh(np.resize(now.q_rate.T, (6, len(now.t))).T / 0.01)
            )
        ),
    ),
    Damage("payload lost half way", "%", (0.2, 1.0, 5.0), _lost),
    Damage("a tenth of the load rattles", "mm", (1.0, 5.0, 20.0), _rattling),
    Damage(
        "base radius",
        "%",
        (0.05, 0.1, 0.3, 1.0),
        _hexapod(lambda p, s: replace(p, base=_wider(p.base, 0.01 * s))),
        what=HEXAPOD,
    ),
    Damage(
        "platform radius",
        "%",
        (0.1, 0.3, 1.0),
        _hexapod(lambda p, s: replace(p, platform=_wider(p.platform, 0.01 * s))),
        what=HEXAPOD,
    ),
    Damage(
        "bars' lower radius",
        "%",
        (0.1, 0.5, 2.0),
        _hexapod(lambda p, s: _bars(p, _wider(_lower(p), 0.01 * s))),
        what=HEXAPOD,
    ),
    Damage(
        "bars' lower height",
        "% of the height",
        (0.1, 1.0, 3.0),
        _hexapod(lambda p, s: _bars(p, _lower(p) + np.array([0.0, 0.0, 0.01 * s * _height(p)]))),
        what=HEXAPOD,
    ),
    Damage(
        "bars' lower angle",
        "deg",
        (0.1, 0.5, 1.0, 3.0),
        _hexapod(lambda p, s: _bars(p, _pairs(_lower(p), s))),
        what=HEXAPOD,
    ),
    Damage(
        "stroke of all struts",
        "%",
        (0.05, 0.1, 0.5),
        _drives(lambda s, now, own, _: own + 0.01 * s * (own - own[0])),
        what=HEXAPOD,
    ),
    Damage(
        "stroke of strut 3",
        "%",
        (0.1, 1.0),
        _drives(lambda s, now, own, _: own + 0.01 * s * (own - own[0]) * np.eye(6)[2]),
        what=HEXAPOD,
    ),
    Damage(
        "offset of strut 3",
        "mm",
        (0.1, 0.5, 2.0),
        _drives(lambda s, now, own, _: own + 1e-3 * s * np.eye(6)[2]),
        what=HEXAPOD,
    ),
    Damage("offset of all struts", "mm", (0.5, 1.0, 5.0), _drives(lambda s, now, own, _: own + 1e-3 * s), what=HEXAPOD),
    Damage("zero of the last joint but one", "deg", (0.1, 0.3, 1.0, 5.0), _chain(_zero), what=CHAIN),
    Damage(
        "sensor off along z",
        "mm",
        (1.0, 5.0, 20.0),
        _chain(lambda p, s: replace(p, sensor=(p.sensor[0] + 1e-3 * s * np.array([0.0, 0.0, 1.0]), p.sensor[1]))),
        what=CHAIN,
    ),
    Damage(
        "sensor off along x",
        "mm",
        (1.0, 5.0, 20.0),
        _chain(lambda p, s: replace(p, sensor=(p.sensor[0] + 1e-3 * s * np.array([1.0, 0.0, 0.0]), p.sensor[1]))),
        what=CHAIN,
    ),
    Damage(
        "sensor turned about z",
        "deg",
        (0.2, 1.0, 5.0),
        _chain(
            lambda p, s: replace(
                p, sensor=(p.sensor[0], p.sensor[1] @ _turn(np.array([0.0, 0.0, 1.0]), np.radians([s]))[0])
            )
        ),
        what=CHAIN,
    ),
    Damage(
        "sensor turned about x",
        "deg",
        (0.2, 1.0, 5.0),
        _chain(
            lambda p, s: replace(
                p, sensor=(p.sensor[0], p.sensor[1] @ _turn(np.array([1.0, 0.0, 0.0]), np.radians([s]))[0])
            )
        ),
        what=CHAIN,
    ),
    Damage(
        "second link too long",
        "%",
        (1.0, 5.0),
        _chain(
            lambda p, s: replace(
                p,
                joints=(
                    *p.joints[:2],
                    replace(p.joints[2], origin=p.joints[2].origin * (1.0 + 0.01 * s)),
                    *p.joints[3:],
                ),
            )
        ),
        what=CHAIN,
    ),
    Damage(
        "gain of all channels",
        "%",
        (0.5, 5.0),
        _forces(lambda of, size, now, own: own * (1.0 + 0.01 * size)),
        invisible=True,
    ),
    Damage(
        "constant force on the sensor",
        "noise",
        (5.0, 50.0),
        _forces(lambda of, size, now, own: own + size * of.noise),
        invisible=True,
    ),
    Damage(
        "gravity", "%", (0.2,), _plant(lambda p, s: replace(p, gravity=p.gravity * (1.0 + 0.01 * s))), invisible=True
    ),
)
"""Those of which the data show something, and those of which they do not."""


def _sheared(now: Motion, own: Array, rate: float) -> Array:
    """Forces whose clock runs slow by a share."""
    return np.stack([np.interp(now.t * (1.0 - rate), now.t, channel) for channel in own.T], axis=1)


def kind_of(of: Machine) -> str:
    """Kind of a machine, as `Damage.what` has it."""
    return "hexapod" if isinstance(of.plant, HexapodPlant) else "chain"


def damages_of(of: Machine) -> Iterator[Damage]:
    """Damages that a machine can have."""
    yield from (damage for damage in DAMAGES if kind_of(of) in damage.what)
