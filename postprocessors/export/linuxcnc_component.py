"""The measurement model as a HAL component for LinuxCNC, in one file that `halcompile` compiles and installs."""

from cases.units import DEG
from postprocessors.export.c99 import c_parts, window_of
from postprocessors.export.calibration import Calibration
from postprocessors.export.instructions import number
from postprocessors.export.rendering import comment_lines, environment

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
            half_window=number(window_of(calibration.case).half),
            delay=number(calibration.result.delay),
            degree=number(DEG),
            offsets=[n for n in calibration.model.names if n.startswith("f_q0_")],
            declarations=declarations,
            definitions=definitions,
        )
    )
