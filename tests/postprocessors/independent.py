"""A judgement of timed poses that needs no curve through them: the mean value theorem.

A motion that passes k + 1 poses at their times has, somewhere between them, a k-th derivative of k! times their divided
difference. If that passes a limit, so does every motion through them, whatever the controller does in between.
"""

import re
from math import factorial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case

Array = NDArray[np.float64]
_WORDS = re.compile(r"([XYZABCF])(-?[\d.]+)")


def timed_lines(text: str) -> dict[int, tuple[float, Array]]:
    """Line number -> duration [s] and pose in mm and degrees of each timed line; the lines name all six axes."""
    found, inverse_time = {}, False
    for number, line in enumerate(text.splitlines(), start=1):
        inverse_time = (inverse_time or line == "G93") and line != "G94"
        words = dict(_WORDS.findall(line)) if inverse_time and line.startswith("G1 ") else {}
        if words:
            found[number] = (60 / float(words["F"]), np.array([float(words[c]) for c in "XYZABC"]))
    return found


def points(lines: dict[int, tuple[float, Array]], start: Array) -> tuple[Array, Array]:
    """Times and poses [s, m, rad] of timed lines that follow each other, from a start in mm and degrees."""
    times = np.r_[0.0, np.cumsum([seconds for seconds, _ in lines.values()])]
    poses = np.vstack([start, *(pose for _, pose in lines.values())])
    return times, np.hstack([poses[:, :3] / 1000, np.radians(poses[:, 3:])])


def strut_lengths(poses: Array, case: Case) -> Array:
    """From the definition, shape (n, 6) [m]."""
    turns = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    joints = poses[:, None, :3] + np.einsum("nij,kj->nki", turns, case.machine.platform.points)
    return np.linalg.norm(joints - case.machine.base.points, axis=2)


def derivatives_reached(times: Array, values: Array, order: int) -> Array:
    """K! times the divided differences of order k, shape (n - k, ..)."""
    difference = values
    for k in range(1, order + 1):
        difference = np.diff(difference, axis=0) / (times[k:] - times[:-k])[:, None]
    return factorial(order) * difference


def share_of_limits(times: Array, poses: Array, case: Case) -> float:
    """The largest share of a limit that every motion through the poses uses; above 1 none keeps them all."""
    box, home = case.limits.motion, case.machine.home.vector
    low, high = box.coordinates
    shares = [np.abs(poses - home - (low + high) / 2) / ((high - low) / 2)]
    for order, limit in enumerate((box.rate, box.acceleration, box.jerk), start=1):
        shares.append(np.abs(derivatives_reached(times, poses, order)) / limit)
    lengths = strut_lengths(poses, case)
    short, long = box.strut_length
    shares.append(np.abs(lengths - (short + long) / 2) / ((long - short) / 2))
    for order, most in enumerate((box.strut_velocity_m_s, box.strut_acceleration_m_s2), start=1):
        shares.append(np.abs(derivatives_reached(times, lengths, order)) / most)
    return max(float(s.max()) for s in shares)
