"""A machine that stands at the end of its box, as one that is parked at the bottom: every family plans from there."""

from copy import deepcopy

import pytest

from cases.schema import Case, load_case
from planner import Fourier, PointToPoint, Spline, plan
from planner.families.settings import FamilySettings
from tests.helpers import few


@pytest.mark.parametrize("family", few(Fourier(), PointToPoint(), Spline(), kept=0))
def test_every_family_plans_from_the_end_of_the_box(family: FamilySettings) -> None:
    data = deepcopy(load_case("hexapod").model_dump())
    data["limits"]["motion"].update(x_mm=(0.0, 250.0), z_mm=(0.0, 100.0))
    case = Case.model_validate(data)
    found = plan(case, family, duration=4.0, starts=1, workers=1)
    assert not found.limits.violations
    assert found.worth.d_efficiency > 0.05
