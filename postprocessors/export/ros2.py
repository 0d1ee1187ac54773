"""Parameters for ROS 2: what takes offsets and weight off the readings of a force/torque sensor."""

import numpy as np

from cases.base.errors import CaseError, Code
from identification.results.result import Result
from postprocessors.export.calibration import comment_lines
from postprocessors.export.load import Load, deviations_words, load_in, numbers, possible, require_transducer

AXES = ("x", "y", "z")
BASE, SENSOR = "BASE_FRAME", "SENSOR_FRAME"


def broadcaster(result: Result, name: str) -> str:
    """Parameters of force_torque_sensor_broadcaster with the gravity compensation of control_toolbox behind it.

    The broadcaster adds its offsets to the reading, multiplies, and hands it to the filter, which takes off the weight
    of the tool: mass in kg, centre of gravity in the sensor's frame [m], gravity in the world's frame [m/s^2].
    """
    sense = require_transducer(result.case, "force_torque_sensor_broadcaster")
    load, offsets = load_in(result, "sensor"), -_offsets(result)
    sign = 1.0 if sense == "load_on_sensor" else -1.0
    lines = [
        "force_torque_sensor_broadcaster:",
        "  ros__parameters:",
        f"    frame_id: {SENSOR}",
        *_channels("offset", offsets),
        *(_channels("multiplier", np.full(6, sign)) if sign < 0.0 else ()),
        "    sensor_filter_chain:",
        "      filter1:",
        "        name: gravity_compensation",
        "        type: control_filters/GravityCompensationWrench",
        "        params:",
        f"          world_frame: {BASE}",
        f"          sensor_frame: {SENSOR}",
        "          tool:",
        f"            mass: {load.mass:.5f}",
        f"            pos: [{numbers(load.centre, 6)}]",
        f"            gravity_field: [{numbers(result.case.gravity, 6)}]",
    ]
    frames = f"{BASE}: the frame {{B}} of the case, in which gravity is stated; {SENSOR}: that of the readings"
    multiplied = [] if sign > 0.0 else ["multiplier turns readings of the sensor on the load round; offsets come first"]
    return _yaml(result, [f"put in the names of your frames. {frames}", *multiplied], lines)


def ft_tools(result: Result, name: str) -> str:
    """The calibration file of ft_tools: mass [kg], centre of gravity in the sensor's frame [m], offsets [N, N m].

    Raises:
        CaseError: positive readings are those of the sensor on the load, which ft_tools does not know.
    """
    if require_transducer(result.case, "ft_tools") != "load_on_sensor":
        raise CaseError(
            file=f"case {result.case.name}",
            key="sensor_frame.transducer.sense",
            problem="is sensor_on_load; ft_tools takes readings of the load on the sensor",
            remedy="turn them round in the driver, and state load_on_sensor",
            code=Code.NOT_SUPPORTED,
        )
    load: Load = load_in(result, "sensor")
    offsets = _offsets(result)
    lines = [
        f"mass: {load.mass:.5f}",
        f"sensor_frame_to_com: [{numbers(load.centre, 6)}]",
        f"force_offset: [{numbers(offsets[:3], 5)}]",
        f"torque_offset: [{numbers(offsets[3:], 6)}]",
    ]
    return _yaml(result, [], lines)


def _offsets(result: Result) -> np.ndarray:
    """What the six channels read without a load, shape (6,) [N, N m]."""
    value = possible(result)
    return np.array([value[f"f_q0_{k}"] for k in range(1, 7)])


def _channels(key: str, values: np.ndarray) -> list[str]:
    """Six values under a key, as the broadcaster nests them."""
    rows = [f"    {key}:"]
    for kind, values_of_kind in (("force", values[:3]), ("torque", values[3:])):
        rows.append(f"      {kind}:")
        rows.extend(f"        {axis}: {v + 0.0:.6f}" for axis, v in zip(AXES, values_of_kind, strict=True))
    return rows


def _yaml(result: Result, remarks: list[str], lines: list[str]) -> str:
    comments = [*comment_lines(result), deviations_words(result, "sensor"), *remarks]
    return "".join(f"# {line}\n" for line in comments) + "".join(f"{line}\n" for line in lines)
