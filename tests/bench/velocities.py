"""Whether velocities that drives record make better accelerations, (8), (9), than positions differentiated twice.

Prints by how much errors of parameters change (geometric mean over the twenty of model 9), for encoders of 1 to 10 um.
"""

from collections.abc import Callable

import numpy as np

from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from identification.machines.of_case import machine_of
from identification.model.model import identification_model, regressors
from identification.model.parameters import linear_parameters
from identification.signals import Filter, decimated
from tests.helpers import Harmonic

CASE = load_case("hexapod")
MODEL, HEXAPOD = identification_model(CASE, 9), Hexapod.of(CASE)
U = linear_parameters(MODEL, CASE.need_simulation("the bench").parameters)
STEP, FINE, DURATION, SEEDS = 1e-3, 8, 4.0, 8
LOW_PASS = Filter(40.0, STEP, 0.04)
COUNT = int(DURATION / STEP)
LENGTHS = HEXAPOD.strut_lengths(
    Harmonic(seed=2, duration=DURATION).at(np.arange(-FINE, COUNT * FINE) * STEP / FINE).coordinates
)  # eight times a sample, from one sample before the first
ROWS = np.arange(0, COUNT - 2 * LOW_PASS.margin, LOW_PASS.stride)


def readings(resolution: float, draw: np.random.Generator) -> np.ndarray:
    """Lengths as an encoder reads them, quantised and with as much white noise, eight times a sample [m]."""
    return np.round(LENGTHS / resolution) * resolution + 0.29 * resolution * draw.normal(size=LENGTHS.shape)


def at_samples(fine: np.ndarray, later: int = FINE) -> np.ndarray:
    return fine[later::FINE][:COUNT]


def differences(fine: np.ndarray) -> np.ndarray:
    """Speeds half a sample before each: what it is now less what it was a sample ago [m/s]."""
    return (at_samples(fine) - at_samples(fine, 0)) / STEP


def slopes(fine: np.ndarray) -> np.ndarray:
    """The same by the slope of a straight line through the nine readings in between."""
    k = np.arange(FINE + 1) - FINE / 2
    return np.asarray(sum(w * at_samples(fine, j) for j, w in enumerate(k / (k @ k) / (STEP / FINE))))


def estimate(motion: list[np.ndarray], forces: np.ndarray) -> np.ndarray:
    matrix = regressors(MODEL, machine_of(CASE).kinematics(*motion)).reshape(-1, len(U))
    return np.asarray(np.linalg.lstsq(matrix, forces.ravel(), rcond=None)[0])


def errors(
    resolution: float, noise: float, speeds: Callable[[np.ndarray], np.ndarray] | None, finer: float
) -> np.ndarray:
    """Rms errors of u by positions alone, or with speeds of the drives, which read so many times finer."""
    derivatives = [(order, 0.0) for order in range(3)]
    exact = (
        regressors(MODEL, machine_of(CASE).kinematics(*decimated(LOW_PASS, at_samples(LENGTHS), ROWS, derivatives))) @ U
    )
    off = []
    for seed in range(SEEDS):
        draw = np.random.default_rng(seed)
        forces = exact + noise * np.sqrt(LOW_PASS.noise_gain) * draw.normal(size=exact.shape)
        read = readings(resolution, draw)
        motion = decimated(LOW_PASS, at_samples(read), ROWS, derivatives)
        if speeds is not None:
            own = read if finer == 1.0 else readings(resolution / finer, draw)
            motion[1:] = decimated(LOW_PASS, speeds(own), ROWS, [(0, -STEP / 2), (1, -STEP / 2)])
        off.append(estimate(motion, forces) - U)
    return np.asarray(np.sqrt(np.mean(np.square(off), axis=0)))


WAYS = (
    ("differences of the same readings", differences, 1.0),
    ("slopes through the same readings", slopes, 1.0),
    ("differences of readings ten times finer than the positions that are recorded", differences, 10.0),
)


def main() -> None:
    for resolution in (1e-6, 3e-6, 10e-6):
        for noise in (0.0, 1.0):
            usual = errors(resolution, noise, None, 1.0)
            for words, speeds, finer in WAYS:
                ratio = np.exp(np.mean(np.log(errors(resolution, noise, speeds, finer) / usual)))
                print(f"encoders of {1e6 * resolution:.0f} um, forces {noise:g} N: {words}: errors {ratio:.2f} times")


if __name__ == "__main__":
    main()
