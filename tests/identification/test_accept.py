"""Results are judged by limits: each with its value, passed or failed."""

from dataclasses import replace

import numpy as np
import pytest

import hexcite as hx
from cases.acceptance import Acceptance, Reference
from cases.sensors import SensorFrame
from cases.tolerances import Tolerances
from identification.estimation.fit import Value
from identification.results.payload import common_of
from identification.results.result import Result
from identification.results.verdicts import en, of_reference
from tests.damaged.runs import SOUND, STATED, Moves, machine, recorded


@pytest.fixture(scope="module")
def result() -> Result:
    of = machine("hexapod")
    case = of.case.model_copy(update={"tolerances": Tolerances.model_validate({"gain_percent": 0.2})})
    return hx.identify(recorded(of, Moves(of, 1, 4.0), 1, STATED, SOUND), case)


def with_limits(result: Result, **limits) -> hx.Verdict:
    return hx.accept(result, result.case.model_copy(update={"accept": Acceptance.model_validate(limits)}))


def test_a_sound_run_passes_what_needs_no_statement(result: Result) -> None:
    verdict = hx.accept(result)
    assert verdict.passed
    names = " ".join(check.name for check in verdict.checks)
    assert "noise" in names
    assert "mass" in names
    assert any("plan" in reason for reason in verdict.unjudged)
    noise = next(check for check in verdict.checks if check.name.startswith("noise"))
    assert noise.value == pytest.approx(1.0, abs=0.2)


def test_each_limit_fails_by_itself_where_it_is_below_the_value(result: Result) -> None:
    off = 100.0 * abs(result["m"].value / result.case.nominal.mass_kg - 1.0)
    std = result["m"].reported
    for limits, words in (
        ({"noise_times": 0.5}, "noise"),
        ({"mass_percent": 0.9 * off}, "mass"),
        ({"deviations": {"mass_kg": 0.9 * std}}, "deviation of mass"),
        ({"reference": {"mass_kg": result["m"].value + 5.0 * std, "mass_U_kg": 0.1 * std}}, "E_n of mass"),
    ):
        verdict = with_limits(result, **limits)
        assert [words in check.name for check in verdict.checks if not check.passed] == [True], limits
        assert not verdict.passed
        assert verdict.to_json()["passed"] is False
    kept = with_limits(
        result, deviations={"mass_kg": 1.1 * std}, reference={"mass_kg": result["m"].value + std, "mass_U_kg": std}
    )
    assert kept.passed
    assert len(kept.checks) == len(hx.accept(result).checks) + 2


def test_a_run_that_took_longer_or_went_elsewhere_than_planned_fails(result: Result) -> None:
    figures = {"plan": "plan", "share_of_path": 0.9, "times_longer": 1.2}
    finding = hx.Finding(next(iter(result.findings)).kind, "note", "", quantity={"as_planned": figures})
    run = replace(result, record=result.record.replaced(findings=(*result.findings, finding)))
    failed = {check.name: check.value for check in hx.accept(run).checks if not check.passed}
    assert list(failed.values()) == [pytest.approx(90.0), pytest.approx(20.0)]


def test_e_n_is_one_where_the_difference_is_both_expanded_uncertainties() -> None:
    value = Value(20.0, 0.3, 0.1, "kg")  # U = 0.6
    assert en(value, 21.0, 0.8) == pytest.approx(1.0)
    checks = list(
        of_reference({"m": value}, Reference(centre_of_gravity_mm=(1.0, 2.0, 3.0), centre_of_gravity_U_mm=1.0))
    )
    assert [text.split()[2] for text in checks] == ["xC:", "yC:", "zC:"]


@pytest.mark.parametrize("wrong", [{"mass_kg": 1.0}, {}, {"mass_kg": 1.0, "mass_U_kg": 0.0}])
def test_a_reference_without_uncertainty_is_refused(wrong: dict) -> None:
    with pytest.raises(ValueError, match="mass"):
        Acceptance.model_validate({"reference": wrong})


def test_what_a_payload_has_in_common_with_the_empty_machine_cancels(result: Result) -> None:
    common = common_of(result, result)
    total = result.covariance_robust * 2.0 - common
    own = result.covariance_robust - sum(b @ b.T for b in result.biases.values())
    np.testing.assert_allclose(np.diag(total), 2.0 * np.diag(own), rtol=1e-6, atol=1e-15)
    other = replace(result, record=result.record.replaced(computed_from={"tolerances.gain_percent": 0.1}))
    assert not common_of(result, other).any()
    assert not common_of(result, replace(result, record=result.record.replaced(tolerance_biases=None))).any()


@pytest.mark.parametrize(("at", "rods"), [("drive", 12.0), ("platform", 0.0)])
def test_rods_that_sensors_at_the_drives_carry_are_part_of_the_expected_mass(
    result: Result, at: str, rods: float
) -> None:
    values = {"rod_mass_kg": 2.0, "rod_first_moment_kg_m": 0.9, "tube_first_moment_kg_m": 1.0, "inertia_kg_m2": 1.0}
    frame = SensorFrame.model_validate({"struts": {"at": at, **values}})
    verdict = hx.accept(result, result.case.model_copy(update={"sensor_frame": frame}))
    (mass,) = [check for check in verdict.checks if check.code == "mass"]
    expected = result.case.nominal.mass_kg + rods
    assert mass.value == pytest.approx(100.0 * abs(result["m"].value / expected - 1.0), rel=1e-12)
