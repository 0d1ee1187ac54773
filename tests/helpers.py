"""What many tests share: a derivative check, a smooth motion, the paper's poses, and the rule of one-line messages."""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import settings
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from cases.base.errors import HexciteError, RecordingError
from cases.base.units import DEG, MM
from cases.schema import Case
from cases.sensors import Disturbances
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Motion
from identification.motion.moves import StraightMove

Array = NDArray[np.float64]
Answer = TypeVar("Answer")

EXAMPLES = 20  # of properties that state no number, with the profile `full`
SHORT_MOVES = Path(__file__).with_name("short_moves.csv")  # a motion by hand of some seconds
HOME = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])


def taylor_slope(function: Callable[[float], Array], at: float, derivative: Array, largest_step: float) -> float:
    """Order of what f(at + h) - f(at) - h f'(at) leaves as h shrinks: 2 for the right derivative, 1 for a wrong one."""
    steps = largest_step * 2.0 ** -np.arange(6)
    start = np.ravel(function(at))
    left = [np.linalg.norm(np.ravel(function(at + h)) - start - h * np.ravel(derivative)) for h in steps]
    return float(np.polyfit(np.log(steps), np.log(left), 1)[0])


@dataclass(frozen=True)
class Harmonic:
    """A smooth, exciting motion about home: four harmonics with seeded amplitudes and phases in every coordinate."""

    seed: int = 0
    duration: float = 3.0
    size: float = 1.0
    home: Array = field(default_factory=lambda: HOME)

    def at(self, t: ArrayLike) -> Motion:
        draw, time = np.random.default_rng(self.seed), np.asarray(t, dtype=float)
        order = np.arange(1, 5)[:, None]
        amplitude = self.size * draw.normal(size=(4, 6)) * ([0.1] * 3 + [0.12] * 3) / order**1.5
        phase, omega = draw.uniform(0.0, 2 * np.pi, (4, 6)), 2 * np.pi / self.duration * order
        angle = omega * time[:, None, None] + phase
        orders = [(amplitude * omega**k * np.sin(angle + k * np.pi / 2)).sum(axis=1) for k in range(4)]
        return Motion(time, self.home + orders[0], *orders[1:])


def paper_poses() -> tuple[Array, Array]:
    """Positions (480, 3) and rotations (480, 3, 3) of section 6, in tilt-and-torsion angles."""
    grid = np.arange(-3, 4) * 0.1
    places = [(x, y, 0.9) for x in grid for y in grid if 0.199 <= np.hypot(x, y) <= 0.301]
    angles = [(a, t, s - a) for t in (10, 20) for a in (0, 90, 180, 270) for s in (-15, 0, 15)]
    turns = Rotation.from_euler("ZYZ", angles, degrees=True).as_matrix()
    return np.repeat(places, len(turns), axis=0), np.tile(turns, (len(places), 1, 1))


def simulated(case: Case, **changes: float) -> Case:
    """The case with other settings of its simulated machine."""
    assert case.simulation is not None
    return case.model_copy(update={"simulation": case.simulation.model_copy(update=changes)})


def ideal(case: Case) -> Case:
    """The case with sensors and encoders without noise, delay or steps."""
    return simulated(
        case, force_noise_N=0.0, encoder_resolution_um=0.0, force_delay_ms=0.0, force_sampling_offset_cycles=0.0
    )


def one_line(error: BaseException) -> str:
    """The message of an error, which must be a single printable line that says something."""
    text = str(error)
    assert text.strip(), "an empty message"
    assert text.isprintable(), repr(text)  # no line breaks, no control characters
    if isinstance(error, HexciteError) and error.args[0].isprintable():
        assert text.startswith(error.place), error.place
        assert text.endswith(error.remedy), error.remedy
    return text


@contextmanager
def refused_at(place: object, match: str, kind: type[HexciteError] = RecordingError) -> Iterator[None]:
    """An error of ours inside, in one line that begins with its place."""
    with pytest.raises(kind, match=match) as caught:
        yield
    assert one_line(caught.value).startswith(str(place))


def answer(call: Callable[[], Answer], place: str) -> Answer | None:
    """What a call gives, or None where it raises an error of ours: one line that names the place."""
    try:
        return call()
    except HexciteError as error:
        message = one_line(error)
    assert place in message
    return None


def jerked(jerk: Array, step: float) -> PolynomialMotion:
    """There and back by steps of constant jerk, from rest to rest: full use of a jerk limit."""
    signs, taylor, built = (1, -1, -1, 1, -1, 1, 1, -1), np.vstack([HOME, np.zeros((3, 6))]), []
    for sign in signs:
        taylor[3] = sign * jerk / 6
        built.append((taylor.copy(), step))
        for order in range(3):
            derivative = np.polynomial.polynomial.polyder(built[-1][0], order)
            taylor[order] = np.polynomial.polynomial.polyval(step, derivative) / (1, 1, 2)[order]
    return PolynomialMotion.of_pieces(built)


def few(*values: object, kept: int = 1) -> list[object]:
    """Values of a parametrisation of which `make test` takes the first ones and `make bench` the others."""
    others = (v if isinstance(v, tuple) else (v,) for v in values[kept:])
    return [*values[:kept], *(pytest.param(*v, marks=pytest.mark.slow) for v in others)]


def seeds(count: int, first: int = 0, at_once: int = 1) -> pytest.MarkDecorator:
    """A test of `count` seeds from `first` on: `make test` runs the first `at_once`, `make bench` the others too."""
    return pytest.mark.parametrize("seed", few(*range(first, first + count), kept=at_once))


def examples(number: int) -> int:
    """How many examples a property is tried with: `number` with the profile `full`, fewer in `make test`."""
    return max(2, math.ceil(number * settings.default.max_examples / EXAMPLES))


def pose_shares(case: Case, poses: Array) -> dict[str, Array]:
    """Shares of the limits of poses that a standstill uses, by kind, shapes (n, limits of the kind).

    Args:
        poses: coordinates, shape (n, k) [m or rad].
    """
    from planner.families.states import state_size
    from planner.search.problem import state_limits

    states = np.hstack([poses, np.zeros((len(poses), state_size(poses.shape[1]) - poses.shape[1]))])
    return {kind: np.abs(kernel.values(states)) for kind, order, kernel in state_limits(case) if order == 0}


def tells(text: str, *facts: str) -> bool:
    """Whether one line of a text holds facts (place, value, limit, remedy) in this order, whatever stands between."""
    return re.search(".*".join(map(re.escape, facts)), text) is not None


def polynomials_of(moves: Sequence[StraightMove]) -> PolynomialMotion:
    """Moves of seven segments one after the other as what they are: a cubic polynomial a segment."""
    return PolynomialMotion.of_pieces(piece for move in moves for piece in _segments(move))


def _segments(move: StraightMove) -> Iterator[tuple[Array, float]]:
    law = move.profile
    durations = np.array(law.lengths)
    starts = np.append(0.0, np.cumsum(durations[:-1]))  # added up as the law does: accelerations may step there
    s, v, a, _ = law.at(starts)
    jerk = law.at(starts + durations / 2)[3]
    way = move.end - move.start
    for k in np.flatnonzero(durations > 1e-9):
        shares = np.array([s[k], v[k], a[k] / 2, jerk[k] / 6])
        coefficients = shares[:, None] * way
        coefficients[0] += move.start
        yield coefficients, float(durations[k])


def pose_covariance(disturbances: Disturbances, home: np.ndarray, poses: np.ndarray, weight: float) -> np.ndarray:
    """Covariance over machines of a sensor's error between poses, under a weight [N], shape (n, n) [N^2]."""
    lengths = np.repeat([disturbances.pose_error_length_mm * MM, disturbances.pose_error_angle_deg * DEG], 3)
    reduced = (poses - home) / lengths
    squares = ((reduced[:, None] - reduced) ** 2).sum(axis=2)
    variance = disturbances.pose_error_N**2 + (weight * disturbances.pose_error_of_load) ** 2
    return np.asarray(variance * np.exp(-squares / 2.0))
