"""The mathematics that every controller needs, as the CasADi functions that identification uses too.

All matrices leave a function column by column. `u` are the linear parameters (17) in the order of the model.
"""

from typing import NamedTuple

import casadi as ca

from identification.hexapod import Hexapod
from identification.model import Model
from identification.pose import rotation, twist, twist_rate


class Mechanics(NamedTuple):
    """What turns strut motion into platform motion.

    Args:
        struts: pose -> lengths (6,), jacobian (6, 6): J_Hex^-1 of (8).
        newton: pose, correction (6,) -> stepped (6,): the pose after a step of the forward kinematics (7).
        drift: pose, twist -> drift (6,): d/dt(J_Hex^-1) twist of (9).
    """

    struts: ca.Function
    newton: ca.Function
    drift: ca.Function


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
        [ca.densify(-model.structure_at(pose[:3], rotation(pose[3:])) @ residuals), ca.densify(residuals)],
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


def mechanics(hexapod: Hexapod) -> Mechanics:
    """The kinematics of a hexapod, its joints built in."""
    pose, motion, step = (ca.SX.sym(name, 6) for name in ("pose", "twist", "correction"))
    lengths, jacobian = hexapod.inverse_jacobian(pose)
    struts = ca.Function(
        "struts", [pose], [lengths, ca.densify(jacobian)], ["pose"], ["lengths", "jacobian"], {"cse": True}
    )
    newton = ca.Function("newton", [pose, step], [hexapod.newton_step(pose, step)], ["pose", "correction"], ["stepped"])
    drift = ca.Function(
        "drift", [pose, motion], [hexapod.jacobian_drift(pose, motion)], ["pose", "twist"], ["drift"], {"cse": True}
    )
    return Mechanics(struts, newton, drift)


def functions_of(model: Model, hexapod: Hexapod | None) -> list[ca.Function]:
    """All functions of a model; those of the mechanics where there is a hexapod."""
    return [measurement(model), coordinates(), *(() if hexapod is None else mechanics(hexapod))]


def signature(function: ca.Function) -> str:
    """Names of what goes in and comes out, for comments."""
    return f"({', '.join(function.name_in())}) -> {', '.join(function.name_out())}"
