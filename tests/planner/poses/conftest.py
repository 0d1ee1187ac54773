"""What tests of pose sets share."""

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from cases.schema import Case, load_case
from identification.estimation.criteria import candidate_scaling, pose_regressors
from identification.model.model import Model, identification_model
from planner.poses.planned_poses import grid_candidates, sampled_candidates


class Setting(NamedTuple):
    """Candidates with their scaled regressors, shape (n, 6, 14)."""

    case: Case
    model: Model
    poses: NDArray[np.float64]
    scaling: NDArray[np.float64]
    regressors: NDArray[np.float64]


def setting(sampled: int | None) -> Setting:
    case = load_case("hexapod")
    model = identification_model(case, 5)
    poses = grid_candidates(case) if sampled is None else sampled_candidates(case, sampled, 3)
    regressors = pose_regressors(model, poses)
    scaling = candidate_scaling(regressors)
    return Setting(case, model, poses, scaling, regressors * scaling)


@pytest.fixture(scope="session")
def grid() -> Setting:
    """The paper's 480 poses."""
    return setting(None)


@pytest.fixture(scope="session")
def sample() -> Setting:
    """200 quasi-random poses: no two alike, so that a best one is unique."""
    return setting(200)
