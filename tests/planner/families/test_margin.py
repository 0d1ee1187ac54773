"""Plans stop before the ends of ways by what `limits.margin` states; proofs judge by the ends themselves."""

from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import CaseError
from cases.chain import Margin
from cases.schema import Case, load_case
from identification.limits.limit import LimitKind
from identification.limits.proof import limited_machine
from identification.machines.hexapod import Hexapod
from identification.motion.motion import sample
from identification.samples.sample_checks import scan
from identification.simulate import simulate_recording
from planner import Fourier, PointToPoint, Spline, plan
from planner.families.settings import FamilySettings
from tests.cases.editing import edited
from tests.helpers import Harmonic, few
from tests.simulated_machine import PoseExecution

SHORT = (800.0, 1180.0)  # strut lengths that bind long before the box does [mm]


def hexapod_of_short_struts(**margin: float) -> Case:
    """The hexapod with struts that end the motion."""
    data: dict[str, Any] = deepcopy(load_case("hexapod").model_dump())
    for table in (data["limits"]["motion"], data["workspace"]):
        table["strut_length_mm"] = SHORT
    data["limits"]["margin"] = margin
    return Case.model_validate(data)


def closest(case: Case, family: FamilySettings) -> float:
    """The least distance of a strut of a plan from the ends of its way [mm]."""
    found = plan(case, family, duration=4.0, starts=1, workers=1)
    assert not found.limits.violations
    lengths = 1e3 * limited_machine(case).drives(sample(found.motion, 1000.0))[0]
    return float(min(lengths.min() - SHORT[0], SHORT[1] - lengths.max()))


@pytest.mark.slow
@pytest.mark.parametrize("family", few(Fourier(order=2), PointToPoint(), Spline(), kept=1))
def test_struts_stop_a_millimetre_before_their_ends(family: FamilySettings) -> None:
    assert closest(hexapod_of_short_struts(), family) >= 1.0 - 1e-6


@pytest.mark.slow
def test_without_a_margin_plans_use_the_whole_way() -> None:
    assert closest(hexapod_of_short_struts(travel_percent=0.0), Spline(knots=30)) < 0.95


@pytest.mark.parametrize("family", few(Fourier(order=2), PointToPoint(), kept=0))
def test_joints_and_their_boxes_stop_before_their_ends(family: FamilySettings) -> None:
    case = load_case("five_axis_table")
    found = plan(case, family, duration=6.0, starts=1, workers=1)
    home, limits = case.need_motion("a test")
    margin = np.where(limits.turns, np.radians(0.1), 1e-3)
    pose = sample(found.motion, 1000.0).coordinates - home
    assert np.all(pose >= limits.coordinates[0] + 0.999 * margin)
    assert np.all(pose <= limits.coordinates[1] - 0.999 * margin)
    assert any(c.kind in (LimitKind.POSITION, LimitKind.ANGLE) and c.ratio > 0.9 for c in found.limits.checks)


@given(
    low=st.floats(-500.0, 0.0),
    high=st.floats(0.0, 500.0),
    share=st.floats(0.0, 10.0),
    most=st.floats(0.0, 5.0),
)
def test_a_margin_is_a_share_of_the_way_and_no_more_than_stated(
    low: float, high: float, share: float, most: float
) -> None:
    motion = load_case("hexapod").need_machine("a test")[2].model_copy(update={"x_mm": (low, high)})
    inner = Margin(travel_percent=share, most_mm=most).narrowed(motion)
    expected = min((high - low) * share / 100.0, most)
    assert np.allclose(inner.x_mm, (low + expected, high - expected), atol=1e-9)
    assert inner.x_mm[0] <= inner.x_mm[1] + 1e-9
    assert inner.velocity_mm_s == motion.velocity_mm_s


def test_a_case_without_the_table_is_the_same_case() -> None:
    data = deepcopy(load_case("hexapod").model_dump())
    del data["limits"]["margin"]
    assert Case.model_validate(data).hash == load_case("hexapod").hash


def test_a_margin_that_leaves_no_way_is_refused(tmp_path: Any) -> None:
    file = edited(tmp_path, "travel_percent = 0.5", "travel_percent = 50.0")
    with pytest.raises(CaseError, match=r"limits\.margin\.travel_percent"):
        load_case(file)


@pytest.mark.parametrize(("left", "told"), [(1.0, False), (0.0, False), (-1.5, True)])
def test_a_noisy_run_of_a_plan_that_keeps_the_margin_gets_no_word_about_the_workspace(left: float, told: bool) -> None:
    """Struts come as near to their ends as a plan may, and encoders stray beyond them by less than the margin [mm]."""
    case = load_case("hexapod")
    run = simulate_recording(case, PoseExecution(Hexapod.of(case), Harmonic(duration=1.0)), np.array([[0.1, 0.9]]), 0)
    struts = run.drives + 2e-4 * np.random.default_rng(0).normal(size=run.drives.shape)
    data = deepcopy(case.model_dump())
    ends = 1e3 * run.drives.min() - left, 1e3 * run.drives.max() + left
    for table in (data["limits"]["motion"], data["workspace"]):
        table["strut_length_mm"] = ends
    _, findings = scan(replace(run, drives=struts), Case.model_validate(data))
    assert any("outside the workspace" in f.sentence for f in findings) is told
