"""A CasADi function as straight-line code: the instructions of its evaluation, and how a language spells them.

The mathematics stays CasADi's own expression graph; only the spelling of `a + b` or `sin(a)` is decided here.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import casadi as ca

from identification.hexapod import Hexapod
from identification.model import Model
from identification.symbolic import rotation, twist, twist_rate

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
class CodeLanguage:
    """How a language spells instructions."""

    operations: dict[str, str]  # format string of each operation
    # an intermediate value, from its number (each is assigned once) and its slot (reused when free)
    temporary: Callable[[int, int], str]
    assign: str  # an assignment to an intermediate value, from its name and an expression
    store: str  # an assignment to an element of an output, from its name and an expression
    element: Callable[[str, int], str]  # element k of the argument called name
    literal: Callable[[float], str]  # a number inside an expression


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


def statements(function: ca.Function, language: CodeLanguage) -> Iterator[str]:
    """The statements that evaluate `function`, in order.

    Outputs are stored while inputs are still read: they must not share memory.

    Args:
        function: an SX function with dense inputs and outputs.

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


def measurement(model: Model) -> ca.Function:
    """(pose, twist, twist_rate, u, forces) -> external (6,), residuals (6,): (1) with (10)-(15).

    `external` is the force and moment that act on the platform, about the origin of {P} and along its axes [N, N m];
    `residuals` are the sensor forces less those that the model expects without contact [N].
    """
    pose, motion, rate, forces = (ca.SX.sym(name, 6) for name in ("pose", "twist", "twist_rate", "forces"))
    u = ca.SX.sym("u", len(model.parameters))
    residuals = forces - model.expression(pose[:3], rotation(pose[3:]), motion, rate) @ u
    return ca.Function(
        "measurement",
        [pose, motion, rate, u, forces],
        [ca.densify(-model.structure_at(pose[:3], rotation(pose[3:])) @ residuals), ca.densify(residuals)],
        ["pose", "twist", "twist_rate", "u", "forces"],
        ["external", "residuals"],
        {"cse": True},
    )


def coordinates() -> ca.Function:
    """(pose, rates, accelerations) -> twist (6,), twist_rate (6,): (37) and (38)."""
    pose, rates, accelerations = (ca.SX.sym(name, 6) for name in ("pose", "rates", "accelerations"))
    return ca.Function(
        "coordinates",
        [pose, rates, accelerations],
        [ca.densify(twist(pose, rates)), ca.densify(twist_rate(pose, rates, accelerations))],
        ["pose", "rates", "accelerations"],
        ["twist", "twist_rate"],
        {"cse": True},
    )


def mechanics(hexapod: Hexapod) -> tuple[ca.Function, ...]:
    """The kinematics of a hexapod, its joints built in.

    struts: pose -> lengths (6,), jacobian (6, 6): J_Hex^-1 of (8);
    newton: pose, correction (6,) -> stepped (6,): the pose after a step of the forward kinematics (7);
    drift: pose, twist -> drift (6,): d/dt(J_Hex^-1) twist of (9).
    """
    pose, motion, step = (ca.SX.sym(name, 6) for name in ("pose", "twist", "correction"))
    lengths, jacobian = hexapod.inverse_jacobian(pose)
    struts = ca.Function(
        "struts", [pose], [lengths, ca.densify(jacobian)], ["pose"], ["lengths", "jacobian"], {"cse": True}
    )
    newton = ca.Function("newton", [pose, step], [hexapod.newton_step(pose, step)], ["pose", "correction"], ["stepped"])
    drift = ca.Function(
        "drift", [pose, motion], [hexapod.jacobian_drift(pose, motion)], ["pose", "twist"], ["drift"], {"cse": True}
    )
    return struts, newton, drift


def functions_of(model: Model, hexapod: Hexapod | None) -> list[ca.Function]:
    """All functions of a model; those of the mechanics where there is a hexapod."""
    return [measurement(model), coordinates(), *(() if hexapod is None else mechanics(hexapod))]


def signature(function: ca.Function) -> str:
    """Names of what goes in and comes out, for comments."""
    return f"({', '.join(function.name_in())}) -> {', '.join(function.name_out())}"
