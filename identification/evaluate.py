"""Evaluates a CasADi function over many samples at once, straight into NumPy memory.

Few samples go through CasADi's own interpreter: `Function.map` with `.full()` costs five times the evaluation itself, a
FunctionBuffer costs nothing on top. Of many samples each instruction of the function is one NumPy operation on a few
thousand of them, which is three to eight times as fast: the interpreter's overhead is paid once for all of them.
CasADi is column-major: one column a sample, so that memory order equals NumPy's rows.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
CHUNK = 1000  # samples a call of the interpreter, whose results then stay in the cache of the processor
PART = 6000  # samples that an instruction is executed for at once

_OPERATIONS: dict[int, Callable[..., Any]] = {
    ca.OP_ASSIGN: np.positive, ca.OP_ADD: np.add, ca.OP_SUB: np.subtract, ca.OP_MUL: np.multiply, ca.OP_DIV: np.divide,
    ca.OP_NEG: np.negative, ca.OP_SQ: np.square, ca.OP_SQRT: np.sqrt, ca.OP_INV: np.reciprocal, ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos, ca.OP_ATAN2: np.arctan2, ca.OP_FABS: np.abs, ca.OP_FMIN: np.fmin, ca.OP_FMAX: np.fmax,
}  # fmt: skip
_KNOWN = {*_OPERATIONS, ca.OP_TWICE, ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT}


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
    program = _program(function) if count > CHUNK else None
    if program is not None:
        for start in range(0, count, PART):
            _execute(program, [v[start : start + PART] for v in inputs], [r[start : start + PART] for r in outputs])
    else:
        for start in range(0, count, CHUNK):
            stop = min(start + CHUNK, count)
            buffer, evaluate = _mapped(function, stop - start).buffer()
            for k, value in enumerate(inputs):
                buffer.set_arg(k, value[start:stop].data)
            for k, result in enumerate(outputs):
                buffer.set_res(k, result[start:stop].data)
            evaluate()
    return [r[:, 0, :] if r.shape[1] == 1 else r.transpose(0, 2, 1) for r in outputs]


@lru_cache(maxsize=64)
def _mapped(function: ca.Function, count: int) -> ca.Function:
    return function.map(count)


@lru_cache(maxsize=64)
def _program(function: ca.Function) -> tuple[tuple[int, Sequence[int], Sequence[int], float], ...] | None:
    """Instructions (operation, input, output, constant) of an SX function; None where one is not known here."""
    if not function.is_a("SXFunction") or any(
        function.instruction_id(k) not in _KNOWN for k in range(_length(function))
    ):
        return None
    return tuple(
        (
            function.instruction_id(k),
            function.instruction_input(k),
            function.instruction_output(k),
            function.instruction_constant(k) if function.instruction_id(k) == ca.OP_CONST else 0.0,
        )
        for k in range(_length(function))
    )


def _length(function: ca.Function) -> int:
    return int(function.n_instructions())


def _execute(
    program: Sequence[tuple[int, Sequence[int], Sequence[int], float]], inputs: list[Array], outputs: list[Array]
) -> None:
    """Runs a program for some samples: inputs of shape (n, length), outputs of shape (n, columns, rows)."""
    count = len(inputs[0])
    given = [np.ascontiguousarray(v.T) for v in inputs]
    results = [np.zeros((r.shape[1] * r.shape[2], count)) for r in outputs]
    memory = np.empty((1 + max((max(o, default=0) for op, _, o, _ in program if op != ca.OP_OUTPUT), default=0), count))
    places = list(memory)
    for operation, used, made, constant in program:
        if operation == ca.OP_INPUT:
            places[made[0]] = given[used[0]][used[1]]
        elif operation == ca.OP_OUTPUT:
            results[made[0]][made[1]] = places[used[0]]
        elif operation == ca.OP_CONST:
            places[made[0]] = memory[made[0]]
            places[made[0]].fill(constant)
        else:
            operands = [places[k] for k in used]
            places[made[0]] = memory[made[0]]
            if operation == ca.OP_TWICE:
                np.add(operands[0], operands[0], out=places[made[0]])
            else:
                _OPERATIONS[operation](*operands, out=places[made[0]])
    for result, output in zip(results, outputs, strict=True):
        output.reshape(count, -1)[:] = result.T
