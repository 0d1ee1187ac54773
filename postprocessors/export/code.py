"""The measurement model as code: C99, a component of LinuxCNC, Structured Text.

A CasADi function becomes straight-line code: the instructions of its evaluation, and how a language spells them. The
mathematics stays CasADi's own expression graph; only the spelling of `a + b` or `sin(a)` is decided here. Templates
contain the text for people around it.
"""

from collections.abc import Callable, Iterator, Mapping

import casadi as ca

from cases.schema import Case
from cases.units import DEG
from identification.hexapod import Hexapod
from identification.model import Model
from identification.outcome import Result
from identification.symbolic import rotation, twist, twist_rate
from postprocessors.export.calibration import number, rendered

RING = 256  # cycles in the memory of the signal chain: 40 ms of delay and as much window at 4 kHz

_MATH = {ca.OP_SQRT: "sqrt({0})", ca.OP_SIN: "sin({0})", ca.OP_COS: "cos({0})", ca.OP_ATAN2: "atan2({0}, {1})"}


_HALF_GAIN = 0.443  # cut-off times half window: a triangle of half width T has the gain sinc(f T)^2, 1/2 at f T = 0.443


def half_window(case: Case) -> float:
    """Half width [s] of the triangle with half the gain where the identification's filter has it; 10 ms without one."""
    cutoff = case.recording.filter_cutoff_Hz
    return 0.010 if cutoff is None else round(_HALF_GAIN / cutoff, 6)


def c_sources(result: Result, name: str) -> tuple[str, str]:
    """Header and source in C99 of a model called `name`."""
    declarations, definitions = c_parts(result, name, "")
    return (
        rendered("header.h.jinja", result, name, declarations=declarations),
        rendered("source.c.jinja", result, name, definitions=definitions),
    )


def c_parts(result: Result, name: str, linkage: str) -> tuple[str, str]:
    """Declarations and definitions without their files; `linkage` is empty or `static `."""
    half, functions = half_window(result.case), functions_of(result)
    values = {
        "linkage": linkage,
        "ring": RING,
        "half_window": number(half),
        "window_meaning": f"half gain at {_HALF_GAIN / half:.3g} Hz",
        "functions": [_c_function(f, name, result.model.names) for f in functions],
    }
    return (
        rendered("declarations.c.jinja", result, name, **values),
        rendered("definitions.c.jinja", result, name, **values),
    )


def _c_function(function: ca.Function, name: str, parameters: list[str]) -> dict[str, object]:
    form = "const double {} = {};", "{} = {};"
    code = statements(function, INFIX | _MATH, lambda k, _: f"t{k}", form, [f"u->{name}" for name in parameters])
    arguments = [
        f"const {name}_parameters *u" if n == "u" else f"const double {n}[{function.numel_in(k)}]"
        for k, n in enumerate(function.name_in())
    ]
    arguments += [f"double {n}[{function.numel_out(k)}]" for k, n in enumerate(function.name_out())]
    shown = {"name": function.name(), "comment": signature(function), "statements": code}
    return shown | {"arguments": ", ".join(arguments)}


AXES = (("fx", "[N]"), ("fy", "[N]"), ("fz", "[N]"), ("mx", "[N m]"), ("my", "[N m]"), ("mz", "[N m]"))


def linuxcnc_component(result: Result, name: str) -> str:
    """The text of a component called `name`."""
    declarations, definitions = c_parts(result, name, "static ")
    return rendered(
        "component.comp.jinja",
        result,
        name,
        hal=name.replace("_", "-"),
        wrench=AXES,
        half_window=number(half_window(result.case)),
        degree=number(DEG),
        declarations=declarations,
        definitions=definitions,
    )


def structured_text(result: Result, name: str) -> str:
    """The text of a model called `name`: structure, constants, functions and function block."""
    camel = "".join(part.capitalize() for part in name.split("_"))
    functions = functions_of(result)
    spelled = [_st_function(f, camel, result.model.names) for f in functions]
    return rendered("model.st.jinja", result, name, Name=camel, functions=spelled)


def _st_function(function: ca.Function, camel: str, parameters: list[str]) -> dict[str, object]:
    operations = INFIX | {
        ca.OP_SQRT: "SQRT({0})",
        ca.OP_SIN: "SIN({0})",
        ca.OP_COS: "COS({0})",
        ca.OP_ATAN2: f"F_{camel}Atan2({{0}}, {{1}})",
    }
    form = "{} := {};", "{} := {};"
    code = statements(function, operations, lambda _, slot: f"t[{slot}]", form, [f"u.{name}" for name in parameters])
    arguments = [
        f"u : ST_{camel}Parameters;" if n == "u" else f"{n} : ARRAY[0..{function.numel_in(k) - 1}] OF LREAL;"
        for k, n in enumerate(function.name_in())
    ]
    arguments += [f"{n} : ARRAY[0..{function.numel_out(k) - 1}] OF LREAL;" for k, n in enumerate(function.name_out())]
    shown = {"name": function.name(), "comment": signature(function), "statements": code}
    return shown | {"arguments": arguments, "slots": function.sz_w()}


INFIX = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
}
"""Operations with the same spelling in C and Structured Text."""


def operand(value: float) -> str:
    """A literal inside an expression: in brackets if negative."""
    text = number(value)
    return f"({text})" if text.startswith("-") else text


def statements(
    function: ca.Function,
    operations: Mapping[int, str],
    temporary: Callable[[int, int], str],
    form: tuple[str, str],
    members: list[str],
) -> Iterator[str]:
    """The statements that evaluate `function`, in order.

    Outputs are stored while inputs are still read: they must not share memory.

    Args:
        function: an SX function with dense inputs and outputs.
        operations: format string of each operation of CasADi.
        temporary: an intermediate value, from its number (each is assigned once) and its slot (reused when free).
        form: assignments to an intermediate value and to an element of an output, from its name and an expression.
        members: elements of the argument u, which is a structure.

    Raises:
        ValueError: a sparse output, or an operation that has no spelling.
    """
    for k in range(function.n_out()):
        if not function.sparsity_out(k).is_dense():
            raise ValueError(f"{function.name()}: output {function.name_out(k)} is not dense")
    values: dict[int, str] = {}  # present value of each slot of CasADi's work vector
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        read, written = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_CONST:
            values[written[0]] = operand(function.instruction_constant(k))
        elif code == ca.OP_INPUT:
            argument, element = function.name_in(read[0]), read[1]
            values[written[0]] = members[element] if argument == "u" else f"{argument}[{element}]"
        elif code == ca.OP_OUTPUT:
            yield form[1].format(f"{function.name_out(written[0])}[{written[1]}]", values[read[0]])
        else:
            if code not in operations:
                raise ValueError(f"{function.name()}: instruction {k} has operation {code}, which has no spelling")
            expression = operations[code].format(*(values[slot] for slot in read))
            values[written[0]] = temporary(k, written[0])
            yield form[0].format(values[written[0]], expression)


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
        [ca.densify(-model.structure_at(pose) @ residuals), ca.densify(residuals)],
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


def functions_of(result: Result) -> list[ca.Function]:
    """All functions of a model; those of the mechanics where there is a hexapod."""
    own = mechanics(Hexapod.of(result.case)) if result.case.hexapod is not None else ()
    return [measurement(result.model), coordinates(), *own]


def signature(function: ca.Function) -> str:
    """Names of what goes in and comes out, for comments."""
    return f"({', '.join(function.name_in())}) -> {', '.join(function.name_out())}"
