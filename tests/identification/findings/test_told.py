"""Sizes that a case tolerates are estimated where a run tells them, and then parameters are those of the machine."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.units import DEG
from cases.schema import Case
from cases.tolerances import Tolerances
from identification.findings.off_case import edited, sizes_named
from identification.identify import estimate_parameters, identify
from identification.recording.recording import Recording
from identification.results.estimate import Estimate
from identification.results.force import force
from identification.results.result import Result
from tests.damaged.runs import STATED, Machine, Moves, machine, recorded
from tests.helpers import tells

TURN = np.array([0.8, -1.2, 2.5])  # [deg]


@cache
def run() -> tuple[Machine, Recording]:
    of = machine("ur10_wrist")
    return of, recorded(of, Moves(of, 3, 8.0), 3, STATED)


def tolerating(case: Case, **stated: float) -> Case:
    return case.model_copy(update={"tolerances": Tolerances.model_validate(stated)})


def turned_case() -> Case:
    """The case without the turn that the machine's sensor has."""
    of, _ = run()
    return edited(of.case, {"sensor_deg": Rotation.from_rotvec(TURN * DEG).inv().as_rotvec()})


@cache
def turned() -> Estimate:
    return estimate_parameters(run()[1], tolerating(turned_case(), sensor_deg=1.5))


def worst(estimate: Estimate) -> float:
    truth = run()[0].truth
    return max(abs(p.value - truth[k]) / p.reported for k, p in estimate.physical.items() if k in truth)


def test_a_turned_sensor_is_told_with_its_deviation_and_harms_no_parameter() -> None:
    estimate, (of, recording) = turned(), run()
    told = estimate.quantities["told"]
    assert [entry["key"] for entry in told] == ["sensor_deg"] * 3
    for entry, size in zip(told, TURN * DEG, strict=True):
        assert abs(entry["value"] - size) < 3.5 * entry["std"] < 3.5 * 0.1 * DEG
    assert worst(estimate) < 4.0
    right = estimate_parameters(recording, of.case)
    for name, value in estimate.physical.items():  # as well known as with the right case, but for what turns
        assert abs(value.value - right.physical[name].value) < 3.0 * value.reported
        assert value.reported < 3.0 * right.physical[name].reported
    assert not any("residuals of" in text for text in estimate.warnings)


def test_what_is_told_is_said_with_the_key_that_mends_it() -> None:
    text = next(text for text in turned().notes if "turned on its flange" in text)
    assert "about its z" in text
    assert "machine.chain.sensor.rpy_deg = [" in text
    written = [float(number) for number in text.partition("rpy_deg = [")[2].partition("]")[0].split(",")]
    sensor = turned_case().chain.sensor.model_copy(update={"rpy_deg": tuple(written)})
    off = Rotation.from_euler("xyz", run()[0].case.chain.sensor.rpy).inv() * Rotation.from_euler("xyz", sensor.rpy)
    assert np.degrees(off.magnitude()) < 0.1
    (remedy,) = next(finding for finding in turned().findings if "turned on its flange" in finding.sentence).remedies
    assert [(key.place, key.value) for key in remedy.keys] == [(("machine", "chain", "sensor", "rpy_deg"), written)]


def test_a_case_that_cannot_be_right_at_its_tolerance_names_the_part() -> None:
    estimate = estimate_parameters(run()[1], tolerating(turned_case(), sensor_deg=0.1))
    assert any(
        tells(text, "cannot be right", "sensor is turned", "about its z", "sensor_deg") for text in estimate.warnings
    )
    entry = estimate.quantities["impossible"]
    assert (entry["key"], entry["tried"]) == ("sensor_deg", 3)
    assert abs(entry["value"] - TURN[2] * DEG) < 3.5 * np.hypot(entry["std"], 0.1 * DEG) < TURN[2] * DEG
    assert entry["chance"] < 1e-3
    assert "impossible" not in turned().quantities


@pytest.mark.repeats
def test_a_tilted_base_is_told_by_gravity() -> None:
    of, recording = run()
    lean = np.array([0.4, -0.25]) * DEG
    estimate = estimate_parameters(recording, tolerating(edited(of.case, {"gravity_deg": -lean}), gravity_deg=0.3))
    told = estimate.quantities["told"]
    for entry, size in zip(told, lean, strict=True):
        assert entry["key"] == "gravity_deg"
        assert abs(entry["value"] - size) < 3.5 * entry["std"]
    assert worst(estimate) < 4.0


def test_least_squares_alone_are_kept_where_sizes_make_nothing_better() -> None:
    of, recording = run()
    plain, counted = (estimate_parameters(recording, case) for case in (of.case, tolerating(of.case, clock_ppm=1.0)))
    assert np.array_equal(plain.fit.values, counted.fit.values)
    assert "told" not in counted.quantities


def test_budgets_of_estimated_sizes_add_up_to_the_deviations() -> None:
    estimate = turned()
    for name, parts in estimate.quantities["budget"].items():
        assert np.sqrt(sum(part**2 for part in parts.values())) == pytest.approx(
            estimate.physical[name].reported, rel=1e-6
        )
    assert estimate.quantities["budget"]["xC"]["alignment"] < estimate.physical["xC"].reported


@pytest.mark.repeats
def test_forces_of_a_saved_result_are_those_of_the_machine_as_told(tmp_path: Path) -> None:
    of, recording = run()
    identify(recording, tolerating(turned_case(), sensor_deg=1.5)).save(tmp_path / "result")
    found = Result.load(tmp_path / "result", tolerating(turned_case(), sensor_deg=1.5))
    off, right = (force(recording, result).residuals for result in (found, identify(recording, of.case)))
    assert np.sqrt(np.mean(off**2, axis=0)) == pytest.approx(np.sqrt(np.mean(right**2, axis=0)), rel=0.03)
    assert found.sizes["sensor_deg"] == pytest.approx(TURN * DEG, abs=0.2 * DEG)
    assert found.case.hash == tolerating(turned_case(), sensor_deg=1.5).hash


@pytest.mark.parametrize("name", ["hexapod", "ur10_wrist"])
def test_every_size_of_a_tolerance_has_a_name(name: str) -> None:
    case = machine(name).case
    for key in case.tolerable:
        words = [size.words for size in sizes_named(case, key)]
        assert len(words) == len(set(words)) > 0 or key.startswith(("joint_zeros", "common"))
