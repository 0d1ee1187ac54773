"""What tests of the search share: model 9 of the built-in hexapod, and its reference scaling."""

import numpy as np
import pytest

from cases.schema import Case
from identification.model import Model, identification_model
from identification.reference import reference_scaling


@pytest.fixture(scope="package")
def model(hexapod_case: Case) -> Model:
    return identification_model(hexapod_case, 9)


@pytest.fixture(scope="package")
def scaling(hexapod_case: Case, model: Model) -> np.ndarray:
    return reference_scaling(hexapod_case, model)
