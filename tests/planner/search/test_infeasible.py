"""Where no motion keeps the limits the planner says so and names the limit."""

import pickle

import numpy as np
import pytest

from cases.base.errors import CaseError, Code, HexciteError, InfeasiblePlan, ProgramError
from cases.schema import Case
from identification.limits.proof import prove
from identification.model.model import identification_model
from planner.families.fourier import FourierFamily
from planner.search.feasibility import keep_limits
from planner.search.solving import Task, run_start
from tests.helpers import one_line
from tests.postprocessors.changed_case import changed


def family(case: Case) -> FourierFamily:
    half = (case.limits.motion.coordinates[1] - case.limits.motion.coordinates[0]) / 2
    return FourierFamily(2, 3.0, 1, case.machine.home.vector, half)


@pytest.mark.parametrize(
    ("key", "value", "limit"),
    [
        ("limits__motion__strut_length_mm", [1200.0, 1460.0], "strut length"),
        ("workspace__strut_length_mm", [650.0, 900.0], "strut length"),
        ("workspace__base_joint_angle_deg", 20.0, "base joint angle"),
        ("workspace__platform_joint_angle_deg", 20.0, "platform joint angle"),
    ],
)
def test_a_home_out_of_reach_makes_every_motion_infeasible(key: str, value: object, limit: str, hexapod_case: Case):
    case = changed(hexapod_case, **{key: value})
    with pytest.raises(InfeasiblePlan, match=rf"{limit} .*reaches .+, limit .+; widen") as caught:
        run_start(Task(case, 0, family(case), "D", seed=1))
    one_line(caught.value)


def test_scaling_back_does_not_help_where_standing_still_is_out_of_reach(hexapod_case: Case):
    case = changed(hexapod_case, limits__motion__strut_length_mm=[1100.0, 1460.0])
    some = family(case)
    with pytest.raises(InfeasiblePlan, match="strut length"):
        keep_limits(case, some, np.full(some.unknowns * 6, 1e-9), 1000.0)


@pytest.mark.slow
@pytest.mark.parametrize("limit", ["jerk_m_s3", "acceleration_m_s2", "velocity_mm_s"])
def test_limits_a_billion_times_too_narrow_end_in_one_line(
    limit: str, hexapod_case: Case, capfd: pytest.CaptureFixture
):
    """Either a tiny motion that keeps them, or an error of ours; and not a word from the solver."""
    slow = {"controller__safe_feed_mm_min": 1e-9}  # the case demands a feed that the limits allow
    case = changed(hexapod_case, **{f"limits__motion__{limit}": [1e-9] * 3}, **slow)
    try:
        start = run_start(Task(case, 0, family(case), "D", seed=1))
    except HexciteError as error:
        one_line(error)
    else:
        unknowns, _ = keep_limits(case, family(case), start.unknowns, 1000.0)
        assert prove(family(case).motion(unknowns), case, 1000.0).kept
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "error",
    [
        CaseError(file="case.toml", key="machine.home", problem="is out of reach", code=Code.INFEASIBLE),
        ProgramError(file="p.ngc", line=3, column=7, problem="is wrong", code=Code.SYNTAX),
        InfeasiblePlan(problem="no feasible motion", code=Code.INFEASIBLE),
    ],
)
def test_an_error_in_a_worker_reaches_the_user_as_it_was(error: HexciteError):
    """Starts run in processes of their own: what they raise is pickled on its way."""
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_a_model_that_the_case_does_not_have_is_no_matter_of_the_solver(hexapod_case: Case):
    with pytest.raises(HexciteError, match=r"model 42 .*Table 2"):
        identification_model(hexapod_case, 42)
