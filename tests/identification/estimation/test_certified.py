"""Linear least squares whose answers are certified: Longley and Wampler of NIST's Statistical Reference Datasets.

Longley: seven unknowns of economic data that are nearly dependent. Wampler: polynomials of degree 5, 0 to 20.
"""

import numpy as np
import pytest

from identification.estimation.fit import Regression, gauss_markov

LONGLEY = np.array(
    [
        [60323, 83.0, 234289, 2356, 1590, 107608, 1947],
        [61122, 88.5, 259426, 2325, 1456, 108632, 1948],
        [60171, 88.2, 258054, 3682, 1616, 109773, 1949],
        [61187, 89.5, 284599, 3351, 1650, 110929, 1950],
        [63221, 96.2, 328975, 2099, 3099, 112075, 1951],
        [63639, 98.1, 346999, 1932, 3594, 113270, 1952],
        [64989, 99.0, 365385, 1870, 3547, 115094, 1953],
        [63761, 100.0, 363112, 3578, 3350, 116219, 1954],
        [66019, 101.2, 397469, 2904, 3048, 117388, 1955],
        [67857, 104.6, 419180, 2822, 2857, 118734, 1956],
        [68169, 108.4, 442769, 2936, 2798, 120445, 1957],
        [66513, 110.8, 444546, 4681, 2637, 121950, 1958],
        [68655, 112.6, 482704, 3813, 2552, 123366, 1959],
        [69564, 114.2, 502601, 3931, 2514, 125368, 1960],
        [69331, 115.7, 518173, 4806, 2572, 127852, 1961],
        [70551, 116.9, 554894, 4007, 2827, 130081, 1962],
    ]
)
COEFFICIENTS = np.array(
    [
        -3482258.63459582, 15.0618722713733, -0.358191792925910e-01, -2.02022980381683, -1.03322686717359,
        -0.511041056535807e-01, 1829.15146461355,
    ]
)  # fmt: skip
DEVIATIONS = np.array(
    [
        890420.383607373, 84.9149257747669, 0.334910077722432e-01, 0.488399681651699, 0.214274163161675,
        0.226073200069370, 455.478499142212,
    ]
)  # fmt: skip


def certified(columns: np.ndarray, values: np.ndarray) -> Regression:
    """A regression of one channel, columns of shape (n, u)."""
    return Regression(columns[:, None, :], values[:, None], [f"B{k}" for k in range(columns.shape[1])])


def test_longley_has_its_certified_coefficients_and_deviations() -> None:
    columns = np.column_stack([np.ones(len(LONGLEY)), LONGLEY[:, 1:]])
    fit = gauss_markov(certified(columns, LONGLEY[:, 0]), np.ones(1))
    np.testing.assert_allclose(fit.values, COEFFICIENTS, rtol=1e-8)
    np.testing.assert_allclose(np.sqrt(np.diag(fit.covariance)), DEVIATIONS, rtol=1e-8)
    assert fit.white_noise == pytest.approx(304.854073561965, rel=1e-10)
    assert fit.freedom == 9


@pytest.mark.parametrize("base", [1.0, 0.1], ids=["Wampler1", "Wampler2"])
def test_wampler_has_its_certified_coefficients(base: float) -> None:
    x, powers = np.arange(21.0), np.arange(6)
    columns = x[:, None] ** powers
    fit = gauss_markov(certified(columns, columns @ base**powers), np.ones(1))
    np.testing.assert_allclose(fit.values, base**powers, rtol=1e-7)
    assert fit.white_noise < 1e-13 * np.abs(columns @ base**powers).max()
