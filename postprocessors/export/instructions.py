"""A CasADi function as straight-line code: the instructions of its evaluation, and how a language spells them.

The mathematics stays CasADi's own expression graph; only the spelling of `a + b` or `sin(a)` is decided here.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import casadi as ca

_OPERATIONS = {
    ca.OP_ADD: "add",
    ca.OP_SUB: "sub",
    ca.OP_MUL: "mul",
    ca.OP_DIV: "div",
    ca.OP_NEG: "neg",
    ca.OP_SQ: "sq",
    ca.OP_TWICE: "twice",
    ca.OP_INV: "inv",
    ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_ATAN2: "atan2",
}

INFIX = {
    "add": "{0} + {1}",
    "sub": "{0} - {1}",
    "mul": "{0} * {1}",
    "div": "{0} / {1}",
    "neg": "-{0}",
    "sq": "{0} * {0}",
    "twice": "2.0 * {0}",
    "inv": "1.0 / {0}",
}
"""What C and Structured Text spell alike."""


@dataclass(frozen=True, slots=True)
class Language:
    """How a language spells instructions.

    Args:
        operations: format string of each operation.
        temporary: an intermediate value, from its number (each is assigned once) and its slot (reused when free).
        assign: an assignment to an intermediate value, from its name and an expression.
        store: an assignment to an element of an output, from its name and an expression.
        element: element k of the argument called name.
        literal: a number inside an expression.
    """

    operations: dict[str, str]
    temporary: Callable[[int, int], str]
    assign: str
    store: str
    element: Callable[[str, int], str]
    literal: Callable[[float], str]


def number(value: float) -> str:
    """A literal that reads back as the same float64, with a decimal point."""
    text = repr(float(value))
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{exponent}" if exponent else mantissa


def operand(value: float) -> str:
    """The same inside an expression: in brackets if negative."""
    text = number(value)
    return f"({text})" if text.startswith("-") else text


def statements(function: ca.Function, language: Language) -> Iterator[str]:
    """The statements that evaluate `function`, in order.

    Outputs are stored while inputs are still read: they must not share memory.

    Args:
        function: an SX function with dense inputs and outputs.
        language: spells them.

    Raises:
        ValueError: a sparse output, or an operation that has no spelling.
    """
    for k in range(function.n_out()):
        if not function.sparsity_out(k).is_dense():
            raise ValueError(f"{function.name()}: output {function.name_out(k)} is not dense")
    values: dict[int, str] = {}  # what each slot of CasADi's work vector holds now
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        read, written = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_CONST:
            values[written[0]] = language.literal(function.instruction_constant(k))
        elif code == ca.OP_INPUT:
            values[written[0]] = language.element(function.name_in(read[0]), read[1])
        elif code == ca.OP_OUTPUT:
            place = language.element(function.name_out(written[0]), written[1])
            yield language.store.format(place, values[read[0]])
        else:
            if code not in _OPERATIONS:
                raise ValueError(f"{function.name()}: instruction {k} has operation {code}, which has no spelling")
            expression = language.operations[_OPERATIONS[code]].format(*(values[slot] for slot in read))
            values[written[0]] = language.temporary(k, written[0])
            yield language.assign.format(values[written[0]], expression)
