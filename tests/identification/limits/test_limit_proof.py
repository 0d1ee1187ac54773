"""The numeric proof of limits: it agrees with the CasADi model, and no limit is passed unnoticed."""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.machine import MotionLimits, turned
from cases.schema import Case, load_case
from identification.limits.limit import LimitCheck, LimitKind, LimitReport
from identification.limits.proof import prove
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Motion, Standstill, TimedPoints, Trajectory, sample
from identification.motion.moves import StraightMove
from tests.helpers import HOME, Harmonic, seeds
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
RATE = 500.0  # [1/s] of the proofs here


@dataclass(frozen=True)
class Slower:
    """The same motion on a clock that runs at another pace."""

    motion: Trajectory
    pace: float

    @property
    def duration(self) -> float:
        return self.motion.duration / self.pace

    def at(self, t: np.ndarray) -> Motion:
        m, p = self.motion.at(np.asarray(t) * self.pace), self.pace
        return Motion(np.asarray(t), m.coordinates, p * m.rates, p**2 * m.accelerations, p**3 * m.jerks)


def with_limits(**changes: object) -> Case:
    motion = CASE.limits.motion
    limits = MotionLimits.model_validate(motion.model_dump() | changes)
    return CASE.model_copy(update={"limits": CASE.limits.model_copy(update={"motion": limits})})


def named(report: LimitReport) -> dict[str, LimitCheck]:
    return {str(check.of): check for check in report.checks}


WIDE = [-1e4, 1e4]
NO_LIMITS: dict[str, Any] = dict.fromkeys(["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg", "strut_length_mm"], WIDE)
NO_LIMITS |= {
    k: [1e9] * 3
    for k in MotionLimits.model_fields
    if k.startswith(("velocity", "acc", "jerk", "angular")) and not re.search("angular_.*_deg_s[23]", k)
}
NO_LIMITS |= {"strut_velocity_m_s": 1e9, "strut_acceleration_m_s2": 1e9}

# kind -> the keys that set its limit, in the unit of the report
KINDS = {
    "position": lambda worst: {k: [-abs(worst), abs(worst)] for k in ("x_mm", "y_mm", "z_mm")},
    "angle": lambda worst: {k: [-abs(worst), abs(worst)] for k in ("a_deg", "b_deg", "c_deg")},
    "velocity": lambda worst: {"velocity_mm_s": [abs(worst)] * 3},
    "angular velocity": lambda worst: {"angular_velocity_deg_s": [abs(worst)] * 3},
    "acceleration": lambda worst: {"acceleration_m_s2": [abs(worst)] * 3},
    "angular acceleration": lambda worst: {"angular_acceleration_rad_s2": [abs(worst)] * 3},
    "jerk": lambda worst: {"jerk_m_s3": [abs(worst)] * 3},
    "angular jerk": lambda worst: {"angular_jerk_rad_s3": [abs(worst)] * 3},
    "strut length": lambda worst: {"strut_length_mm": [1.0, worst]},
    "strut velocity": lambda worst: {"strut_velocity_m_s": abs(worst)},
    "strut acceleration": lambda worst: {"strut_acceleration_m_s2": abs(worst)},
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_limit_just_below_what_the_motion_reaches_is_passed_and_just_above_it_is_kept(kind: str) -> None:
    motion = Harmonic(seed=3)
    reached = abs(named(prove(motion, with_limits(**NO_LIMITS), RATE))[kind].worst)
    if kind == "strut length":  # has two sides; the test is about the longest strut
        reached = Hexapod.of(CASE).strut_lengths(sample(motion, RATE).coordinates).max() * 1e3
    for factor, kept in ((0.999, False), (1.001, True)):
        report = prove(motion, with_limits(**NO_LIMITS | KINDS[kind](factor * reached)), RATE)
        assert named(report)[kind].kept == kept
        assert [str(v.of) for v in report.violations] == ([] if kept else [kind])
    worst = named(report)[kind]
    assert worst.sentence().startswith(f"{kind} (")
    assert f" reaches {worst.worst:.4g} {worst.unit} at " in worst.sentence()


@pytest.mark.parametrize(("joint", "key"), [("base", "base_joint_angle_deg"), ("platform", "platform_joint_angle_deg")])
def test_a_joint_that_is_bent_too_far_is_reported(joint: str, key: str) -> None:
    bent = named(prove(Harmonic(seed=3), CASE, RATE))[f"{joint} joint angle"].worst
    for factor, kept in ((0.999, False), (1.001, True)):
        workspace = CASE.workspace.model_copy(update={key: factor * bent})
        report = prove(Harmonic(seed=3), CASE.model_copy(update={"workspace": workspace}), RATE)
        assert named(report)[f"{joint} joint angle"].kept == kept


@seeds(3)
def test_strut_motion_agrees_with_the_casadi_model(seed: int) -> None:
    """Two implementations without a line in common: product rule on matrices, algorithmic differentiation."""
    motion = Harmonic(seed=seed)
    m = sample(motion, RATE)
    length, velocity, acceleration = over_samples(
        Hexapod.of(CASE).strut_motion, m.coordinates, m.rates, m.accelerations
    )
    found = named(prove(motion, CASE, RATE))
    assert abs(found["strut velocity"].worst) == pytest.approx(np.abs(velocity).max(), rel=1e-12)
    assert abs(found["strut acceleration"].worst) == pytest.approx(np.abs(acceleration).max(), rel=1e-12)
    row = int(np.argmin(np.abs(m.t - found["strut length"].time)))
    assert np.abs(length[row] * 1e3 - found["strut length"].worst).min() < 1e-9


def test_kept_inside_and_the_worst_ratio_counts() -> None:
    report = prove(Slower(Harmonic(seed=3, size=0.3), 0.5), CASE, RATE)
    assert report.kept
    assert report.violations == ()
    assert report.worst_ratio == max(c.ratio for c in report.checks) < 1.0


def test_twice_the_pace_doubles_velocities_and_quadruples_accelerations() -> None:
    slow, fast = (named(prove(Slower(Harmonic(seed=5), pace), CASE, RATE * pace)) for pace in (0.5, 1.0))
    for kind, power in {
        "velocity": 1,
        "strut velocity": 1,
        "acceleration": 2,
        "strut acceleration": 2,
        "jerk": 3,
    }.items():
        assert fast[kind].worst == pytest.approx(2**power * slow[kind].worst, rel=1e-9)


def test_crossing_a_singularity_is_reported_and_standing_before_it_is_not() -> None:
    """Turning about z this hexapod passes a singularity before a quarter turn; det J^-1 changes its sign there."""
    hexapod, case = Hexapod.of(CASE), with_limits(**NO_LIMITS)
    beyond = HOME + np.deg2rad([0, 0, 0, 0, 0, 100.0])
    signs = [np.sign(np.linalg.det(over_samples(hexapod.inverse_jacobian, p[None])[1][0])) for p in (HOME, beyond)]
    assert signs[0] == -signs[1]
    move = StraightMove.fastest(HOME, beyond, np.ones(6), np.ones(6), np.ones(6))
    check = named(prove(move, case, RATE))["singularity"]
    assert not check.kept
    assert check.worst < 0.0  # of det J^-1 at home, in %
    at_home = named(prove(Standstill(HOME, 1.0), case, RATE))["singularity"]
    assert (at_home.worst, at_home.limit, at_home.unit) == (pytest.approx(100.0), 0.0, "% of det J^-1 at home")
    assert at_home.ratio == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("order", ["coordinates", "rates", "accelerations", "jerks"])
def test_a_motion_that_is_nowhere_a_number_passes_limits(order: str) -> None:
    class Damaged:
        duration = 1.0

        def at(self, t: np.ndarray) -> Motion:
            arrays = {
                n: getattr(Harmonic(size=0.1).at(t), n).copy()
                for n in ("coordinates", "rates", "accelerations", "jerks")
            }
            arrays[order][len(t) // 2, 3] = np.nan
            return Motion(np.asarray(t), **arrays)

    report = prove(Damaged(), CASE, RATE)
    assert not report.kept
    assert not np.isfinite(report.worst_ratio)


def test_the_report_names_time_and_place_on_the_callers_clock() -> None:
    poses = np.tile(HOME, (3, 1))
    poses[1, 1] += 0.3
    points = TimedPoints.through([0.0, 2.0, 4.0], poses)
    check = named(prove(points, CASE, RATE).later(10.0))["position"]
    assert (check.name, check.limit, check.unit) == ("position (y)", 250.0, "mm")
    assert check.worst == pytest.approx(300.0, rel=1e-4)
    assert check.time == pytest.approx(12.0, abs=0.01)
    assert check.ratio == pytest.approx(1.2, rel=1e-4)


def test_a_case_without_machine_cannot_be_proven(wrist_case: Case) -> None:
    with pytest.raises(CaseError, match=r"machine: .*missing.*proof of limits"):
        prove(Harmonic(), wrist_case)


def test_far_from_a_box_the_nearest_approach_is_told(hexapod_case: Case):
    """The share is 0 all along, yet a reader compares the least distance, whichever part of the run has it."""
    box = {"name": "post", "x_mm": [1200.0, 1300.0], "y_mm": [-50.0, 50.0], "z_mm": [900.0, 1000.0]}
    case, move = changed(hexapod_case, workspace__keep_out=[box]), Harmonic(seed=1, duration=3.0)
    check = next(c for c in prove(move, case, 2000.0).checks if c.kind is LimitKind.DISTANCE_FROM_BOX)
    assert check.ratio == 0.0
    poses, machine = move.at(np.linspace(0.0, 3.0, 601)).coordinates, case.need_machine("a test")[0]
    tops = np.array([p[:3] + machine.platform.points @ turned(p[3:]).T for p in poses])
    share = np.linspace(0.0, 1.0, 201)[:, None, None, None]
    struts = machine.base.points + share * (tops - machine.base.points)  # points along them
    low, high = np.array([1.2, -0.05, 0.9]), np.array([1.3, 0.05, 1.0])
    apart = np.maximum(low - struts, struts - high).max(axis=-1).min()  # along the axis that separates them most
    nearest = apart - 1e-3 * case.need_machine("a test")[1].strut_radius_mm
    assert check.worst == pytest.approx(1e3 * nearest, abs=1.0)
    assert "at least" in check.sentence()
