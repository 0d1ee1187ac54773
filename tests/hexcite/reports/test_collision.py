"""What a check of a case says of the bodies that are kept apart."""

import hexcite as hx
from cases.machine import Tool
from hexcite.reports.collision import HULL, ROUND, SURROUNDINGS, TOOL, kept_apart


def test_each_part_is_named_with_the_shapes_of_its_bodies() -> None:
    case = hx.load_case("ur10_wrist")
    kept = kept_apart(case)
    assert kept is not None
    assert case.chain is not None
    assert [part.part for part in kept.parts] == [SURROUNDINGS, *case.chain.names, TOOL]
    assert kept.boxes == ("floor",)
    bodies = {body["name"]: body["shape"] for part in kept.to_json()["parts"] for body in part["bodies"]}
    assert bodies["upper arm"] == ROUND
    assert HULL not in bodies.values()


def test_what_has_no_body_is_said_and_hulls_are_named() -> None:
    case = hx.load_case("ur10_wrist")
    assert case.machine is not None
    assert case.chain is not None
    corners = tuple((50.0 * x, 50.0 * y, 50.0 * z) for x in (0, 1) for y in (0, 1) for z in (0, 1))
    hull = Tool.model_validate({"name": "gripper", "corners_mm": corners})
    chain = case.chain.model_copy(update={"tool": (hull,), "base": ()})
    changed = case.model_copy(update={"machine": case.machine.model_copy(update={"chain": chain})})
    kept = kept_apart(changed)
    assert kept is not None
    assert kept.to_json()["parts"][-1] == {"part": TOOL, "bodies": [{"name": "gripper", "shape": HULL}]}
    first, bare, searched = repr(kept).split("\n")
    assert "gripper (hull)" in first
    assert bare.endswith("base, wrist_2, wrist_3")  # joints; what stands around need not be there
    assert "capsules" in searched


def test_a_machine_with_struts_has_tools_and_boxes_and_a_sensor_alone_nothing() -> None:
    kept = kept_apart(hx.load_case("hexapod"))
    assert kept is not None
    assert [part.part for part in kept.parts] == [TOOL]
    assert kept_apart(hx.load_case("ft_wrist")) is None
