"""What a doubt proposes to write mends what it is about; what has no cure by keys proposes nothing."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.base.places import place_of, placed, places_of
from cases.editing import at, case_of_text
from cases.schema import Case
from cases.tables import built_in_cases
from hexcite.page.keys import leaves

FILE = Path("mill", "case.toml")


def case_with(like: str, before: str, after: str) -> Case:
    """A built-in case with another text in one place, under another name."""
    text = built_in_cases()[like].read_text().replace(f'name = "{like}"', 'name = "mill"', 1)
    assert text.count(before) >= 1
    return case_of_text(text.replace(before, after, 1), FILE)


@pytest.mark.parametrize(
    ("like", "before", "after"),
    [
        ("hexapod", "radius_mm = 250.0", "radius_mm = 0.25"),
        ("hexapod", "z_mm = 900.0", "z_mm = 0.9"),
        ("hexapod", "platform_joint_angle_deg = 80.0", "platform_joint_angle_deg = 1.396"),
        ("ur10_wrist", "position_deg = [-360.0, 360.0]", "position_deg = [-20600.0, 20600.0]"),
    ],
)
def test_a_unit_that_was_mistaken_is_mended_by_what_is_proposed(like: str, before: str, after: str) -> None:
    doubts = case_with(like, before, after).doubts
    writes = [write for doubt in doubts for write in doubt.writes]
    right: dict[Any, Any] = dict(leaves((), tomllib.loads(built_in_cases()[like].read_text())))
    assert writes
    for write in writes:
        np.testing.assert_allclose(write.value, right[write.place], rtol=0.01)
        assert write.place in {place for doubt in doubts for place in places_of(doubt)}


def test_a_doubt_without_a_cure_names_places_and_writes_nothing() -> None:
    (doubt,) = case_with("hexapod", "strut_velocity_m_s = ", "strut_velocity_m_s = 0.00001 # ").doubts
    assert not doubt.writes
    assert ("limits", "motion", "strut_velocity_m_s") in places_of(doubt)


def test_joints_in_the_order_of_the_drawing_are_mended_by_what_is_proposed() -> None:
    ring = "radius_mm = 250.0, half_angle_deg = 48.0, pair_centres_deg = [90.0, 210.0, 330.0]"
    drawn = "radius_mm = 250.0, half_angle_deg = 20.0, pair_centres_deg = [150.0, 270.0, 30.0]"
    (doubt,) = case_with("hexapod", ring, drawn).doubts
    text = built_in_cases()["hexapod"].read_text().replace(ring, drawn)
    ring_of = at(tomllib.loads(text), ("machine", "platform", "ring"))
    mended = ring_of | {write.place[-1]: write.value for write in doubt.writes}
    assert doubt.writes
    new = ", ".join(f"{key} = {value}" for key, value in mended.items() if key != "z_mm")
    assert not case_with("hexapod", ring, new).doubts


@pytest.mark.parametrize("key", ["machine.home.z_mm", "limits.motion.joints[2].velocity_deg_s"])
def test_a_key_in_words_is_a_place_and_back(key: str) -> None:
    assert placed(place_of(key)) == key


@pytest.mark.parametrize(
    ("before", "after", "key", "value"),
    [
        ("radius_mm = 700.0", "radius_mm = 0.7", "machine.base.ring.radius_mm", "700"),
        ("radius_mm = 700.0", "radius_mm = 0.26", "machine.base.ring.radius_mm", "260"),
    ],
)
def test_a_radius_in_metres_is_named_where_the_machine_is_singular(
    before: str, after: str, key: str, value: str
) -> None:
    with pytest.raises(CaseError) as refused:
        case_with("hexapod", before, after)
    cure = refused.value.sentences[0]
    assert f"{key} = " in cure
    assert f"write {value}" in cure


def test_a_platform_that_hangs_below_its_base_is_remarked_and_no_contradiction() -> None:
    upright, hanging = case_with("hexapod", "= 900.0", "= 900.0"), case_with("hexapod", "z_mm = 900.0", "z_mm = -900.0")
    assert upright.remarks == ()
    assert [remark.code for remark in hanging.remarks] == ["platform_below_base"]
    assert hanging.doubts == ()
    turned = case_with("hexapod", "gravity_m_s2 = [0.0, 0.0, -9.81]", "gravity_m_s2 = [0.0, 0.0, 9.81]")
    assert {remark.code for remark in turned.remarks} == {"gravity_points_up", "platform_below_base"}
