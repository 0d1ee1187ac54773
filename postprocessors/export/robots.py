"""The load as payload of a robot, in the words of its controller: frame, order, axes and units differ from maker to
maker.

All of them count from the robot's flange, and the load is everything that the force sensors carry: what is between
flange and sensor, and the sensor, come on top.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from cases.base.errors import Code, IdentificationError
from cases.base.units import MM
from identification.options import FrameName
from identification.results.frames import place_of
from identification.results.payload import Payload
from postprocessors.export.calibration import comment_lines
from postprocessors.export.load import (
    Carried,
    Load,
    carried_words,
    deviations_words,
    load_at_flange,
    load_in,
    numbers,
    place_words,
    principal_axes,
    require_inertia,
)

LARGEST = 133.0  # [kg m^2] largest element of the inertia in set_target_payload
KGF_CM_S2 = 9.80665 * 0.01  # [kg m^2] FANUC's unit of inertia
CM = 0.01  # [m]
PYTHON = "# -*- coding: ascii -*-\n"  # first line of a module: words of a remark in the second could be read as another
POINT = "the run did not determine the inertia: the load counts as a point mass"


def _remarks(result: Carried, load: Load, frame: FrameName = "flange") -> list[str]:
    """Where the values are from, what they count, and how sure they are: lines for people."""
    words = place_of(result.case_as_told, frame).words
    where = f"counted from {words}, along its axes" if frame != "base" else f"counted along {words}"
    return [
        *comment_lines(result),
        f"payload: {carried_words(result)}",
        f"{where}: the case's sensor frame lies in it at {place_words(load.frame_from_sensor)}",
        deviations_words(result, frame),
        *([] if load.inertia is not None else [POINT]),
    ]


def urscript(result: Carried, name: str) -> str:
    """A URScript program that sets the load as payload of the robot.

    Script manual: mass, centre of gravity from the tool flange in metres, inertia about the centre of gravity along the
    flange's axes, in the order Ixx, Iyy, Izz, Ixy, Ixz, Iyz. The command zeroes the robot's own force sensor.

    Raises:
        CaseError: the case does not say where the flange is.
        IdentificationError: an inertia that no body has or no robot takes, or none.
    """
    load = load_at_flange(result)
    inertia = require_inertia(load, result, "set_target_payload")
    if inertia.diagonal().max() > LARGEST:
        problem = f"an inertia of {inertia.diagonal().max():.4g} kg m^2, at most {LARGEST:g} is taken by the robot"
        raise IdentificationError(
            place=result.source,
            problem=problem,
            remedy="identify from a run that turns the machine more",
            code=Code.NO_EXCITATION,
        )
    elements = numbers(np.array([*inertia.diagonal(), inertia[0, 1], inertia[0, 2], inertia[1, 2]]), 6)
    lines = [
        *(f"# {line}" for line in _remarks(result, load)),
        "# kg, m from the flange, kg m^2 about the centre of gravity",
        f"set_target_payload({load.mass:.4f}, [{numbers(load.centre, 5)}], [{elements}])",
    ]
    return "def payload():\n" + "".join(f"  {line}\n" for line in lines) + "end\n"


def kuka(result: Carried, name: str) -> str:
    """Load data of a KUKA robot, for $config.dat or a program.

    KRL: mass in kg, centre of gravity in mm from the flange; A, B, C turn the flange's axes about z, y, x in degrees to
    the principal axes of inertia; J are the moments of inertia about these [kg m^2].
    """
    load = load_at_flange(result)
    moments, axes = (np.zeros(3), np.eye(3)) if load.inertia is None else principal_axes(load.inertia)
    x, y, z = (numbers(np.array([v]), 3) for v in load.centre / MM)
    a, b, c = (numbers(np.array([v]), 4) for v in Rotation.from_matrix(axes).as_euler("ZYX", degrees=True))
    jx, jy, jz = (numbers(np.array([v]), 7) for v in moments)
    centre = f"CM {{X {x},Y {y},Z {z},A {a},B {b},C {c}}}"
    return _commented(
        ";",
        [*_remarks(result, load), "of tool 1: change the number to that of your tool"],
        f"LOAD_DATA[1]={{M {load.mass:.4f},{centre},J {{X {jx},Y {jy},Z {jz}}}}}",
    )


def rapid(result: Carried, name: str) -> str:
    """A RAPID module with the load as `loaddata`, the third part of a `tooldata` (tload).

    RAPID: mass in kg, centre of gravity in mm; the quaternion turns the wrist's axes to the principal axes of inertia,
    and ix, iy, iz are the moments about these [kg m^2], 0 for a point mass. The load of a tool counts from the wrist
    coordinate system, whose origin is the centre of the flange.
    """
    load = load_at_flange(result)
    moments, axes = (np.zeros(3), np.eye(3)) if load.inertia is None else principal_axes(load.inertia)
    w, *vector = Rotation.from_matrix(axes).as_quat(canonical=True, scalar_first=True)
    data = (
        f"[{load.mass:.4f},[{numbers(load.centre / MM, 3)}],[{numbers(np.array([w, *vector]), 8)}],"
        f"{numbers(moments, 7)}]"
    )
    remarks = [
        *_remarks(result, load),
        "use it as tload of a tooldata; a load of GripLoad counts from the tool's frame instead",
    ]
    body = _commented("!", remarks, f"PERS loaddata tool_load:={data};").splitlines()
    return f"MODULE {name}\n" + "".join(f"  {line}\n" for line in body) + "ENDMODULE\n"


def franka(result: Carried, name: str) -> str:
    """A request of franka_msgs/srv/SetLoad, whose entries are the arguments of libfranka's setLoad.

    Mass in kg, centre of mass in metres from the flange, inertia about the centre of mass as a 3 x 3 matrix, column by
    column [kg m^2].
    """
    load = load_at_flange(result)
    inertia = require_inertia(load, result, "setLoad")
    entries = [
        f"mass: {load.mass:.4f}",
        f"center_of_mass: [{numbers(load.centre, 6)}]",
        f"load_inertia: [{numbers(inertia.T.ravel(), 8)}]",
    ]
    return _commented("#", _remarks(result, load), "\n".join(entries))


def xarm(result: Carried, name: str) -> str:
    """A Python function that sets the load of a UFACTORY xArm: kg, and mm from the flange; it takes no inertia."""
    load = load_at_flange(result)
    lines = [
        "def set_payload(arm):",
        '    """Sets the load of an XArmAPI: kg, mm from the flange."""',
        f"    return arm.set_tcp_load(weight={load.mass:.4f}, center_of_gravity=[{numbers(load.centre / MM, 2)}])",
    ]
    return PYTHON + _commented("#", _remarks(result, load), "\n".join(lines))


def kinova(result: Carried, name: str) -> str:
    """A Python function that sets the load of a Kinova Gen3 or Gen3 lite by its Kortex API; it takes no inertia.

    ControlConfig of the API: what the robot always carries is its tool, in kg, and m from the interface module, whose
    frame is the flange's; what was added to it is its payload, in m from the frame of the tool.

    Raises:
        CaseError: the case does not say where the flange is, or the tool, for a payload.
    """
    frame: FrameName = "tool" if isinstance(result, Payload) else "flange"
    load = load_in(result, frame)
    what = "payload" if isinstance(result, Payload) else "tool"
    kind = f"{what.capitalize()}{'Information' if what == 'payload' else 'Configuration'}"
    lines = [
        f"def set_{what}(control_config):",
        f'    """Sets mass and centre of gravity of the {what} by a ControlConfigClient: kg, m; the rest stays."""',
        f"    {what} = control_config.Get{kind}()",
        f"    {what}.{what}_mass = {load.mass:.4f}",
        *(
            f"    {what}.{what}_mass_center.{a} = {numbers(v[None], 6)}"
            for a, v in zip("xyz", load.centre, strict=True)
        ),
        f"    control_config.Set{kind}({what})",
    ]
    return PYTHON + _commented("#", _remarks(result, load, frame), "\n".join(lines))


def fanuc(result: Carried, name: str) -> str:
    """The rows of FANUC's screen PAYLOAD SET, in its order and units, to type in.

    Mass in kg, centre of gravity in cm from the flange along its axes, moments of inertia about the centre of gravity
    along these axes in kgf cm s^2; the screen takes no products of inertia. A point mass has moments of 0.
    """
    load = load_at_flange(result)
    moments = np.zeros(3) if load.inertia is None else load.inertia.diagonal()
    rows = [
        ("PAYLOAD [kg]", f"{load.mass:.3f}"),
        *((f"PAYLOAD CENTER {axis} [cm]", f"{v / CM:.3f}") for axis, v in zip("XYZ", load.centre, strict=True)),
        *(
            (f"PAYLOAD INERTIA {axis} [kgfcms^2]", f"{v / KGF_CM_S2:.5f}")
            for axis, v in zip("XYZ", moments, strict=True)
        ),
    ]
    about = "MENU, SYSTEM, Motion, DETAIL. Compare the units with those on the screen before you type."
    body = "".join(f"{words:<28}  {value:>10}\n" for words, value in rows)
    return "".join(f"{line}\n" for line in [*_remarks(result, load), about]) + f"\n{body}"


def table(result: Carried, name: str, frame: FrameName) -> str:
    """The load in the units of screens where it is typed in."""
    load = load_at_flange(result) if frame == "flange" else load_in(result, frame)
    remarks = "".join(f"{line}\n" for line in _remarks(result, load, frame))
    rows = [("mass [kg]", f"{load.mass:.4f}")]
    for axis, v in zip("XYZ", load.centre, strict=True):
        rows.append((f"centre of gravity {axis} [mm]  [cm]  [m]", f"{v / MM:.3f}  {v / CM:.4f}  {v:.6f}"))
    if load.inertia is not None:
        for axis, v in zip("XYZ", load.inertia.diagonal(), strict=True):
            rows.append((f"inertia I{axis}{axis} [kg m^2]  [kgf cm s^2]", f"{v:.6g}  {v / KGF_CM_S2:.6g}"))
        for a, b in ("XY", "XZ", "YZ"):
            v = load.inertia["XYZ".index(a), "XYZ".index(b)]
            rows.append((f"inertia I{a}{b} [kg m^2]", f"{v:.6g}"))
        moments, axes = principal_axes(load.inertia)
        for k, v in enumerate(moments):
            rows.append((f"principal inertia {k + 1} [kg m^2], axis", f"{v:.6g}  ({numbers(axes[:, k], 5)})"))
    width = max(len(words) for words, _ in rows)
    body = "".join(f"{words:<{width}}  {value}\n" for words, value in rows)
    about = "inertias are about the centre of gravity; Ixy is the element of the tensor, not its negative\n"
    return f"{remarks}\n{body}\n{about}"


def _commented(sign: str, remarks: list[str], text: str) -> str:
    """Remarks as comments of a language, and the text behind them."""
    return "".join(f"{sign} {line}\n" for line in remarks) + text + "\n"
