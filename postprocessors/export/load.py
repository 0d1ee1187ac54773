"""The rigid body that the force sensors carry, in the frame in which a robot or a simulator counts it."""

from collections.abc import Mapping
from itertools import permutations
from typing import NamedTuple

import numpy as np

from cases.base.errors import CaseError, Code, IdentificationError, option
from cases.base.units import DEG, MM, Array
from cases.schema import Case
from identification.model.blocks import INERTIA
from identification.model.model import Model
from identification.options import FrameName
from identification.results.frames import place_of
from identification.results.payload import Payload
from identification.results.result import Result

Carried = Result | Payload
"""What carries a load: a result, whose load is all that the sensors carry, or what was added between two."""


class Load(NamedTuple):
    """A rigid body in a frame: everything that the force sensors carry.

    Args:
        mass: [kg].
        centre: centre of gravity, shape (3,) [m].
        inertia: about the centre of gravity along the frame's axes, shape (3, 3) [kg m^2]; None of a standing run,
            which does not determine it.
        frame_from_sensor: axes and origin of {P} in the frame, shape (4, 4) [-, m].
    """

    mass: float
    centre: Array
    inertia: Array | None
    frame_from_sensor: Array


def load_of(result: Carried, frame_from_sensor: Array) -> Load:
    """The load in a frame: the nearest body that can exist, where the estimate cannot.

    Args:
        frame_from_sensor: axes and origin of {P} in it, shape (4, 4) [-, m].

    Raises:
        IdentificationError: no body can be it, or sensors in struts at the drive, whose body is the platform with the
            rods.
    """
    if isinstance(result, Result) and _carries_rods(result.model):
        problem = "its body is the platform with the rods of the struts, no load alone"
        raise IdentificationError(
            place=result.source,
            problem=problem,
            remedy=f"export {option('target', 'to')} c, linuxcnc, st or json",
            code=Code.NOT_SUPPORTED,
        )
    rotation, value = frame_from_sensor[:3, :3], possible(result)
    centre = rotation @ [value["xC"], value["yC"], value["zC"]] + frame_from_sensor[:3, 3]
    if not (has_inertia(result.model) if isinstance(result, Result) else INERTIA in result.whole_body.model.blocks):
        return Load(value["m"], centre, None, frame_from_sensor)
    xx, xy, xz, yy, yz, zz = (value[f"IC{k}"] for k in ("11", "12", "13", "22", "23", "33"))
    inertia = rotation @ [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] @ rotation.T
    return Load(value["m"], centre, inertia, frame_from_sensor)


def possible(result: Carried) -> Mapping[str, float]:
    """Parameters of the nearest body that can exist, by name [SI].

    Raises:
        IdentificationError: there is none.
    """
    if (nearest := result.physical) is None:
        problem = "no body that can exist has what was given beforehand and keeps [bounds] of the case"
        raise IdentificationError(
            place=result.source, problem=problem, remedy="correct them and identify again", code=Code.MISFIT
        )
    return nearest.parameters


def has_inertia(model: Model) -> bool:
    """Whether a model has the inertia of the load alone."""
    return INERTIA in model.blocks and not _carries_rods(model)


def _carries_rods(model: Model) -> bool:
    """Whether the body of a model is the platform with the rods of its struts, which cancel in a payload."""
    return model.struts is not None and model.struts.sensors.at == "drive"


def carried_words(result: Carried) -> str:
    """What a load is, and what has to be added to it."""
    if isinstance(result, Payload):
        return "what was added between the two results; what the machine carried before is not in it"
    return "everything that the force sensor carries; add what is between flange and sensor, and the sensor"


def load_at_flange(result: Carried) -> Load:
    """The load in the frame of the robot's flange; raises CaseError where the case does not say where that is."""
    return load_of(result, result.case_as_told.need_flange("a payload"))


def load_in(result: Carried, frame: FrameName) -> Load:
    """The load in a frame; raises CaseError where the case does not state where that is."""
    return load_of(result, place_of(result.case_as_told, frame).frame_from_sensor)


def require_inertia(load: Load, result: Carried, receiver: str) -> Array:
    """The inertia; raises IdentificationError where the model has none."""
    if load.inertia is None:
        problem = f"{receiver} needs an inertia, which models 6 to 10 of a moving run determine"
        raise IdentificationError(
            place=result.source, problem=problem, remedy="identify from a moving run", code=Code.NO_EXCITATION
        )
    return load.inertia


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Principal inertias and their axes, in the order and with the signs that turn the axes least.

    Args:
        inertia: symmetric, shape (3, 3).

    Returns:
        Moments, shape (3,), and a rotation matrix whose columns are the axes, shape (3, 3):
        inertia = axes diag(moments) axes^T.
    """
    moments, vectors = np.linalg.eigh(inertia)
    order = list(max(permutations(range(3)), key=lambda columns: float(np.abs(vectors[:, list(columns)]).trace())))
    moments, vectors = moments[order], vectors[:, order]
    vectors = vectors * np.where(vectors.diagonal() < 0.0, -1.0, 1.0)
    if np.linalg.det(vectors) < 0.0:
        least = int(np.argmin(vectors.diagonal()))
        vectors[:, least] *= -1.0
    return moments, vectors


def deviations_words(result: Carried, frame: FrameName) -> str:
    """Reported deviations of mass and centre of gravity, along the axes of a frame."""
    body = result.in_frame(frame)
    m, *centre = (body.parameters[name].reported for name in ("m", "xC", "yC", "zC"))
    values = ", ".join(f"{v / MM:.2g}" for v in centre)
    axes = f"the axes of {body.place.words}" if body.place.fixed else body.place.words
    words = f"deviations: mass {m:.2g} kg, centre of gravity {values} mm along {axes}"
    nearest = result.physical
    if nearest is None or not nearest.moved:
        return words
    return f"{words}; it is the nearest body that can exist, {nearest.distance:.2g} deviations from the estimate"


def place_words(place: Array) -> str:
    """Origin and angles of a frame, shape (4, 4)."""
    r = place[:3, :3]
    roll, yaw = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    pitch = np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0]))
    origin, angles = (
        ", ".join(f"{round(float(v), 2) + 0.0:.2f}" for v in values)
        for values in (place[:3, 3] / MM, np.array([roll, pitch, yaw]) / DEG)
    )
    return f"{origin} mm, turned by {angles} deg (roll, pitch, yaw)"


def numbers(values: Array, decimals: int) -> str:
    """Values with commas between them, without a negative zero."""
    return ", ".join(f"{round(float(v), decimals) + 0.0:.{decimals}f}" for v in values)


def require_transducer(case: Case, receiver: str) -> str:
    """Which force the channels count: "load_on_sensor" or "sensor_on_load".

    Raises:
        CaseError: the machine has no six-axis force/torque sensor.
    """
    transducer = case.sensor_frame.transducer
    if transducer is None:
        problem = f"is that of no robot: {receiver} is for setup R, a force/torque sensor at a flange"
        raise CaseError(
            file=f"case {case.name}",
            key="setup",
            problem=problem,
            remedy=f"export {option('target', 'to')} c, linuxcnc, st or json",
            code=Code.NOT_SUPPORTED,
        )
    return "load_on_sensor" if transducer.sign < 0.0 else "sensor_on_load"
