"""What tests of the search share: model 9 of the built-in hexapod, its reference scaling, and small motions."""

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import box_middle, reference_scaling
from identification.model.model import Model, identification_model
from planner.families.family import Family
from planner.families.fourier import FourierFamily, FreePeriod
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.search.nlp import NonlinearProgram
from planner.search.problem import build_program
from tests.random_start import random_start

Small = tuple[Family, NonlinearProgram, np.ndarray]
"""A family, its problem, and unknowns inside the limits."""


@pytest.fixture(scope="package")
def model(hexapod_case: Case) -> Model:
    return identification_model(hexapod_case, 9)


@pytest.fixture(scope="package")
def scaling(hexapod_case: Case, model: Model) -> np.ndarray:
    return reference_scaling(hexapod_case, model)


def family_of(case: Case, name: str) -> Family:
    """A small family by name."""
    if name == "fourier":
        return FourierFamily(3, 3.0, 1, *box_middle(case))
    if name == "free period":
        return FourierFamily(3, 3.0, 1, *box_middle(case), free=FreePeriod(2.0, 5.0, 3.0))
    if name == "ellipses":
        return FourierFamily.lasting(1, 1.5, 2, *box_middle(case), centred=True)
    return PointToPointFamily.of(case, 8, 3.0) if name == "ptp" else SplineFamily.of(case, 20, 2.0)


@pytest.fixture(scope="package", params=["fourier", "free period", "ellipses", "ptp", "spline"])
def small(request: pytest.FixtureRequest, hexapod_case: Case) -> Small:
    """Model 5, and every limit a row at some states."""
    model = identification_model(hexapod_case, 5)
    family = family_of(hexapod_case, request.param)
    problem = build_program(hexapod_case, model, family, reference_scaling(hexapod_case, model), 1e-3)
    unknowns = random_start(family, np.random.default_rng(4), problem.worst)
    return family, problem.with_rows_above(unknowns, 0.2), unknowns
