"""The identified body as the payload of a robot of Universal Robots: `set_target_payload`.

Script manual: mass, centre of gravity from the tool flange in metres, inertia about the centre of gravity along the
flange's axes, in the order Ixx, Iyy, Izz, Ixy, Ixz, Iyz. The command zeroes the robot's own force sensor.
"""

from collections.abc import Iterable

from cases.errors import IdentificationError
from postprocessors.export.calibration import Calibration, comment_lines
from postprocessors.export.isg import identified_load

LARGEST = 133.0  # [kg m^2] of an element of the inertia


def urscript_payload(calibration: Calibration) -> str:
    """A URScript program that sets the identified body as payload.

    Raises:
        IdentificationError: a static model, which has no inertia, or a body that is none or too large.
    """
    body = identified_load(calibration, "set_target_payload")
    elements = [body.inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    if max(map(abs, elements)) > LARGEST:
        raise IdentificationError(
            f"{calibration.result.source}: an inertia of {max(map(abs, elements)):.4g} kg m^2 is above what a robot "
            f"takes ({LARGEST:g}); is this the load of a robot?"
        )
    lines = [
        *(f"# {line}" for line in comment_lines(calibration)),
        "# payload: everything that the force sensor carries; add what is between flange and sensor, and the sensor",
        "# tool flange = sensor frame {P} of the case; m from it, kg m^2 about the centre of gravity",
        f"set_target_payload({body.mass:.4f}, {_list(body.centre, 5)}, {_list(elements, 6)})",
    ]
    return "def payload():\n" + "".join(f"  {line}\n" for line in lines) + "end\n"


def _list(values: Iterable[float], decimals: int) -> str:
    return f"[{', '.join(f'{float(v) + 0.0:.{decimals}f}' for v in values)}]"
