"""Evaluates a CasADi function over many samples at once, straight into NumPy memory.

`Function.map` with `.full()` costs five times the evaluation itself; a FunctionBuffer costs nothing on top. CasADi is
column-major: one column a sample, so that memory order equals NumPy's rows.
"""

from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
CHUNK = 1000  # samples a call: results stay in the cache of the processor, memory stays bounded


@lru_cache(maxsize=64)
def _mapped(function: ca.Function, count: int) -> ca.Function:
    return function.map(count)


def over_samples(function: ca.Function, *arguments: ArrayLike) -> list[Array]:
    """Values of `function` for each sample.

    Args:
        function: dense inputs and outputs; inputs are column vectors.
        arguments: one array for each input, shape (n, length of the input).

    Returns:
        One array for each output: shape (n, rows) for vectors, (n, rows, columns) for matrices.

    Raises:
        ValueError: an argument has the wrong shape.
    """
    inputs = [np.ascontiguousarray(a, dtype=float) for a in arguments]
    count = inputs[0].shape[0]
    for k, value in enumerate(inputs):
        if value.shape != (count, function.size1_in(k)):
            raise ValueError(
                f"{function.name()}: input {k} has shape {value.shape}, expected {(count, function.size1_in(k))}"
            )
    # A matrix leaves CasADi column by column: shape (n, columns, rows) in C order, turned round at the end.
    outputs = [np.empty((count, function.size2_out(k), function.size1_out(k))) for k in range(function.n_out())]
    for start in range(0, count, CHUNK):
        stop = min(start + CHUNK, count)
        buffer, evaluate = _mapped(function, stop - start).buffer()
        for k, value in enumerate(inputs):
            buffer.set_arg(k, value[start:stop].data)
        for k, result in enumerate(outputs):
            buffer.set_res(k, result[start:stop].data)
        evaluate()
    return [r[:, 0, :] if r.shape[1] == 1 else r.transpose(0, 2, 1) for r in outputs]
