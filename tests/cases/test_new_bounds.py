"""A case that `case new` began has what CAD and data sheets say as comments, which are a case where they are keys."""

from pathlib import Path

import pytest

from cases.scaffold import new_case
from cases.schema import load_case


@pytest.mark.parametrize("like", ["hexapod", "ur10_wrist", "ft_wrist"])
def test_bounds_that_stand_there_as_comments_are_a_table(like: str, tmp_path: Path) -> None:
    file = new_case("mine", like, tmp_path / "mine")
    text = file.read_text()
    begins = text.index("# [bounds]")
    keys = [
        line.removeprefix("# ") for line in text[begins:].splitlines() if "[" in line and not line.startswith("# Box")
    ]
    file.write_text(text[:begins] + "\n".join(keys) + "\n")
    case = load_case(file)
    assert case.bounds is not None
    assert case.bounds.mass_kg is not None
    if case.nominal is not None:
        assert case.bounds.mass_kg[0] < case.nominal.mass_kg < case.bounds.mass_kg[1]
        low, high = case.bounds.centre_of_gravity_mm.ends
        assert ((low < case.nominal.centre_of_gravity) & (case.nominal.centre_of_gravity < high)).all()


def test_a_frame_that_stands_has_no_body_to_bound(tmp_path: Path) -> None:
    assert "[bounds]" not in new_case("mine", "clamping_table", tmp_path / "mine").read_text()
