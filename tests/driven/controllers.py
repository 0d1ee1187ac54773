"""What a robot's controller makes of a program: URScript and joint trajectories, as their makers describe them.

Nothing here is taken from what writes the programs. `movej` is a trapezoid of the joint that moves most, the others in
proportion (script manual of Universal Robots); `joint_trajectory_controller` joins points that state positions,
velocities and accelerations by polynomials of degree five.
"""

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

Array = NDArray[np.float64]
Setpoints = Callable[[float], tuple[Array, Array]]
NUMBER = r"[-+0-9.eE]+"


class Run:
    """Set points of a program, how long it runs [s], and when it switched its output on and off [s]."""

    def __init__(self, at: Setpoints, duration: float, switched: tuple[float, ...] = ()) -> None:
        self.at, self.duration, self.switched = at, duration, switched


def urscript(text: str, standing: Array, output: int) -> Run:
    """Runs a program on a robot that stands somewhere [rad]; RuntimeError where the program halts it.

    The run knows when one of the standard digital outputs was switched.
    """
    now, place = 0.0, np.array(standing, dtype=float)
    pieces: list[tuple[float, float, Array, Array, float, float]] = []
    switched: list[float] = []
    lines = text.splitlines()
    if not (lines[0].startswith("def ") and lines[-1] == "end" and all(line[:1] == " " for line in lines[1:-1])):
        raise RuntimeError("a program begins with def and ends with end, in the first column")
    variables: dict[str, Array] = {}
    skip = False
    for line in (line.strip() for line in lines[1:-1]):
        if line.startswith("#") or not line:
            continue
        if skip:  # in a branch that is not taken
            skip = line != "end"
        elif line.endswith("= get_actual_joint_positions()"):
            variables[line.split(" ")[0]] = place.copy()
        elif found := re.fullmatch(rf"if norm\((\w+)\[(\d)\]({NUMBER})\) > ({NUMBER}):", line):
            skip = not abs(variables[found[1]][int(found[2])] + float(found[3])) > float(found[4])
        elif line.startswith("popup("):
            continue
        elif line == "halt":
            raise RuntimeError("the program halts the robot")
        elif found := re.fullmatch(rf"sleep\(({NUMBER})\)", line):
            now += float(found[1])
        elif found := re.fullmatch(rf"set_standard_digital_out\({output}, (True|False)\)", line):
            switched += [now] if (found[1] == "True") == (len(switched) % 2 == 0) else []
        elif found := re.fullmatch(rf"movej\(\[([^\]]+)\], a=({NUMBER}), v=({NUMBER}), r=0\)", line):
            end = np.array([float(v) for v in found[1].split(",")])
            way, a, v = float(np.abs(end - place).max()), float(found[2]), float(found[3])
            if way > 0.0:
                ramp = min(v / a, (way / a) ** 0.5)
                top = a * ramp
                duration = ramp + way / top
                pieces.append((now, duration, place, end - place, ramp, top / way))
                now, place = now + duration, end
        elif line != "end":
            raise RuntimeError(f"no statement of URScript: {line}")
    starts = np.array([piece[0] for piece in pieces])

    def at(t: float) -> tuple[Array, Array]:
        k = int(np.searchsorted(starts, t, side="right")) - 1
        if k < 0:
            return pieces[0][2], 0.0 * standing
        start, duration, begin, way, ramp, top = pieces[k]
        s = min(t - start, duration)
        if s < ramp:
            share, speed = top * s * s / (2 * ramp), top * s / ramp
        elif s <= duration - ramp:
            share, speed = top * (s - ramp / 2), top
        else:
            left = duration - s
            share, speed = 1.0 - top * left * left / (2 * ramp), top * left / ramp
        return begin + share * way, speed * way

    return Run(at, now, tuple(switched))


def joint_trajectory(message: str | dict[str, Any], names: tuple[str, ...], standing: Array) -> Run:
    """Runs a JointTrajectory, as YAML or as values, on a robot that stands somewhere [rad]."""
    told: dict[str, Any] = yaml.safe_load(message) if isinstance(message, str) else message
    order = [told["joint_names"].index(name) for name in names]
    rows = [[np.array(p[key])[order] for key in ("positions", "velocities", "accelerations")] for p in told["points"]]
    times = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in told["points"]]
    if times[0] > 0.0:
        rows.insert(0, [np.array(standing, dtype=float), 0.0 * standing, 0.0 * standing])
        times.insert(0, 0.0)
    if np.any(np.diff(times) <= 0.0) or np.any(rows[-1][1] != 0.0):
        raise RuntimeError("times do not increase, or the last point moves")
    coefficients = [
        _quintic((*a, *b), end - begin) for a, b, begin, end in zip(rows, rows[1:], times, times[1:], strict=False)
    ]
    starts, powers = np.array(times), np.arange(6)

    def at(t: float) -> tuple[Array, Array]:
        k = min(max(int(np.searchsorted(starts, t, side="right")) - 1, 0), len(coefficients) - 1)
        s = min(t, times[-1]) - times[k]
        of, steps = coefficients[k], s**powers
        return steps @ of, (powers[1:] * steps[:-1]) @ of[1:]

    return Run(at, times[-1])


def _quintic(ends: Sequence[Array], t: float) -> Array:
    """Coefficients, shape (6, n), of the polynomial between two states that are t apart."""
    p, v, a, q, w, b = ends
    rest = np.array([q - p - v * t - a * t**2 / 2, w - v - a * t, b - a])
    matrix = np.array([[t**3, t**4, t**5], [3 * t**2, 4 * t**3, 5 * t**4], [6 * t, 12 * t**2, 20 * t**3]])
    return np.vstack([p, v, a / 2, np.linalg.solve(matrix, rest)])
