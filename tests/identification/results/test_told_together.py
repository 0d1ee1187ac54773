"""Sizes that two runs told are one machine's: weighed together they are off by what is said, and by less than each."""

import numpy as np

from cases.schema import Case, load_case
from identification.findings.told import LeftOpen, Together
from identification.results.frames import mounting_of_both

COUNTS = {"sensor_mm": 3, "sensor_deg": 3, "gain_percent": 6}


def told(rng: np.random.Generator, scores: int) -> tuple[LeftOpen, np.ndarray]:
    """What a run with some scores leaves open, and a root of the covariance of its noise."""
    size, through = 12, rng.normal(size=(scores, 12))
    root = rng.normal(size=(scores, scores)) * 0.5
    noise = root @ root.T + 0.1 * np.eye(scores)
    gain = np.linalg.solve(through @ through.T + noise, through).T
    values = 1e-3 * rng.normal(size=(10, size)) @ gain
    return LeftOpen(COUNTS, gain, through, noise, 0.2, values), np.linalg.cholesky(noise)


def test_the_place_by_both_runs_is_off_by_what_is_said() -> None:
    """4000 machines with their noise, of linear runs."""
    rng = np.random.default_rng(3)
    data = load_case("ur10_wrist").model_dump(mode="json", exclude_unset=True)
    stated = {"sensor_mm": 0.1, "sensor_deg": 0.5, "gain_percent": 0.2}
    case = Case.model_validate(data | {"tolerances": stated})
    (one, first), (other, second) = told(rng, 4), told(rng, 6)
    both = Together.of(one, other)
    own = list(range(10))
    mounting = mounting_of_both(case, one, other, (own, own))
    units = np.r_[np.full(3, 1e-4), np.full(3, np.radians(0.5)), np.ones(6)]
    off, crossed, alone = [], [], []
    for _ in range(4000):
        p, n1, n2 = rng.normal(size=12), first @ rng.normal(size=4), second @ rng.normal(size=6)
        sizes = [of.gain @ (of.through @ p + n) for of, n in ((one, n1), (other, n2))]
        error = p - both.first @ sizes[0] - both.second @ sizes[1]
        off.append((units * error)[:6])
        alone.append((units * (p - sizes[1]))[:6])
        crossed.append(-other.of_values @ n2 + one.of_values @ n1)
    robust = mounting.robust
    assert robust is not None
    total = robust[0] + sum(b @ b.T for b in mounting.biases.values())
    np.testing.assert_allclose(np.std(off, axis=0), np.sqrt(np.diag(total)), rtol=0.06)
    assert np.all(np.std(off, axis=0) < 1.02 * np.std(alone, axis=0))
    noise_only = np.array(crossed).T @ np.array(off) / 4000.0
    scale = np.outer(np.std(crossed, axis=0), np.std(off, axis=0))
    np.testing.assert_allclose(noise_only / scale, robust[1] / scale, atol=0.07)
