"""A new case is a valid one under another name, with the template's numbers, and never takes the place of one."""

from itertools import pairwise
from pathlib import Path

import pytest

from cases.base.errors import CaseError, FileProblem
from cases.scaffold import new_case
from cases.schema import NO_TITLE, load_case
from tests.helpers import one_line


@pytest.mark.parametrize("like", ["hexapod", "ft_wrist"])
def test_a_new_case_is_its_template_under_another_name(like: str, tmp_path: Path) -> None:
    file = new_case("mill", like, tmp_path / "mill")
    new, old = load_case(str(tmp_path / "mill")), load_case(like)
    assert (new.name, new.template) == ("mill", like)
    said, template = new.model_dump(), old.model_dump()
    for words in (said, template):
        del words["name"], words["title"], words["template"]
        for sourced in (words["simulation"], (words["simulation"] or {}).get("disturbances"), words["payloads"]):
            (sourced or {}).pop("source", None)
    if template["nominal"] is not None:  # what is rehearsed is the machine that is described
        template["simulation"]["parameters"]["body"] = template["nominal"]
    assert said == template
    text = file.read_text()
    assert old.title not in text
    assert "Table" not in text  # sources of the template's numbers are not those of the new machine's
    lines = text.splitlines()
    advised = [lines[k - 1] for k, line in enumerate(lines) if line in ("[sensors]", "[recording]")]
    assert "pose_error_N" in advised[0]
    assert "units" in advised[1]


def test_each_key_of_a_controller_is_explained_above_it(tmp_path: Path) -> None:
    lines = new_case("mill", "hexapod", tmp_path / "mill").read_text().splitlines()
    above = {line.split(" = ")[0]: before for before, line in pairwise(lines)}
    assert above["transformation"].endswith("the builder's own name.")
    assert above["transformation_off"] == "# What switches it off."
    assert above["safe_feed_mm_min"].startswith("# Feed of the first move")
    assert above["kinematic_id"].startswith("# Of the hexapod's transformation")
    assert max(map(len, (line for line in lines if line.startswith("#")))) <= 120
    assert not any("which 20 of the 49" in line for line in lines)  # about the built-in case's source


def test_a_case_that_is_there_is_left_alone(tmp_path: Path) -> None:
    file = new_case("mill", "hexapod", tmp_path)
    file.write_text("mine")
    with pytest.raises(FileProblem, match="exists; choose another folder"):
        new_case("mill", "hexapod", tmp_path)
    assert file.read_text() == "mine"


@pytest.mark.parametrize("name", ["Mill", "", "1st", "mill 2", "../mill", "hexapod"])
def test_a_name_that_no_case_can_have(name: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="name of a") as caught:
        new_case(name, "hexapod", tmp_path / "x")
    one_line(caught.value)
    assert not (tmp_path / "x").exists()


def test_an_unknown_template(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no such case"):
        new_case("mill", "lathe", tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_pages_of_a_case_without_a_title_have_its_name(tmp_path: Path) -> None:
    file = new_case("mill", folder=tmp_path / "mill")
    assert load_case(str(file)).heading == "mill"
    file.write_text(file.read_text().replace(f'title = "{NO_TITLE}"', 'title = "Mill 7"'))
    assert load_case(str(file)).heading == "Mill 7"


def test_the_simulated_body_is_the_nominal_one_unless_another_is_stated(tmp_path: Path) -> None:
    file = new_case("mill", "hexapod", tmp_path / "mill")
    text = file.read_text().replace("mass_kg = 33.0", "mass_kg = 12.5")
    file.write_text(text)
    case = load_case(str(file))
    assert case.nominal is not None
    assert case.nominal.mass_kg == 12.5
    assert case.need_simulation("a test").parameters.body == case.nominal
    assert not [doubt for doubt in case.doubts if any("simulation.parameters.body" in key for key in doubt.keys)]
    file.write_text(f"{text}\n[simulation.parameters.body]\nmass_kg = 13.0\n")
    body = load_case(str(file)).need_simulation("a test").parameters.body
    assert (body.mass_kg, body.inertia_kg_m2) == (13.0, case.nominal.inertia_kg_m2)
    file.write_text(text.replace("mass_kg = 12.5", "mass_kg = -12.5"))
    with pytest.raises(CaseError) as refused:
        load_case(str(file))
    assert "nominal.mass_kg" in str(refused.value)
    assert "simulation" not in str(refused.value)


def test_a_case_of_ones_own_is_copied_with_its_comments(tmp_path: Path) -> None:
    first = new_case("mill", "hexapod", tmp_path / "mill")
    first.write_text(first.read_text().replace("radius_mm = 700.0", "radius_mm = 702.5") + "# checked on Monday\n")
    for like in (first, first.parent):
        copy = new_case(f"mill_{len(str(like))}", str(like), tmp_path / f"copy{len(str(like))}")
        changed = [(a, b) for a, b in zip(first.read_text().splitlines(), copy.read_text().splitlines(), strict=True)]
        assert [b for a, b in changed if a != b] == [f'name = "mill_{len(str(like))}"']
        assert load_case(str(copy)).name == f"mill_{len(str(like))}"


def test_a_copy_gets_its_name_wherever_that_is_written(tmp_path: Path) -> None:
    """Not a joint, whose name stands in a line of its own further below."""
    first = new_case("arm", "ur10_wrist", tmp_path / "arm")
    first.write_text(first.read_text().replace('name = "arm"', '"name" = "arm"', 1))
    joints = load_case(str(first)).need_chain("a test")[0].joints
    copy = load_case(str(new_case("arm_2", str(first), tmp_path / "copy")))
    assert copy.name == "arm_2"
    assert [joint.name for joint in copy.need_chain("a test")[0].joints] == [joint.name for joint in joints]
