"""The measurement model as code: C99, a component of LinuxCNC, Structured Text, Python.

A CasADi function becomes straight-line code: the instructions of its evaluation, and how a language spells them. The
mathematics stays CasADi's own expression graph; only the spelling of `a + b` or `sin(a)` is decided here. Templates
contain the text for people around it.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import casadi as ca

from cases.base.errors import Code, HexciteError
from cases.base.units import DEG
from cases.schema import Case
from identification.machines.hexapod import Hexapod
from identification.machines.rotations import rotation, twist, twist_rate
from identification.machines.serial_chain import SerialChain
from identification.model.model import Model
from identification.options import FrameName
from identification.results.chain_uncertainty import anywhere
from identification.results.expected_residuals import NOISE
from identification.results.frames import Place, place_of
from identification.results.result import Result
from postprocessors.export.calibration import number, rendered

RING = 256  # cycles in the memory of the signal chain: 40 ms of delay and as much window at 4 kHz

_HALF_GAIN = 0.443  # cut-off times half window: a triangle of half width T has the gain sinc(f T)^2, 1/2 at f T = 0.443


def half_window(case: Case) -> float:
    """Half width [s] of the triangle with half the gain where the identification's filter has it; 10 ms without one."""
    cutoff = case.recording.filter_cutoff_Hz
    return 0.010 if cutoff is None else round(_HALF_GAIN / cutoff, 6)


def c_sources(result: Result, name: str, frame: FrameName = "sensor") -> tuple[str, str]:
    """Header and source in C99 of a model called `name`, whose wrench is about and along a frame."""
    declarations, definitions = c_parts(result, name, "", in_frame(result, frame))
    return (
        rendered("header.h.jinja", result, name, declarations=declarations),
        rendered("source.c.jinja", result, name, definitions=definitions),
    )


def c_parts(result: Result, name: str, linkage: str, seen: "Seen") -> tuple[str, str]:
    """Declarations and definitions without their files; `linkage` is empty or `static `."""
    half = half_window(result.case)
    calls = {ca.OP_SQRT: "sqrt({0})", ca.OP_SIN: "sin({0})", ca.OP_COS: "cos({0})", ca.OP_ATAN2: "atan2({0}, {1})"}
    spelling = Spelling(
        INFIX | calls,
        temporary="t{0}",
        first="const double {} = {};",
        assignment="{} = {};",
        structure=f"const {name}_parameters *u",
        member="u->",
        given="const double {0}[{1}]",
        written="double {0}[{1}]",
    )
    values = {
        "linkage": linkage,
        "ring": RING,
        "half_window": number(half),
        "window_meaning": f"half gain at {_HALF_GAIN / half:.3g} Hz",
        **seen.texts,
        "functions": [spelled(f, spelling, result.model.names) for f in functions_of(result, seen.place)],
    }
    return (
        rendered("declarations.c.jinja", result, name, **values),
        rendered("definitions.c.jinja", result, name, **values),
    )


AXES = (("fx", "[N]"), ("fy", "[N]"), ("fz", "[N]"), ("mx", "[N m]"), ("my", "[N m]"), ("mz", "[N m]"))


def linuxcnc_component(result: Result, name: str, frame: FrameName = "sensor") -> str:
    """The text of a component called `name`, whose wrench is about and along a frame."""
    calibration = in_frame(result, frame)
    declarations, definitions = c_parts(result, name, "static ", calibration)
    return rendered(
        "component.comp.jinja",
        result,
        name,
        hal=name.replace("_", "-"),
        wrench=AXES,
        half_window=number(half_window(result.case)),
        degree=number(DEG),
        **calibration.texts,
        declarations=declarations,
        definitions=definitions,
    )


def python_module(result: Result, name: str, frame: FrameName = "sensor") -> str:
    """The text of a Python module called `name`, which needs NumPy alone, whose wrench is about and along a frame."""
    calls = {
        ca.OP_SQRT: "math.sqrt({0})",
        ca.OP_SIN: "math.sin({0})",
        ca.OP_COS: "math.cos({0})",
        ca.OP_ATAN2: "math.atan2({0}, {1})",
    }
    spelling = Spelling(
        INFIX | calls,
        temporary="t{0}",
        first="{} = {}",
        assignment="{} = {}",
        structure="u",
        member="u.",
        given="{0}",
        written="{0}",
    )
    half, calibration = half_window(result.case), in_frame(result, frame)
    return rendered(
        "model.py.jinja",
        result,
        name,
        half_window=number(half),
        window_meaning=f"half gain at {_HALF_GAIN / half:.3g} Hz",
        **calibration.texts,
        functions=[spelled(f, spelling, result.model.names) for f in functions_of(result, calibration.place)],
    )


def structured_text(result: Result, name: str, frame: FrameName = "sensor") -> str:
    """The text of a model called `name`: structure, constants, functions and function block.

    Its wrench is about and along a frame.
    """
    camel = "".join(part.capitalize() for part in name.split("_"))
    calls = {ca.OP_SQRT: "SQRT({0})", ca.OP_SIN: "SIN({0})", ca.OP_COS: "COS({0})"}
    spelling = Spelling(
        INFIX | calls | {ca.OP_ATAN2: f"F_{camel}Atan2({{0}}, {{1}})"},
        temporary="t[{1}]",
        first="{} := {};",
        assignment="{} := {};",
        structure=f"u : ST_{camel}Parameters;",
        member="u.",
        given="{0} : ARRAY[0..{2}] OF LREAL;",
        written="{0} : ARRAY[0..{2}] OF LREAL;",
    )
    calibration = in_frame(result, frame)
    functions = [spelled(f, spelling, result.model.names) for f in functions_of(result, calibration.place)]
    return rendered("model.st.jinja", result, name, Name=camel, functions=functions, **calibration.texts)


def _place(result: Result, frame: FrameName) -> Place:
    place = place_of(result.case_as_told, frame, at_home=False)
    if not place.fixed and result.case.setup == "1a":
        raise HexciteError(
            place=f"case {result.case.name}",
            problem="the frame of the sensors stands, and its case does not say how in {B}",
            remedy="choose frame sensor",
            code=Code.NOT_SUPPORTED,
        )
    return place


class Seen(NamedTuple):
    """The frame of an exported wrench, and what templates say of it: its words, and the uncertainty in it."""

    place: Place
    texts: Mapping[str, Any]


def in_frame(result: Result, frame: FrameName) -> Seen:
    """A frame with its words and the uncertainty of force and moment in it.

    Raises:
        HexciteError: no such frame, or the frame of the sensors stands and {B} is asked for.
        CaseError: the case does not state where it is.
    """
    place = _place(result, frame)
    promise = anywhere(result, place)
    missing = f" Not stated by the case: {', '.join(promise.not_counted)}." if promise.not_counted else ""
    if not result.biases:
        missing = " It counts no tolerances of drawing, gains and alignment."
    if NOISE not in promise.counts:
        missing += " It counts no noise of the channels, which the result does not state: identify the run again."
    largest = f"the largest of {promise.states} states in the motion box" if promise.states > 1 else "at home"
    texts = {
        "about": about(place),
        "expanded": [number(float(f"{v:.4g}")) for v in promise.expanded],
        "shares": [[number(float(f"{v:.4g}")) for v in row] for row in promise.shares],
        "counts": f"It counts {', '.join(promise.counts) or 'nothing'}; {largest}.{missing}",
    }
    return Seen(place, texts)


def about(place: Place) -> str:
    """What a wrench is about and along, in words."""
    if not place.fixed:
        return "about the origin of {P} and along the axes of {B}"
    owner = "{P}" if place.name == "sensor" else place.words
    return f"about the origin of {owner} and along its axes"


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


class Spelling(NamedTuple):
    """Format strings of a language for code."""

    operations: Mapping[int, str]  # each operation of CasADi, of its operands
    temporary: str  # intermediate value, of its number (each is assigned once) and its slot (reused when free)
    first: str  # assignment to it, of its name and an expression
    assignment: str  # the same to an element of an output
    structure: str  # the argument u
    member: str  # what stands before the name of its element
    given: str  # argument that is read, of its name, number of elements and last index
    written: str  # the same of one that is written


def spelled(function: ca.Function, spelling: Spelling, parameters: list[str]) -> dict[str, object]:
    """Name, comment, arguments, statements and number of slots of an SX function with dense inputs and outputs.

    Args:
        parameters: elements of the argument u.
    """
    arguments = [
        spelling.structure if n == "u" else spelling.given.format(n, function.numel_in(k), function.numel_in(k) - 1)
        for k, n in enumerate(function.name_in())
    ]
    arguments += [
        spelling.written.format(n, function.numel_out(k), function.numel_out(k) - 1)
        for k, n in enumerate(function.name_out())
    ]
    return {
        "name": function.name(),
        "comment": f"({', '.join(function.name_in())}) -> {', '.join(function.name_out())}",
        "arguments": arguments,
        "inputs": list(function.name_in()),
        "outputs": [(n, function.numel_out(k)) for k, n in enumerate(function.name_out())],
        "statements": list(_statements(function, spelling, parameters)),
        "slots": function.sz_w(),
    }


def _statements(function: ca.Function, spelling: Spelling, parameters: list[str]) -> Iterator[str]:
    """The statements in order; outputs are stored while inputs are still read: they must not share memory."""
    for k in range(function.n_out()):
        if not function.sparsity_out(k).is_dense():
            raise ValueError(f"{function.name()}: output {function.name_out(k)} is not dense")
    values: dict[int, str] = {}  # present value of each slot of CasADi's work vector
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        read, written = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_CONST:
            literal = number(function.instruction_constant(k))
            values[written[0]] = f"({literal})" if literal.startswith("-") else literal
        elif code == ca.OP_INPUT:
            argument, element = function.name_in(read[0]), read[1]
            is_parameter = argument == "u"
            values[written[0]] = f"{spelling.member}{parameters[element]}" if is_parameter else f"{argument}[{element}]"
        elif code == ca.OP_OUTPUT:
            yield spelling.assignment.format(f"{function.name_out(written[0])}[{written[1]}]", values[read[0]])
        else:
            expression = spelling.operations[code].format(*(values[slot] for slot in read))
            values[written[0]] = spelling.temporary.format(k, written[0])
            yield spelling.first.format(values[written[0]], expression)


def measurement(model: Model, place: Place) -> ca.Function:
    """(pose, twist, twist_rate, u, forces) -> external (6,), residuals (6,): (1) with (10)-(15).

    `external` is the force and moment that act on the platform, about and along the frame [N, N m];
    `residuals` are the sensor forces less those that the model expects without contact [N].
    """
    pose, motion, rate, forces = (ca.SX.sym(name, 6) for name in ("pose", "twist", "twist_rate", "forces"))
    u = ca.SX.sym("u", len(model.parameters))
    residuals = forces - model.expression(pose[:3], rotation(pose[3:]), motion, rate) @ u
    return ca.Function(
        "measurement",
        [pose, motion, rate, u, forces],
        [ca.densify(-_seen(place, rotation(pose[3:]), model.structure_at(pose) @ residuals)), ca.densify(residuals)],
        ["pose", "twist", "twist_rate", "u", "forces"],
        ["external", "residuals"],
        {"cse": True},
    )


def _seen(place: Place, turn: ca.SX, wrench: ca.SX) -> ca.SX:
    """A wrench of {P}, whose axes in {B} are given, about and along a frame."""
    if place.name == "sensor":
        return wrench
    return ca.DM(place.map) @ wrench if place.fixed else ca.vertcat(turn @ wrench[:3], turn @ wrench[3:])


def joint_measurement(model: Model, chain: SerialChain, place: Place) -> ca.Function:
    """(joints, rates, accelerations, u, forces) -> external (6,), residuals (6,), pose (6,), as `measurement`.

    The model takes the chain's rotation itself; only the reported pose has angles, which say little where roll and yaw
    turn about one axis.
    """
    joints, rates, accelerations = (ca.SX.sym(name, chain.count) for name in ("joints", "rates", "accelerations"))
    forces, u = ca.SX.sym("forces", 6), ca.SX.sym("u", len(model.parameters))
    position, turn, motion, rate = chain.frame(joints, rates, accelerations)
    residuals = forces - model.expression(position, turn, motion, rate) @ u
    level = ca.sqrt(turn[2, 1] ** 2 + turn[2, 2] ** 2)
    angles = ca.atan2(turn[2, 1], turn[2, 2]), ca.atan2(-turn[2, 0], level), ca.atan2(turn[1, 0], turn[0, 0])
    pose = ca.vertcat(position, *angles)
    return ca.Function(
        "joint_measurement",
        [joints, rates, accelerations, u, forces],
        [ca.densify(v) for v in (-_seen(place, turn, model.structure_at(pose) @ residuals), residuals, pose)],
        ["joints", "rates", "accelerations", "u", "forces"],
        ["external", "residuals", "pose"],
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


def functions_of(result: Result, place: Place) -> list[ca.Function]:
    """All functions of a model whose wrench is in a frame, with those of the mechanics of a hexapod or a chain."""
    case, model = result.case_as_told, result.model
    mechanics_functions: tuple[ca.Function, ...] = () if case.hexapod is None else mechanics(Hexapod.of(case))
    if case.chain is not None:
        mechanics_functions = (joint_measurement(model, SerialChain.of(case), place),)
    return [measurement(model, place), coordinates(), *mechanics_functions]
