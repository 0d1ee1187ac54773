"""The measurement model as IEC 61131-3 Structured Text, for TwinCAT and other soft PLCs."""

import casadi as ca

from postprocessors.export.calibration import Calibration, comment_lines, environment, shared_values
from postprocessors.export.instructions import INFIX, CodeLanguage, functions_of, number, operand, signature, statements


def structured_text(calibration: Calibration, name: str) -> str:
    """The text of a model called `name`: structure, constants, functions and function block."""
    machine = calibration.case.hexapod
    camel = "".join(part.capitalize() for part in name.split("_"))
    return (
        environment()
        .get_template("model.st.jinja")
        .render(
            name=name,
            Name=camel,
            origin=comment_lines(calibration),
            home=["0.0"] * 6 if machine is None else [number(v) for v in machine.home.vector],
            force_units="N, N m" if calibration.case.sensor_frame.has_moments else "N",
            functions=[
                _function(f, camel, calibration.model.names)
                for f in functions_of(calibration.model, calibration.hexapod)
            ],
            **shared_values(calibration),
        )
    )


def _function(function: ca.Function, camel: str, parameters: list[str]) -> dict[str, object]:
    def element(argument: str, k: int) -> str:
        return f"u.{parameters[k]}" if argument == "u" else f"{argument}[{k}]"

    operations = INFIX | {
        "sqrt": "SQRT({0})",
        "sin": "SIN({0})",
        "cos": "COS({0})",
        "atan2": f"F_{camel}Atan2({{0}}, {{1}})",
    }
    language = CodeLanguage(operations, lambda _, slot: f"t[{slot}]", "{} := {};", "{} := {};", element, operand)
    arguments = [
        f"u : ST_{camel}Parameters;" if n == "u" else f"{n} : ARRAY[0..{function.numel_in(k) - 1}] OF LREAL;"
        for k, n in enumerate(function.name_in())
    ]
    arguments += [f"{n} : ARRAY[0..{function.numel_out(k) - 1}] OF LREAL;" for k, n in enumerate(function.name_out())]
    return {
        "name": function.name(),
        "comment": signature(function),
        "arguments": arguments,
        "slots": function.sz_w(),
        "statements": statements(function, language),
    }
