"""Deviations that a plan predicts are those that its run is given, tolerances of the case included."""

from functools import cache

import numpy as np
import pytest

import hexcite as hx
from cases.schema import Case, load_case
from cases.tolerances import KINDS, TYPICAL
from hexcite._run import execute
from hexcite._write import write
from identification.estimation.criteria import reference_scaling
from identification.findings.tolerances import MEMORY
from identification.model.model import identification_model
from identification.results.result import Result
from planner.families.settings import PointToPoint
from planner.noise import expected_noise
from planner.plans.figures import prediction_of
from planner.plans.plan import Plan
from planner.plans.prediction import NOISE, Prediction, Promise
from tests.helpers import few
from tests.hexcite.command_line import call

MACHINES = ("five_axis_table", "hexapod", "ur10_wrist")


def tolerant(name: str, **tolerances: float) -> Case:
    """A built-in case with tolerances; typical ones unless given."""
    case = load_case(name)
    data = case.model_dump(mode="json", exclude_unset=True)
    data["tolerances"] = tolerances or {key: TYPICAL[key] for key in TYPICAL if key in case.tolerable}
    return Case.model_validate(data)


@cache
def planned(name: str) -> Plan:
    return hx.plan(tolerant(name), PointToPoint(moves=12), 5.0, starts=1, workers=1)


@cache
def identified(name: str) -> Result:
    plan = planned(name)
    return hx.identify(execute(write(plan, "setpoints"), plan.case, "virtual", 3)[1], plan.case, plan.model)


def prediction(name: str, values: np.ndarray | None = None, case: Case | None = None) -> Prediction:
    plan = planned(name)
    case = plan.case if case is None else case
    model = identification_model(case, plan.model)
    scaling, noise = reference_scaling(case, model), expected_noise(case, model)
    return prediction_of(case, model, scaling, plan.motion, noise, 0, values)


def test_bounds_of_the_body_lower_what_a_run_of_it_will_be_off_by() -> None:
    """A mass that is known to lie in a range as narrow as its deviation is known better: as one that was identified."""
    name = "five_axis_table"
    plan, plain = planned(name), prediction(name)
    std, value = plain.std["m"], float(plain.values[plain.model.names.index("m")])
    data = plan.case.model_dump(mode="json", exclude_unset=True)
    width = 2.0 * std
    data["bounds"] = {"mass_kg": [value - width / 2.0, value + width / 2.0]}
    case = Case.model_validate(data)
    bound = prediction(name, case=case)
    assert bound.std["m"] == pytest.approx((std**-2 + 12.0 / width**2) ** -0.5, rel=1e-6)
    assert bound.budget["m"]["priors"] > 0.0
    assert sum(part**2 for part in bound.budget["m"].values()) == pytest.approx(bound.std["m"] ** 2)
    assert all(bound.std[key] <= plain.std[key] * (1.0 + 1e-9) for key in plain.std)
    data["bounds"] = {"mass_kg": [value + 1.0, value + 1.0 + width]}  # the nominal body need not be in them
    assert prediction(name, case=Case.model_validate(data)).std["m"] == pytest.approx(bound.std["m"], rel=0.01)
    data["bounds"] = {"mass_kg": [value - 1e2 * std, value + 1e2 * std]}
    assert prediction(name, case=Case.model_validate(data)).std == plain.std
    data["bounds"] = {"mass_kg": [value - width / 2.0, value + width / 2.0]}
    inertia = [0.01, 0.0, 0.0, 0.01, 0.0, 0.01]
    weight = {"mass_kg": 5.0, "centre_of_gravity_mm": [0.0, 0.0, 50.0], "inertia_kg_m2": inertia}
    data["payloads"] = {"source": "a disc", "weights": [weight]}
    case = Case.model_validate(data)
    model = identification_model(case, plan.model)
    mounted = prediction_of(case, model, reference_scaling(case, model), plan.motion, expected_noise(case, model), 1)
    assert "priors" not in mounted.budget["m"]


@pytest.mark.parametrize("name", few(*MACHINES))
@pytest.mark.repeats
def test_a_run_of_it_reports_what_it_predicts(name: str):
    """Within 15 % for the body that was mounted, but for memory that a run finds in its noise; the mass for any body.

    That memory is of what recorder and controller add: it widens offsets and error terms by up to two.
    """
    result = identified(name)
    for parameter, std in prediction(name, result.values).std.items():
        reported, memory = result[parameter].reported, result.budget[parameter][MEMORY]
        assert np.sqrt(reported**2 - memory**2) == pytest.approx(std, rel=0.15), parameter
        assert reported < 2.2 * std, parameter
    assert result["m"].reported == pytest.approx(planned(name).predicted_std["m"], rel=0.1)


@pytest.mark.parametrize("name", few(*MACHINES))
def test_its_parts_are_those_of_the_run(name: str):
    found, promised = identified(name).budget["m"], planned(name).promise.budget["m"]
    kinds = {KINDS[key] for key, _ in planned(name).case.tolerances.stated()}
    assert set(promised) == kinds | {NOISE}
    assert sum(part**2 for part in promised.values()) == pytest.approx(planned(name).predicted_std["m"] ** 2)
    for kind in kinds:
        if found[kind] > 0.2 * identified(name)["m"].reported:
            assert promised[kind] == pytest.approx(found[kind], rel=0.15), kind


def test_a_common_gain_is_a_share_of_the_mass_whatever_the_motion():
    case = tolerant("five_axis_table", common_gain_percent=0.3)
    mass = case.body(0).mass_kg
    promised = prediction("five_axis_table", case=case)
    assert promised.budget["m"]["gains"] == pytest.approx(0.003 * mass, rel=1e-3)
    assert promised.least["m"] == pytest.approx(promised.budget["m"]["gains"])  # no run shows it


def test_what_a_run_tells_of_sizes_is_promised_too():
    """How a sensor is turned on its flange a run tells: far less than least squares alone would suffer stays."""
    name = "five_axis_table"
    plain, some, ten = (prediction(name, case=tolerant(name, sensor_deg=by)) for by in (1e-6, 1.0, 10.0))
    # ten times as far off, by least squares ten times as much; a run that tells the angles does not care
    assert some.std["zC"] < 3.0 * plain.std["zC"]
    assert ten.std["zC"] == pytest.approx(some.std["zC"], rel=0.01)
    assert ten.least["zC"] < 0.02 * ten.std["zC"]


def test_two_kinds_of_tolerances_add_as_squares():
    name = "five_axis_table"
    common, size = {"common_gain_percent": 0.2}, {"gravity_percent": 0.1}
    one, other, both = (prediction(name, case=tolerant(name, **of)) for of in (common, size, common | size))
    plain = prediction(name, case=load_case(name))
    assert not plain.biases
    for of, std in both.std.items():
        assert std**2 + plain.std[of] ** 2 == pytest.approx(one.std[of] ** 2 + other.std[of] ** 2, rel=1e-6)


def test_a_plan_says_what_more_seconds_cannot_lower(tmp_path):
    plan = planned("five_axis_table")
    note = next(remark for remark in plan.remarks if "more seconds lower m" in remark)
    assert "gains" in note
    assert plan.promise.least["m"] < plan.predicted_std["m"] < 1.25 * plan.promise.least["m"]
    plan.save(tmp_path / "plan")
    again = Plan.load(tmp_path / "plan", plan.case)
    assert again.promise == plan.promise
    assert "parts of ±" in str(again)


def test_what_no_deviation_counts_is_named(cache, tmp_path):
    answer = call("plan", "hexapod", "--family", "manual", "-o", tmp_path / "plan", "--json").json()
    assert "predicted_budget" not in answer
    assert "no tolerances of drawing, gains" in str(Plan.load(tmp_path / "plan"))


def test_the_worst_of_several_payloads_keeps_its_own_parts():
    one, other = (
        prediction("five_axis_table"),
        prediction("five_axis_table", case=tolerant("five_axis_table", gain_percent=2.0)),
    )
    worst = Promise.of([one, other])
    assert worst.std["m"] == other.std["m"]
    assert worst.budget["m"] == other.budget["m"]
