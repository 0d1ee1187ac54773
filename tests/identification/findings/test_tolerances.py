"""Tolerances of a machine: what they do to an estimate is what the estimate does where the case is changed by them."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from cases.base.units import DEG, MM
from cases.schema import Case
from cases.tolerances import Tolerances
from identification.estimation.estimators import Method
from identification.estimation.priors import Prior
from identification.findings.left_out import LeftOut
from identification.findings.remains import free_basis, remainder_of
from identification.findings.tolerances import biases_of
from identification.fitting import fitted_run
from identification.identify import default_model, estimate_parameters
from identification.model.model import identification_model
from identification.recording.recording import Recording
from identification.samples.samples import GAUSS_MARKOV
from tests.damaged.runs import SOUND, STATED, Machine, Moves, machine, recorded
from tests.helpers import few, seeds, tells

NAMES = ("hexapod", "ur10_wrist")


@cache
def run(name: str) -> tuple[Machine, Recording]:
    of = machine(name)
    return of, recorded(of, Moves(of, 1, 6.0), 1, STATED, SOUND)


def fitted(recording: Recording, case: Case):
    return fitted_run(recording, case, identification_model(case, default_model(recording, case)), GAUSS_MARKOV).fitted


@cache
def biases(name: str, key: str) -> np.ndarray:
    of, recording = run(name)
    fit = fitted(recording, of.case)
    left_out = LeftOut.of(fit, fit.samples.motion(fit.at), of.case)
    rest = remainder_of(fit, left_out.regressors(fit.regression.names))
    return biases_of(left_out, rest, free_basis(fit), key)


def edited(case: Case, *path: str | int, by: float) -> Case:
    """The case with one number changed."""
    data = case.model_dump(mode="json", exclude_unset=True)
    place: Any = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] += by
    return Case.model_validate(data)


def points(case: Case) -> Case:
    """The hexapod with joints and bars by their points, not by rings."""
    data = case.model_dump(mode="json", exclude_unset=True)
    for table, keys in ((data["machine"], ("base", "platform")), (data["sensor_frame"]["bars"], ("lower", "upper"))):
        of = case.hexapod if table is data["machine"] else case.sensor_frame.bars
        for key in keys:
            table[key] = {"points_mm": (getattr(of, key).points / MM).tolist()}
    return Case.model_validate(data)


def joint(ring: str, point: int, axis: int):
    return lambda case, run: (edited(points(case), "machine", ring, "points_mm", point, axis, by=0.1), run)


def bar(end: str, point: int, axis: int):
    return lambda case, run: (edited(points(case), "sensor_frame", "bars", end, "points_mm", point, axis, by=0.1), run)


def gain(case: Case, run: Recording) -> tuple[Case, Recording]:
    return case, replace(run, forces=run.forces * (1.0 - 2e-3 * (np.arange(6) == 2)))


def zero(case: Case, run: Recording) -> tuple[Case, Recording]:
    return case, replace(run, drives=run.drives + 0.02 * DEG * (np.arange(6) == 4))


def sensor(case: Case, run: Recording) -> tuple[Case, Recording]:
    return edited(case, "machine", "chain", "sensor", "origin_mm", 2, by=0.5), run


def link(case: Case, run: Recording) -> tuple[Case, Recording]:
    return edited(case, "machine", "chain", "joints", 4, "origin_mm", 1, by=5.0), run


def gravity(case: Case, run: Recording) -> tuple[Case, Recording]:
    return edited(case, "gravity_m_s2", 2, by=-9.81e-3), run


def clock(case: Case, run: Recording) -> tuple[Case, Recording]:
    return case, replace(run, t=run.t * (1.0 - 1e-3))


CHANGES = [
    ("hexapod", "joints_mm", 4, joint("base", 1, 1), 0.1 * MM),
    ("hexapod", "joints_mm", 18 + 11, joint("platform", 3, 2), 0.1 * MM),
    ("hexapod", "bars_mm", 6, bar("lower", 2, 0), 0.1 * MM),
    ("ur10_wrist", "joint_zeros_deg", 4, zero, 0.02 * DEG),
    ("ur10_wrist", "sensor_mm", 2, sensor, 0.5 * MM),
    ("ur10_wrist", "links_mm", 10, link, 5.0 * MM),
    ("hexapod", "gain_percent", 2, gain, 2e-3),
    ("hexapod", "gravity_percent", 0, gravity, 1e-3),
    ("hexapod", "clock_ppm", 0, clock, 1e-3),
]


@pytest.mark.first(2)
@pytest.mark.parametrize(("name", "key", "column", "change", "size"), few(*CHANGES, kept=5))
def test_an_estimate_changes_with_the_case_as_the_budget_says(name, key, column, change, size) -> None:
    of, recording = run(name)
    case, other = change(of.case, recording)
    before, after = fitted(recording, of.case).fit, fitted(other, case).fit
    own = slice(len(identification_model(case, default_model(recording, case)).names))
    scale = np.sqrt(np.diag(before.covariance))[own]
    expected, found = (
        change[own] / scale for change in (size * biases(name, key)[:, column], before.values - after.values)
    )
    assert np.abs(found).max() > 0.2  # of a deviation: something to compare
    if key.startswith("gravity"):  # an axis has no sense
        expected *= np.sign(expected @ found)
    np.testing.assert_allclose(found, expected, rtol=0.03, atol=0.1 * np.abs(found).max())


def test_deviations_count_what_the_case_tolerates_by_its_kinds() -> None:
    of, recording = run("hexapod")
    stated = Tolerances.model_validate({"joints_mm": 0.03, "bars_mm": {"limit": 0.05}, "gain_percent": 0.2})
    plain, counted = (
        estimate_parameters(recording, of.case.model_copy(update={"tolerances": t})) for t in (None, stated)
    )
    budget = counted.quantities["budget"]
    assert "budget" not in plain.quantities
    for name, value in counted.physical.items():
        assert np.sqrt(sum(part**2 for part in budget[name].values())) == pytest.approx(value.reported, rel=1e-6)
        assert value.expanded == 2.0 * value.reported
        assert value.reported >= plain.physical[name].reported * 0.9
        assert abs(value.value - plain.physical[name].value) < 4.0 * value.reported
    mass = budget["m"]
    assert mass["gains"] > mass["drawing"] > 0.0
    assert mass["gains"] > 2.0 * mass["noise"]
    assert any(tells(text, "deviation of m", "gains") for text in counted.notes)


@pytest.mark.repeats
def test_what_residuals_show_of_a_stated_tolerance_is_counted_once() -> None:
    """A gain off by its tolerance is in the residuals: unstated they say so, stated they have nothing to add."""
    of, recording = run("hexapod")
    off = replace(recording, forces=recording.forces * (1.0 + 2e-2 * (np.arange(6) == 2)))
    stated = of.case.model_copy(update={"tolerances": Tolerances.model_validate({"gain_percent": 2.0})})
    small = of.case.model_copy(update={"tolerances": Tolerances.model_validate({"gain_percent": 0.02})})
    without, counted, understated = (estimate_parameters(off, case) for case in (of.case, stated, small))
    assert any(tells(text, "residuals of") for text in (*without.warnings, *without.notes))
    mass = counted.quantities["budget"]["m"]
    more = understated.quantities["budget"]["m"]["seen in residuals"]
    assert mass["seen in residuals"] < 0.1 * more
    assert more > 5.0 * understated.quantities["budget"]["m"]["gains"]


def test_a_limit_is_rectangular_and_a_common_gain_is_all_of_the_mass() -> None:
    of, recording = run("ur10_wrist")
    tolerances = Tolerances.model_validate({"common_gain_percent": {"limit": 1.0}})
    estimate = estimate_parameters(recording, of.case.model_copy(update={"tolerances": tolerances}))
    mass = estimate.physical["m"].value
    assert estimate.quantities["budget"]["m"]["gains"] == pytest.approx(0.01 * mass / np.sqrt(3.0), rel=0.02)


def test_tolerances_of_what_a_machine_does_not_have_are_refused_with_those_that_it_has() -> None:
    for name, key in (("ur10_wrist", "joints_mm"), ("hexapod", "sensor_mm"), ("hexapod", "joint_zeros_deg")):
        data = machine(name).case.model_dump(mode="json", exclude_unset=True) | {"tolerances": {key: 0.1}}
        with pytest.raises(ValueError, match=rf"tolerances\.{key} .* it has .*gain_percent"):
            Case.model_validate(data)


def test_with_a_prior_no_tolerance_is_counted_and_that_is_said() -> None:
    of, recording = run("hexapod")
    case = of.case.model_copy(update={"tolerances": Tolerances.model_validate({"gain_percent": 0.2})})
    known = Method(priors=(Prior("m", of.truth["m"], 0.1),))
    estimate = estimate_parameters(recording, case, how=known)
    assert any(tells(text, "no tolerance of [tolerances] is counted", "with a prior") for text in estimate.notes)
    assert "gains" in estimate.quantities["not_counted"]


@pytest.mark.parametrize(
    "wrong",
    [{"joints_mm": -0.1}, {"gain_percent": {"limit": "0.2"}}, {"gains": 0.2}, {"bars_mm": {"std": 0.1, "limit": 0.2}}],
)
def test_tolerances_that_cannot_be_are_refused_by_key(wrong: dict) -> None:
    (key,) = wrong
    with pytest.raises(ValueError, match=key):
        Tolerances.model_validate(wrong)


@pytest.mark.slow
@seeds(12)
def test_errors_of_machines_off_their_drawing_are_as_large_as_said(seed: int) -> None:
    """Joints and bars 0.03 mm off, gains 0.2 %: over machines, errors over reported deviations are about one."""
    of, draw = machine("hexapod"), np.random.default_rng(seed)
    case = points(of.case)
    data = case.model_dump(mode="json", exclude_unset=True)
    tables = [data["machine"]["base"], data["machine"]["platform"]]
    tables += [data["sensor_frame"]["bars"]["lower"], data["sensor_frame"]["bars"]["upper"]]
    for table in tables:
        table["points_mm"] = (np.array(table["points_mm"]) + draw.normal(0.0, 0.03, (6, 3))).tolist()
    data["tolerances"] = {"joints_mm": 0.03, "bars_mm": 0.03, "gain_percent": 0.2}
    recording = recorded(of, Moves(of, seed, 6.0), seed, STATED, SOUND)
    recording = replace(recording, forces=recording.forces * (1.0 + draw.normal(0.0, 2e-3, 6)))
    estimate = estimate_parameters(recording, Case.model_validate(data))
    errors = [(p.value - of.truth[k]) / p.reported for k, p in estimate.physical.items() if k in of.truth]
    assert np.sqrt(np.mean(np.square(errors))) < 2.0
    assert np.abs(errors).max() < 4.0
