"""Point-to-point moves under the time law of a jerk-limited controller, in whole cycles, as ruckig computes it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.limited import strut_motion
from identification.limits import PROOF_RATE
from identification.motion import Joined, Standstill, Trajectory, sample
from identification.trajectories.circle import CircularMove
from identification.trajectories.online_profile import OnlineProfile, UntimedMove, online_move, online_profile
from identification.trajectories.profile import Profile, StraightMove
from planner.families.ptp import unit_profile
from planner.search.inside import MARGIN

Array = NDArray[np.float64]

SLOWINGS = 5  # of a move whose struts are too fast
SAME = 1e-4  # of the way, the largest velocity and acceleration: rounding where the limit of jerk is next to none


def by_controller(motion: Trajectory, case: Case) -> tuple[Joined, int]:
    """Every move under the law of a jerk-limited controller with the motion limits of the case, in whole cycles.

    Straight moves become as fast as the limits of their coordinates allow, less the margin of every plan; arcs as fast
    as the peaks of their planned law; either slower where the limits of the struts need it. Pauses are rounded up.
    Also returns how many moves the struts have slowed.

    Raises:
        UntimedMove: the motion is no sequence of moves and pauses.
        CaseError: the case has no machine, limits or controller.
    """
    case.need_machine("re-timing")
    cycle = case.need_controller("re-timing in whole controller cycles").cycle
    if not isinstance(motion, Joined):
        raise UntimedMove("it is one continuous path, no sequence of moves; use --method ipopt")
    parts: list[Trajectory] = []
    slowed = 0
    for part in motion.parts:
        if isinstance(part, Standstill):
            parts.append(Standstill(part.pose, float(np.ceil(part.duration / cycle - 1e-9)) * cycle))
            continue
        if not isinstance(part, StraightMove | CircularMove) or not isinstance(part.profile, Profile):
            raise UntimedMove("it contains a continuous path; use --method ipopt")
        pace, move = 1.0, _timed(part, case, 1.0, cycle)
        for _ in range(SLOWINGS):
            worst = _of_struts(move, case)
            if worst <= 1.0 - MARGIN / 2:
                break
            pace *= (1.0 - MARGIN) / worst
            move = _timed(part, case, pace, cycle)
        slowed += pace < 1.0
        parts.append(move)
    return Joined(tuple(parts)), slowed


def _timed(part: StraightMove | CircularMove, case: Case, pace: float, cycle: float) -> StraightMove | CircularMove:
    """A move under a controller's own law, with its limits at a share of their pace."""
    v, a, j = pace, pace**2, pace**3
    if isinstance(part, StraightMove):
        box, kept = case.need_machine("re-timing")[2].motion, 1.0 - MARGIN
        rate, acceleration, jerk = box.rate * kept * v, box.acceleration * kept * a, box.jerk * kept * j
        law = online_move(part.start, part.end, rate, acceleration, jerk, cycle).profile
        assert isinstance(law, OnlineProfile)
        return replace(part, profile=_seven_segments(law))
    planned = part.profile
    assert isinstance(planned, Profile)
    law = online_profile(planned.peak_velocity * v, planned.acceleration * a, planned.jerk * j, cycle)
    return replace(part, profile=_seven_segments(law))


def _seven_segments(law: OnlineProfile) -> Profile:
    """The same law by its three times; from rest to rest ruckig's phases are those of seven segments."""
    jerk_time = float(law.lengths[0])
    hold_time = float(law.lengths[1]) if law.jerks[1] == 0.0 else 0.0
    found = unit_profile(jerk_time, hold_time, max(0.0, law.duration - 4 * jerk_time - 2 * hold_time))
    t = np.cumsum(law.lengths) - law.lengths / 2  # the middle of each phase
    pairs = zip(found.at(t)[:3], law.at(t)[:3], strict=True)
    if any(np.abs(ours - its).max() > SAME * np.abs(its).max() for ours, its in pairs):
        raise UntimedMove("ruckig's time law is not one of seven segments: change the limits or the cycle slightly")
    return found


def _of_struts(move: Trajectory, case: Case) -> float:
    """Largest share of the pace that the struts allow."""
    machine, _, limits = case.need_machine("re-timing")
    _, velocity, acceleration = strut_motion(sample(move, PROOF_RATE), machine)
    return max(
        float(np.abs(velocity).max()) / limits.motion.strut_velocity_m_s,
        float(np.sqrt(np.abs(acceleration).max() / limits.motion.strut_acceleration_m_s2)),
    )
