"""Gravity of a case is that of the Earth; a unit or a typing error is refused with what is meant."""

import pytest
from pydantic import ValidationError

from cases.schema import Case, load_case

CASE = load_case("hexapod").model_dump()


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.7804), (0.0, 9.8322, 0.0), (-5.664, 5.664, -5.664)])
def test_gravity_of_the_equator_and_the_poles_in_any_direction_is_accepted(gravity: tuple[float, ...]) -> None:
    assert Case.model_validate(CASE | {"gravity_m_s2": gravity}).gravity == pytest.approx(gravity)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (0.0, 0.0, -9810.0), (0.0, 0.0, -1.0), (0.0, 0.0, -8.91)])
def test_other_lengths_are_refused(gravity: tuple[float, ...]) -> None:
    with pytest.raises(ValidationError, match=r"9\.7 to 9\.9.*give"):
        Case.model_validate(CASE | {"gravity_m_s2": gravity})


def test_what_follows_from_a_value_follows_it_into_a_copy() -> None:
    """Derived arrays and the fingerprint are computed once a case, and anew for a copy with other values."""
    case = load_case("hexapod")
    assert case.gravity[2] == -9.81
    turned = case.model_copy(update={"gravity_m_s2": (0.0, 0.0, 9.81)})
    assert turned.gravity[2] == 9.81
    assert turned.hash == Case.model_validate(CASE | {"gravity_m_s2": (0.0, 0.0, 9.81)}).hash != case.hash
