"""The measurement model as C99: a header that people read and a source whose mathematics CasADi's expressions give."""

import casadi as ca

from cases.schema import Case
from cases.units import DEG
from postprocessors.export.calibration import Calibration, comment_lines, environment, shared_values
from postprocessors.export.instructions import INFIX, CodeLanguage, functions_of, number, operand, signature, statements

RING = 256
"""Cycles that the signal chain remembers: 40 ms of delay and as much window at 4 kHz."""

_MATH = {"sqrt": "sqrt({0})", "sin": "sin({0})", "cos": "cos({0})", "atan2": "atan2({0}, {1})"}


_HALF_GAIN = 0.443  # cut-off times half window: a triangle of half width T has the gain sinc(f T)^2, 1/2 at f T = 0.443


def half_window(case: Case) -> float:
    """Half width [s] of the triangle with half the gain where the identification's filter has it; 10 ms without one."""
    cutoff = case.recording.filter_cutoff_Hz
    return 0.010 if cutoff is None else round(_HALF_GAIN / cutoff, 6)


def c_sources(calibration: Calibration, name: str) -> tuple[str, str]:
    """Header and source in C99 of a model called `name`."""
    values = {"name": name, "NAME": name.upper(), "origin": comment_lines(calibration)}
    declarations, definitions = c_parts(calibration, name, "")
    return (
        environment().get_template("header.h.jinja").render(values | {"declarations": declarations}),
        environment().get_template("source.c.jinja").render(values | {"definitions": definitions}),
    )


def c_parts(calibration: Calibration, name: str, linkage: str) -> tuple[str, str]:
    """Declarations and definitions without their files; `linkage` is empty or `static `."""
    machine = calibration.case.hexapod
    half = half_window(calibration.case)
    values = shared_values(calibration) | {
        "name": name,
        "NAME": name.upper(),
        "linkage": linkage,
        "ring": RING,
        "delay": number(calibration.result.delay),
        "half_window": number(half),
        "window_meaning": f"half gain at {_HALF_GAIN / half:.3g} Hz",
        "force_units": "[N, N m]" if calibration.case.sensor_frame.has_moments else "[N]",
        "home": [] if machine is None else [number(v) for v in machine.home.vector],
        "functions": [
            _function(f, name, calibration.model.names) for f in functions_of(calibration.model, calibration.hexapod)
        ],
    }
    return (
        environment().get_template("declarations.c.jinja").render(values),
        environment().get_template("definitions.c.jinja").render(values),
    )


def _function(function: ca.Function, name: str, parameters: list[str]) -> dict[str, object]:
    def element(argument: str, k: int) -> str:
        return f"u->{parameters[k]}" if argument == "u" else f"{argument}[{k}]"

    language = CodeLanguage(INFIX | _MATH, lambda k, _: f"t{k}", "const double {} = {};", "{} = {};", element, operand)
    arguments = [
        f"const {name}_parameters *u" if n == "u" else f"const double {n}[{function.numel_in(k)}]"
        for k, n in enumerate(function.name_in())
    ]
    arguments += [f"double {n}[{function.numel_out(k)}]" for k, n in enumerate(function.name_out())]
    return {
        "name": function.name(),
        "comment": signature(function),
        "arguments": ", ".join(arguments),
        "statements": statements(function, language),
    }


AXES = (("fx", "[N]"), ("fy", "[N]"), ("fz", "[N]"), ("mx", "[N m]"), ("my", "[N m]"), ("mz", "[N m]"))


def linuxcnc_component(calibration: Calibration, name: str) -> str:
    """The text of a component called `name`."""
    declarations, definitions = c_parts(calibration, name, "static ")
    return (
        environment()
        .get_template("component.comp.jinja")
        .render(
            name=name,
            NAME=name.upper(),
            hal=name.replace("_", "-"),
            origin=comment_lines(calibration),
            hexapod=calibration.hexapod is not None,
            force_units="[N, N m]" if calibration.case.sensor_frame.has_moments else "[N]",
            wrench=AXES,
            half_window=number(half_window(calibration.case)),
            delay=number(calibration.result.delay),
            degree=number(DEG),
            offsets=[n for n in calibration.model.names if n.startswith("f_q0_")],
            declarations=declarations,
            definitions=definitions,
        )
    )
