"""Bounds of a body as a prior of its estimate: what CAD knows counts, and only where it tells something."""

from dataclasses import replace

import numpy as np
import pytest

from cases.bounds import BodyBox, Bounds
from cases.schema import Case
from identification.estimation.bounded import bounded
from identification.identify import identify
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.results.pooling import pool
from identification.results.result import Result
from tests.bench.tolerances import CHAIN
from tests.damaged.runs import STATED, Moves, machine, recorded

ARM = "ur10_wrist"


def weak(case_bounds: dict | None, seed: int = 1) -> Result:
    """A result of a short and noisy run of the arm."""
    of = machine(ARM)
    data = of.case.model_dump(mode="json", exclude_unset=True) | {"tolerances": CHAIN}
    if case_bounds is not None:
        data["bounds"] = case_bounds
    case = Case.model_validate(data).found_at(ARM)
    run = recorded(of, Moves(of, 3, 3.0, 0.6), seed, replace(STATED, size=4.0))
    return identify(replace(run, case=case), case)


def around(size_kg: float, reach_mm: float, shift: float = 0.0) -> dict:
    truth = machine(ARM).truth
    centre = [1e3 * truth[name] for name in ("xC", "yC", "zC")]
    box = {f"{a}_mm": [c - reach_mm + shift, c + reach_mm + shift] for a, c in zip("xyz", centre, strict=True)}
    return {"mass_kg": [truth["m"] - size_kg, truth["m"] + size_kg], "centre_of_gravity_mm": box}


def test_an_estimate_with_bounds_is_that_of_both_together() -> None:
    """Independent: generalised least squares of the estimate and of pseudo-measurements, at the estimate's slopes."""
    plain = weak(None)
    model, u = plain.model, plain.values
    box = BodyBox(x_mm=(-3.0, 5.0), y_mm=(-9.0, -5.0), z_mm=(84.0, 87.0))
    found = bounded(model, u, plain.covariance, plain.covariance, Bounds(mass_kg=(2.0, 3.0), centre_of_gravity_mm=box))
    assert found is not None
    assert found.names == ("m", "xC", "yC", "zC")
    form = physical_form(model)
    names = [p.name for p in form.parameters]
    rows = form.map(found.values)[1].full()[[names.index(n) for n in ("m", "xC", "yC", "zC")]]
    now = form.map(found.values)[0].full()[[names.index(n) for n in ("m", "xC", "yC", "zC")], 0]
    middle, half = np.array([2.5, 1e-3, -7e-3, 85.5e-3]), np.array([0.5, 4e-3, 2e-3, 1.5e-3])
    larger = plain.covariance
    information = np.linalg.inv(larger) + rows.T @ np.diag(3.0 / half**2) @ rows
    right = np.linalg.inv(larger) @ u + rows.T @ np.diag(3.0 / half**2) @ (middle - now + rows @ found.values)
    expected = np.linalg.solve(information, right)
    scale = np.sqrt(np.diag(larger))
    np.testing.assert_allclose(found.values / scale, expected / scale, atol=0.02)
    total = found.kept @ larger @ found.kept.T + found.biases @ found.biases.T
    np.testing.assert_allclose(np.diag(total), np.diag(np.linalg.inv(information)), rtol=0.02)


def test_bounds_lower_deviations_and_stand_in_the_budget() -> None:
    plain, known = weak(None), weak(around(0.005, 0.4))
    assert known["m"].reported < 0.7 * plain["m"].reported
    assert known["zC"].reported < 0.7 * plain["zC"].reported
    for name, parts in known.budget.items():
        assert sum(v**2 for v in parts.values()) == pytest.approx(known[name].reported ** 2, rel=0.03), name
    assert known.budget["m"]["priors"] > 0.0
    assert any("[bounds] of the case are part of the estimate" in note for note in known.notes)
    errors = [(known[n].value - machine(ARM).truth[n]) / known[n].reported for n in ("m", "xC", "yC", "zC")]
    assert np.abs(errors).max() < 3.0


def test_bounds_that_tell_nothing_change_nothing() -> None:
    plain, wide = weak(None), weak(around(2.0, 500.0))
    np.testing.assert_array_equal(wide.values, plain.values)
    assert not any("[bounds]" in note for note in wide.notes)


def test_bounds_of_another_body_are_not_used_and_said() -> None:
    plain, other = weak(None), weak({"mass_kg": [20.0, 21.0]})
    np.testing.assert_array_equal(other.values, plain.values)
    assert any("bounds.mass_kg" in text for text in (*other.warnings, *other.notes))


def test_pooled_runs_count_bounds_once() -> None:
    """The error of the range is the same in all of them."""
    runs = [weak(around(0.002, 0.1), seed) for seed in (1, 2, 3, 4)]
    both = pool(runs)
    assert both["m"].reported > 0.8 * runs[0].budget["m"]["priors"]
    assert both.budget["m"]["priors"] == pytest.approx(np.mean([r.budget["m"]["priors"] for r in runs]), rel=0.2)


def test_no_body_no_prior() -> None:
    model = identification_model(machine(ARM).case, 0)
    u, square = np.ones(len(model.names)), np.eye(len(model.names))
    assert bounded(model, u, square, square, None) is None
