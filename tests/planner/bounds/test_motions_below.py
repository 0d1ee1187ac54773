"""No motion inside the limits passes the bound: random ones of every family, and optimised ones."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.units import DEG, MM
from cases.schema import load_case
from identification.estimation.criteria import box_middle, reference_scaling
from identification.limits.proof import prove
from identification.model.model import Model, identification_model
from identification.motion.motion import Trajectory
from planner.bounds.bound import compute_bound, information_limit
from planner.families.fourier import FourierFamily
from planner.families.manual import manual_motion
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.noise import mean_information
from planner.search.feasibility import keep_limits
from planner.search.solving import Task, run_start
from tests.helpers import examples, few
from tests.random_start import random_start

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 0)
ALL = identification_model(CASE, 9)


@pytest.fixture(scope="module")
def box() -> float:
    return compute_bound(CASE, MODEL).logdet


def feasible(name: str, seed: int, folder: Path) -> Trajectory:
    """A random motion of a family of the planner, inside every limit of the case."""
    draw = np.random.default_rng(seed)
    if name == "manual":
        offsets = draw.uniform(-1.0, 1.0, (int(draw.integers(3, 6)), 6)) * box_middle(CASE)[1]
        poses = (CASE.machine.home.vector + offsets) / np.r_[np.full(3, MM), np.full(3, DEG)]
        file = folder / "poses.csv"
        np.savetxt(file, poses, delimiter=",", header="x_mm,y_mm,z_mm,a_deg,b_deg,c_deg", comments="")
        return manual_motion(CASE, file)
    order, period = int(draw.integers(2, 8)), float(draw.uniform(1.0, 4.0))
    family = {
        "fourier": FourierFamily(order, period, 1, *box_middle(CASE)),
        "ptp": PointToPointFamily.of(CASE, int(draw.integers(8, 17)), float(draw.uniform(2.0, 6.0))),
        "spline": SplineFamily.of(CASE, int(draw.integers(20, 41)), float(draw.uniform(2.0, 4.0))),
    }[name]
    unknowns = random_start(family, draw, lambda values: 0.05 * float(np.abs(values).max()))
    return family.motion(keep_limits(CASE, family, unknowns, 1000.0)[0])


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(["fourier", "ptp", "spline", "manual"]))
@settings(max_examples=examples(8), derandomize=True, deadline=None)
def test_no_random_feasible_motion_of_any_family_passes_the_bound(
    seed: int, name: str, box: float, tmp_path_factory: pytest.TempPathFactory
):
    """The planner's own classes, drawn to the very edge of the limits."""
    motion = feasible(name, seed, tmp_path_factory.mktemp("poses"))
    assert prove(motion, CASE, 1000.0).kept
    sign, logdet = np.linalg.slogdet(mean_information(MODEL, reference_scaling(CASE, MODEL), motion))
    assert sign <= 0 or logdet < box


@pytest.mark.slow
@pytest.mark.parametrize("model", few(MODEL, ALL))
def test_nor_does_an_optimised_one(model: Model):
    """Thirty iterations towards the bound leave it out of reach."""
    family = FourierFamily(3, 3.0, 1, *box_middle(CASE))
    start = run_start(Task(CASE, model.number, family, "D", seed=1))
    drawn = family.motion(random_start(family, np.random.default_rng(1), lambda values: float(np.abs(values).max())))
    scaling = reference_scaling(CASE, model)
    assert start.record.logdet > np.linalg.slogdet(mean_information(model, scaling, drawn))[1]
    assert start.record.logdet < information_limit(CASE, model).logdet
