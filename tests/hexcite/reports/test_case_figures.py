"""What `case check` says of a home that cannot be."""

import pytest

from cases.base.errors import CaseError, Code
from cases.schema import Case, load_case
from hexcite.reports.case_figures import case_figures


def thick(case: Case) -> Case:
    """The robot with a forearm of 0.6 m in radius."""
    data = case.model_dump(mode="json", exclude_unset=True)
    for joint in data["machine"]["chain"]["joints"]:
        for body in joint.get("bodies", ()):
            if body["name"] == "forearm":
                body["radius_mm"] = 600.0
    return Case.model_validate(data)


def test_bodies_that_overlap_at_home_may_be_made_smaller() -> None:
    """Those of a URDF cover what is larger than the link: another home is not the only way."""
    case = load_case("ur10_wrist")
    assert case_figures(case, "c")["name"] == "ur10_wrist"
    with pytest.raises(CaseError, match=r"machine\.chain\.joints.*links \(forearm, tool\).*smaller") as caught:
        case_figures(thick(case), "case.toml")
    assert caught.value.code is Code.INFEASIBLE
