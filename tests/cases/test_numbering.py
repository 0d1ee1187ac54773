"""Joints that are numbered otherwise than struts are named with the numbering that gives one length; others are not."""

import re
import tomllib

import numpy as np
import pytest

from cases.machine import HexapodMachine
from cases.numbering import of_numbering
from cases.schema import load_case
from cases.tables import built_in_cases
from tests.bench.machines.description import case_tables
from tests.bench.machines.designed import DESIGNED
from tests.bench.machines.drawn import drawn
from tests.helpers import seeds

CENTRES, BETWEEN = [0.0, 120.0, 240.0], [60.0, 180.0, 300.0]


def ring(radius: float, centres: list[float], **angle: float) -> dict[str, object]:
    return {"ring": {"radius_mm": radius, "pair_centres_deg": centres, "z_mm": 0.0, **angle}}


def hexapod(base: object, platform: object, **home: float) -> HexapodMachine:
    stated = {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 800.0, "a_deg": 0.0, "b_deg": 0.0, "c_deg": 0.0, **home}
    return HexapodMachine.model_validate({"base": base, "platform": platform, "home": stated})


def lengths(machine: HexapodMachine) -> np.ndarray:
    """By hand: the platform is not turned."""
    return np.linalg.norm(machine.home.vector[:3] + machine.platform.points - machine.base.points, axis=1) * 1e3


BASE = ring(420.0, CENTRES, included_angle_deg=30.0)
SOUND = hexapod(BASE, ring(190.0, CENTRES, included_angle_deg=80.0))


def test_pairs_of_the_platform_that_sit_close_are_named_with_the_ring_that_is_meant() -> None:
    """The drawing's pairs of 40 degrees at 60, 180, 300: their joints belong to struts of different pairs."""
    wrong = hexapod(BASE, ring(190.0, BETWEEN, included_angle_deg=40.0))
    (doubt,) = of_numbering(wrong)
    assert doubt.code == "joints_numbered"
    written = tomllib.loads("\n".join(re.findall(r"(?:\w+_deg) = (?:\[[^]]*\]|[\d.]+)", doubt)))
    assert written == {"included_angle_deg": 80.0, "pair_centres_deg": CENTRES}
    assert f"{lengths(wrong).min():.2f} to {lengths(wrong).max():.2f}" in doubt
    again = hexapod(BASE, ring(190.0, written.pop("pair_centres_deg"), **written))
    assert np.ptp(lengths(again)) < 1e-6
    assert f"{lengths(again).mean():.2f}" in doubt
    assert "machine.platform.ring.pair_centres_deg" in doubt.keys
    assert not list(of_numbering(again))


@pytest.mark.parametrize("by", [1, 2, 4, 5])
def test_points_in_another_order_are_named_with_the_order_that_is_meant(by: int) -> None:
    points = np.round(np.roll(SOUND.platform.points, by, axis=0) * 1e3, 2)
    (doubt,) = of_numbering(hexapod(BASE, {"points_mm": points.tolist()}))
    found = re.search(r"in the order ([\d, ]+)", doubt)
    assert found is not None
    order = [int(number) - 1 for number in found[1].split(",")]
    assert np.abs(points[order] - SOUND.platform.points * 1e3).max() < 0.01


def test_a_ring_by_six_angles_is_written_as_one() -> None:
    angles = [40.0, 80.0, 160.0, 200.0, 280.0, 320.0]
    (doubt,) = of_numbering(hexapod(BASE, {"ring": {"radius_mm": 190.0, "angles_deg": angles, "z_mm": 0.0}}))
    assert "angles_deg = [320.0, 40.0, 80.0, 160.0, 200.0, 280.0]" in doubt


@pytest.mark.parametrize("name", built_in_cases())
def test_built_in_machines_are_not_accused(name: str) -> None:
    machine = load_case(name).hexapod
    assert machine is None or not list(of_numbering(machine))


@seeds(40, at_once=10)
def test_machines_of_other_makers_are_not_accused(seed: int) -> None:
    tables = case_tables("drawn", drawn(seed))["machine"]
    assert not list(of_numbering(HexapodMachine.model_validate(tables)))


@pytest.mark.parametrize("name", DESIGNED)
def test_designed_machines_are_not_accused(name: str) -> None:
    machine = HexapodMachine.model_validate(case_tables(name, DESIGNED[name])["machine"])
    assert not list(of_numbering(machine))


def test_what_is_not_symmetric_or_stands_aside_is_not_accused() -> None:
    """Lengths differ here without any mistake: joints as built, a home beside the middle, a turned platform."""
    close = ring(190.0, BETWEEN, included_angle_deg=40.0)
    moved = SOUND.platform.points * 1e3 + np.array([9.0, 0.0, 0.0])
    for machine in (
        hexapod(BASE, {"points_mm": moved.tolist()}),
        hexapod(BASE, ring(190.0, CENTRES, included_angle_deg=80.0), x_mm=60.0),
        hexapod(BASE, ring(190.0, CENTRES, included_angle_deg=80.0), c_deg=10.0),
        hexapod(BASE, close, a_deg=5.0),
        SOUND,
    ):
        assert not list(of_numbering(machine))
