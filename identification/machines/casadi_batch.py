"""CasADi functions over many samples at once.

Few samples go through CasADi's own interpreter: `Function.map` with `.full()` costs five times the evaluation itself, a
FunctionBuffer costs nothing on top. Of many samples each instruction of the function is one NumPy operation on all of
them, up to a few thousand: the interpreter's overhead is paid once for all of them. That is twice as fast for 300
samples and three to eight times for thousands.
CasADi is column-major: one column a sample, so that memory order equals NumPy's rows.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.units import Array

FEW = 120  # samples at most that the interpreter is quicker for
CHUNK = 1000  # samples a call of the interpreter, whose results then stay in the cache of the processor
PART = 6000  # samples that an instruction is executed for at once

_OPERATIONS: dict[int, Callable[..., Any]] = {
    ca.OP_ASSIGN: np.positive, ca.OP_ADD: np.add, ca.OP_SUB: np.subtract, ca.OP_MUL: np.multiply, ca.OP_DIV: np.divide,
    ca.OP_NEG: np.negative, ca.OP_SQ: np.square, ca.OP_SQRT: np.sqrt, ca.OP_INV: np.reciprocal, ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos, ca.OP_ATAN2: np.arctan2, ca.OP_FABS: np.abs, ca.OP_FMIN: np.fmin, ca.OP_FMAX: np.fmax,
    ca.OP_EXP: np.exp, ca.OP_LOG: np.log, ca.OP_LE: np.less_equal,
}  # fmt: skip
_KNOWN = {*_OPERATIONS, ca.OP_TWICE, ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT}


def over_samples(function: ca.Function, *arguments: ArrayLike) -> list[Array]:
    """Values of a function of dense column vectors, given as arrays of shape (n, length), for each sample.

    One array for each output: shape (n, rows) for vectors, (n, rows, columns) for matrices.
    """
    inputs = [np.ascontiguousarray(a, dtype=float) for a in arguments]
    count = inputs[0].shape[0]
    for k, value in enumerate(inputs):
        if value.shape != (count, function.size1_in(k)):
            raise ValueError(
                f"{function.name()}: input {k} has shape {value.shape}, expected {(count, function.size1_in(k))}"
            )
    # A matrix leaves CasADi column by column: shape (n, columns, rows) in C order, transposed at the end.
    outputs = [np.empty((count, function.size2_out(k), function.size1_out(k))) for k in range(function.n_out())]
    program = _program(function) if count > FEW else None
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


_TWO, _ONE, _FROM_INPUT, _TO_OUTPUT, _FILL = range(5)

_Program = tuple[tuple[tuple[int, Any, int, int, int], ...], int]
"""Instructions, and how many places their results need.

An instruction is its kind, what it does, two numbers, and the place of its result. Operations have a ufunc and the
places of one or two operands; inputs and outputs have their number and row, constants their value.
"""


@lru_cache(maxsize=64)
def _program(function: ca.Function) -> _Program | None:
    """An SX function as a list; None where an instruction is not known here."""
    if not function.is_a("SXFunction"):
        return None
    count = range(function.n_instructions())
    operations = [function.instruction_id(k) for k in count]
    if not _KNOWN.issuperset(operations):
        return None
    instructions: list[tuple[int, Any, int, int, int]] = []
    for k, operation in zip(count, operations, strict=True):
        operands, targets = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            instructions.append((_TO_OUTPUT, None, *targets, operands[0]))
        elif operation == ca.OP_INPUT:
            instructions.append((_FROM_INPUT, None, *operands, targets[0]))
        elif operation == ca.OP_CONST:
            instructions.append((_FILL, function.instruction_constant(k), 0, 0, targets[0]))
        elif operation == ca.OP_TWICE:
            instructions.append((_TWO, np.add, operands[0], operands[0], targets[0]))
        elif len(operands) == 2:
            instructions.append((_TWO, _OPERATIONS[operation], *operands, targets[0]))
        else:
            instructions.append((_ONE, _OPERATIONS[operation], operands[0], 0, targets[0]))
    return tuple(instructions), function.sz_w()


def _execute(program: _Program, inputs: list[Array], outputs: list[Array]) -> None:
    """Runs a program for some samples: inputs of shape (n, length), outputs of shape (n, columns, rows)."""
    (instructions, size), count = program, len(inputs[0])
    arguments = [np.ascontiguousarray(v.T) for v in inputs]
    results = [np.zeros((r.shape[1] * r.shape[2], count)) for r in outputs]
    memory = list(np.empty((size, count)))
    places = memory.copy()
    with np.errstate(all="ignore"):  # as the interpreter: infinity and not a number are answers
        for kind, what, first, second, to in instructions:
            if kind == _TWO:  # a place is replaced at last: an operand may have stood there
                places[to] = what(places[first], places[second], memory[to])
            elif kind == _ONE:
                places[to] = what(places[first], memory[to])
            elif kind == _FROM_INPUT:
                places[to] = arguments[first][second]
            elif kind == _TO_OUTPUT:
                results[first][second] = places[to]
            else:
                memory[to].fill(what)
                places[to] = memory[to]
    for result, output in zip(results, outputs, strict=True):
        output.reshape(count, -1)[:] = result.T
