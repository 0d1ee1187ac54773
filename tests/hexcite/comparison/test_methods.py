"""Methods of a validation are data: what the file states is what is planned, and a table more is a method more."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from cases.base.errors import CaseError, HexciteError
from cases.schema import load_case
from hexcite.comparison.trials import METHODS, MethodSpec, language_of_method, require_methods
from identification.estimation.criteria import Criterion
from planner.families.settings import Fourier, Manual, PointToPoint, Spline
from planner.request import PoseRequest, Request


def test_the_papers_methods_and_ours_are_what_the_paper_and_we_say():
    assert {name: method.request for name, method in METHODS.items()} == {
        "Q5M": PoseRequest(method="all"),
        "Q5N": PoseRequest(criterion=Criterion.N, count=30, method="backward"),
        "D9M": Request(Manual()),
        "D9N": Request(Fourier(order=3, free_period=True), criterion=Criterion.N),
        "ptp": Request(PointToPoint(controller="virtual")),
        "ptp-steps": Request(PointToPoint(controller="linuxcnc", without="jerk")),
        "spline": Request(Spline()),
    }


def test_a_table_more_is_a_method_more(monkeypatch: pytest.MonkeyPatch):
    entries = {"label": "few moves", "family": "ptp", "settings": {"moves": 12}}
    with pytest.raises(HexciteError, match=r"method 'few' .*choose Q5M, "):
        require_methods(["few"])
    monkeypatch.setitem(METHODS, "few", MethodSpec.model_validate(entries))
    require_methods(["few"])
    assert METHODS["few"].request == Request(PointToPoint(moves=12))


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"family": "ptp"}, "label"),
        ({"label": "a", "family": "ptp", "colour": "red"}, "colour"),
        ({"label": "a", "family": "ptp", "program": "fanuc"}, "program"),
    ],
)
def test_a_table_that_says_something_else_is_refused_with_its_key(entries: dict[str, object], words: str):
    with pytest.raises(ValidationError, match=words):
        MethodSpec.model_validate(entries)


def test_a_method_is_run_in_a_language_that_the_case_has(hexapod_file: Path):
    """A user of TwinCAT is not asked for the settings of SINUMERIK."""
    case = load_case(str(hexapod_file))
    assert [language_of_method(case, method, "virtual") for method in ("D9M", "ptp-steps")] == ["sinumerik", "linuxcnc"]
    assert language_of_method(case, "D9M", "linuxcnc") == "linuxcnc"
    controller = case.need_controller("a test")
    only = case.model_copy(update={"controller": controller.model_copy(update={"sinumerik": None})})
    assert language_of_method(only, "D9M", "virtual") == "twincat"
    none = case.model_copy(update={"controller": controller.model_copy(update={"sinumerik": None, "twincat": None})})
    with pytest.raises(CaseError, match=r"controller\.sinumerik or controller\.twincat: is missing; the method D9M"):
        language_of_method(none, "D9M", "virtual")
