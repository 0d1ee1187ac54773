"""Two results of one machine, off its case by the same tolerances: their difference is uncertain by noise alone."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.units import DEG
from cases.schema import Case
from identification.identify import identify
from identification.machines.serial_chain import SerialChain
from identification.results.agreement import differences
from identification.results.frames import moved_body
from identification.results.result import Result
from tests.damaged.runs import SOUND, STATED, Moves, Noise, machine, recorded

ARM = "ur10_wrist"


@cache
def result(seed: int, gain: float, tolerance: float = 2.0, **tolerances: float) -> Result:
    of = machine(ARM)
    data = of.case.model_dump(mode="json", exclude_unset=True)
    case = Case.model_validate(data | {"tolerances": {"common_gain_percent": tolerance}}).found_at(ARM)
    run = recorded(of, Moves(of, seed, 4.0), seed, STATED)
    return identify(replace(run, forces=run.forces * (1.0 + gain), case=case), case)


def test_a_gain_that_both_have_cancels_in_their_difference() -> None:
    one, other = result(1, 0.03), result(2, 0.03)
    between = differences(one, other)
    alone = np.hypot(one["m"].expanded, other["m"].expanded)
    assert between["m"].expanded < 0.3 * alone
    assert between["m"].value == pytest.approx(other["m"].value - one["m"].value)
    errors = [2.0 * of.value / of.expanded for of in between.values()]
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) < 1.8
    assert between["m"].en == pytest.approx(abs(between["m"].value) / between["m"].expanded)


def test_gains_that_differ_are_seen_where_each_alone_would_hide_them() -> None:
    one, other = result(1, 0.0), result(2, 0.01)
    between = differences(one, other)["m"]
    assert between.en is not None
    assert between.en > 1.0
    assert abs(between.value) < np.hypot(one["m"].expanded, other["m"].expanded)


def test_results_of_other_tolerances_have_nothing_in_common() -> None:
    one, other = result(1, 0.0), result(2, 0.0, 1.0)
    alone = np.hypot(one["m"].expanded, other["m"].expanded)
    assert differences(one, other)["m"].expanded == pytest.approx(alone, rel=0.01)


def test_along_the_base_a_load_turns_with_the_zeros_of_joints() -> None:
    """What the case says of the load at home, beside where the load is when the controller says that it is there."""
    of, off = machine(ARM), 0.05 * DEG * (np.arange(6) == 3)
    data = of.case.model_dump(mode="json", exclude_unset=True) | {"tolerances": {"joint_zeros_deg": 1e-6}}
    case = Case.model_validate(data).found_at(ARM)
    run = recorded(of, Moves(of, 1, 4.0), 1, Noise(0.05, encoder=0.0), SOUND)
    wrong, right = (identify(replace(run, drives=run.drives + by, case=case), case) for by in (-off, 0.0 * off))
    still = np.zeros((1, 6))
    pose = SerialChain.of(case).kinematics((case.chain.home + off)[None], still, still).pose[0]
    place = np.eye(4)
    place[:3, :3] = Rotation.from_euler("xyz", pose[3:]).as_matrix()
    true = moved_body(place, 10) @ right.body.values
    seen = wrong.in_frame("base")
    expected = seen.biases["joint_zeros_deg"][:, 3] * 0.05 / 1e-6
    found = seen.values - true
    assert np.abs(found[1:4]).max() > 1e-5  # [kg m]
    np.testing.assert_allclose(expected[1:4], found[1:4], atol=0.1 * np.abs(found[1:4]).max())
