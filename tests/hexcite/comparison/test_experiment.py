"""The payload experiment: an ideal machine meets theory exactly, a disturbed one what it was without payload."""

import pytest

from cases.base.errors import HexciteError
from cases.schema import Case
from hexcite.comparison.trials import SHOWN, mounted_weights, trials
from hexcite.comparison.validation import validate
from tests.helpers import ideal
from tests.hexcite.comparison.excitations import CASE, disturbed, moving, standing


@pytest.mark.first(1)
@pytest.mark.parametrize(("method", "exact"), [(standing, 1e-8), (moving, 2e-3)])
def test_an_ideal_machine_meets_theory_and_truth(method, exact: float):
    """Standing exactly, moving as well as the evaluation's filter passes the motion."""
    found = list(trials(method(ideal(CASE)), (0, 5), None))
    assert [s.load for s in found] == pytest.approx([0.0, 5 * 19.93])
    for step in found:
        for name in SHOWN:
            if name in step.theory:
                assert step.deviation(name) == pytest.approx(0.0, abs=exact), name
        assert step.result["m"].value == pytest.approx(31.83 + step.load, rel=exact)
        for name, error in step.errors.items():
            assert error * step.result[name].reported == pytest.approx(0.0, abs=exact), name


def test_theory_follows_what_was_identified_without_payload_and_truth_does_not():
    first, second = disturbed("Q")
    bare, loaded = first.result["m"], second.result["m"]
    assert abs(bare.value - 31.83) > 1e-3
    assert second.theory["m"] == pytest.approx(bare.value + 3 * 19.93, rel=1e-12)
    assert second.errors["m"] == pytest.approx((loaded.value - 31.83 - 3 * 19.93) / loaded.reported, rel=1e-9)
    assert second.theory["f_q0_3"] == first.result["f_q0_3"].value


def test_numbers_of_weights_are_chosen():
    assert mounted_weights(CASE, None) == (0, 1, 2, 3, 4, 5)
    assert mounted_weights(CASE, "0, 3,5") == (0, 3, 5)
    for wrong in ("1,2", "0,6", "0,x", "", "0,3,3", "0,5,3"):
        with pytest.raises(HexciteError, match="how many are mounted"):
            mounted_weights(CASE, wrong)


@pytest.mark.parametrize(
    ("methods", "said"), [(("ptp", "nope"), "'nope' is unknown"), ((), "name each once"), (("ptp", "ptp"), "each once")]
)
def test_methods_that_do_not_exist_are_refused_from_python_too(methods: tuple[str, ...], said: str, hexapod_case: Case):
    with pytest.raises(HexciteError, match=said):
        validate(hexapod_case, methods)
