"""Units of recordings: their values by definition, their spellings, and what is not one of a quantity."""

import pytest

from cases.base.unit_names import ANGLES, FORCES, LENGTHS, MOMENTS, QUANTITIES, TIMES, Units, is_unit

# NIST SP 811, appendix B.8, to the digits that it prints
PUBLISHED = [
    (FORCES, "lbf", 4.448222), (FORCES, "kgf", 9.80665), (FORCES, "kp", 9.80665), (FORCES, "ozf", 0.2780139),
    (FORCES, "klbf", 4448.222), (FORCES, "dyn", 1e-5), (FORCES, "daN", 10.0), (FORCES, "MN", 1e6), (FORCES, "mN", 1e-3),
    (FORCES, "cN", 1e-2), (MOMENTS, "cNm", 1e-2), (MOMENTS, "dNm", 0.1), (LENGTHS, "dm", 0.1),
    (MOMENTS, "lbf-in", 0.1129848), (MOMENTS, "lbf-ft", 1.355818), (MOMENTS, "kgf-m", 9.80665),
    (MOMENTS, "ozf-in", 7.061552e-3), (MOMENTS, "Ncm", 1e-2),
    (LENGTHS, "in", 0.0254), (LENGTHS, "mil", 2.54e-5), (LENGTHS, "ft", 0.3048),
    (ANGLES, "arcsec", 4.848137e-6), (ANGLES, "arcmin", 2.908882e-4), (ANGLES, "gon", 1.570796e-2),
    (ANGLES, "deg", 1.745329e-2), (ANGLES, "rev", 6.283185), (TIMES, "min", 60.0), (TIMES, "h", 3600.0),
]  # fmt: skip


@pytest.mark.parametrize(("units", "symbol", "value"), PUBLISHED)
def test_a_unit_has_its_published_value(units: Units, symbol: str, value: float) -> None:
    assert units[symbol] == pytest.approx(value, rel=5e-7)


@pytest.mark.parametrize(
    ("units", "spellings", "symbol"),
    [
        (FORCES, ["lb", "LBF", "lbs", "[lbf]", "(lb)"], "lbf"),
        (FORCES, ["kN", "KN", "kn", " kN "], "kN"),
        (FORCES, ["kg", "KGF"], "kgf"),
        (FORCES, ["µN", "μN", "uN"], "uN"),
        (MOMENTS, ["Nm", "NM", "N m", "N*m", "N·m", "N.m", "N-m"], "Nm"),
        (MOMENTS, ["lbf-in", "lbf*in", "lbf.in", "in-lbf", "in-lb", "inch pounds"], "lbf-in"),
        (MOMENTS, ["ft-lb", "lbf·ft", "ft lbs"], "lbf-ft"),
        (MOMENTS, ["kgf-m", "kg m", "kp.m", "mkp"], "kgf-m"),
        (LENGTHS, ["in", "inch", "Inches", "Zoll"], "in"),
        (LENGTHS, ["µm", "μm", "micron"], "um"),
        (LENGTHS, ["мкм", "Mikrometer"], "um"),
        (ANGLES, ["°", "deg", "Degrees", "Grad"], "deg"),
        (ANGLES, ["″", "arcsec", "Winkelsekunden"], "arcsec"),
        (TIMES, ["s", "sec", "S", "Sekunden"], "s"),
        (TIMES, ["µs", "usec"], "us"),
    ],
)
def test_a_unit_is_known_in_all_its_spellings(units: Units, spellings: list[str], symbol: str) -> None:
    assert {units.symbol(spelling) for spelling in spellings} == {symbol}


def test_capital_letters_count_where_they_decide() -> None:
    assert FORCES.symbol("mN") == "mN"
    assert FORCES.symbol("MN") == "MN"
    assert FORCES.symbol("mn") is None
    assert MOMENTS.symbol("mnm") is None


@pytest.mark.parametrize("text", ["counts", "V", "mV/V", "bar", "digits", "lsb", "m/s^2", "Hz"])
def test_what_recorders_write_may_be_a_unit_of_nothing_that_is_read(text: str) -> None:
    assert is_unit(text)
    assert [units.symbol(text) for units in QUANTITIES] == [None] * len(QUANTITIES)


@pytest.mark.parametrize("text", ["", "left", "Force 1", "3", "1", "x"])
def test_a_word_is_not_a_unit(text: str) -> None:
    assert not is_unit(text)
