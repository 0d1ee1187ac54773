"""Options of exports, each declared once; nothing heavy is imported, for `hexcite --help` shows them.

Arguments of `hx.export` and `hx.preview`, and options of `hexcite export` and `payload`, are made from what stands
here.
"""

from typing import Annotated

from cases.base.options import Option

_LOADS = "urscript, kuka, rapid, franka, xarm, kinova, fanuc (to type in), table (others)"
_LINKS = "urdf, mjcf, sdf"

ExportTarget = Annotated[
    str,
    Option(
        "The model: c (C99), linuxcnc (HAL component), st (IEC 61131-3), python, json. The load for a robot: "
        f"{_LOADS}. For ROS 2: ros2, ft-tools. As a link: {_LINKS}.",
        flag="to",
    ),
]
PayloadTarget = Annotated[
    str | None, Option(f"Write the payload for a robot ({_LOADS}) or as a link ({_LINKS}).", flag="to")
]
ExportFrame = Annotated[
    str | None,
    Option(
        "Count the load, or the wrench of c, linuxcnc, st and python, from the sensor (default), the robot's flange "
        "(default of table), its tool (TCP), or along the axes of the base; also of urdf, mjcf, sdf."
    ),
]
DespiteWarnings = Annotated[
    bool, Option("Export what has warnings; they are written into the file.", False, flag="force")
]
