"""Exchanged cables are named with what they leave, with the remedy, and never on the wrong side."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from cases.recording_format import Drives
from cases.schema import Case, load_case
from identification.findings.causes.channels import order_words, orders
from identification.findings.causes.search import search
from identification.identify import estimate_parameters
from identification.recording.recording import read
from identification.simulate import simulate_recording
from tests.helpers import HOME, few, one_line, seeds, tells
from tests.identification.findings.test_findings import CASE, MOTIONS, run
from tests.identification.moving_run import MODEL
from tests.simulated_machine import simulate_standstills

ORDERS = list(orders(6))
NUMBERS = [str(k) for k in range(1, 7)]


def recorded_in(order: tuple[int, ...], columns: np.ndarray) -> np.ndarray:
    """Columns as a recorder writes them whose cables are in this order: what belongs to k stands in order[k]."""
    return columns[:, np.argsort(order)]


def test_all_exchanges_of_pairs_are_tried() -> None:
    assert len(ORDERS) == 75 + 4  # involutions of six without the identity, and shifts
    assert len({*ORDERS}) == len(ORDERS)


@pytest.mark.first(1)
@pytest.mark.parametrize("which", few(75, 0, 30, 74))
@pytest.mark.parametrize("side", ["drives", "forces"])
def test_an_exchange_is_named_with_its_residuals_and_columns(side: str, which: int) -> None:
    order, whole = ORDERS[which], run(which)
    mixed = replace(whole, **{side: recorded_in(order, getattr(whole, side))})
    with pytest.raises(IdentificationError, match=r"residuals are (\d\S* times smaller|small) \(") as caught:
        estimate_parameters(mixed, CASE)
    line = one_line(caught.value)
    assert order_words(order, "struts" if side == "drives" else "force channels", NUMBERS) in line
    if " or " not in line.split(";")[0]:  # a symmetric machine leaves some to either side
        for k, place in enumerate(order):
            ours, theirs = (
                (f"l{k + 1}_mm", f"l{place + 1}_mm") if side == "drives" else (f"f{k + 1}_N", f"f{place + 1}_N")
            )
            assert (f'{ours} = "{theirs}"' in line) == (k != place)


@pytest.mark.slow
@pytest.mark.parametrize("which", range(len(ORDERS)))
@pytest.mark.parametrize("side", ["drives", "forces"])
def test_every_exchange_is_named(side: str, which: int) -> None:
    test_an_exchange_is_named_with_its_residuals_and_columns(side, which)


@pytest.mark.parametrize("signs", few("+-++-+", "-+++++", "-+-+-+", "+----+"))
def test_turned_signs_of_channels_are_named(signs: str) -> None:
    whole, turned = run(1), tuple(int(f"{sign}1") for sign in signs)
    with pytest.raises(IdentificationError, match="turned: then residuals") as caught:
        estimate_parameters(replace(whole, forces=whole.forces * np.array(turned)), CASE)
    those = ", ".join(str(k + 1) for k in range(6) if turned[k] < 0)
    assert f"force channels {those} are turned" in str(caught.value)


@pytest.mark.slow
def test_all_signs_turned_at_once_are_named_with_the_remedy() -> None:
    """The residuals are those of the right signs; only the mass tells."""
    whole = run(1)
    with pytest.raises(IdentificationError, match=r"force channels 1, 2, 3, 4, 5, 6 are turned") as caught:
        estimate_parameters(replace(whole, forces=-whole.forces), CASE)
    assert tells(one_line(caught.value), 'sensor_frame.bars.sense = "tension"')


@pytest.mark.slow
@pytest.mark.parametrize("channel", few(4, 0, 1, 2, 3, 5))
def test_a_turned_sign_of_a_force_torque_sensor_does_not_pass_unnoticed(channel: int) -> None:
    """Moments of inertia take up much of a turned moment; but no body has such ones."""
    data = CASE.model_dump(mode="json", exclude_unset=True)
    data |= {"setup": "R", "sensor_frame": {"transducer": {"sense": "load_on_sensor"}}}
    data["sensors"] |= {"weights": "per_unit"}
    case = Case.model_validate(data)
    whole = simulate_recording(case, MOTIONS[0], np.array([[0.2, 2.8]]), 0, "run.csv")
    assert estimate_parameters(whole, case).warnings == ()
    turned = replace(whole, forces=whole.forces * np.where(np.arange(6) == channel, -1.0, 1.0))
    try:
        (said,) = (warning for warning in estimate_parameters(turned, case).warnings if "no body" in warning)
    except IdentificationError as error:
        said = str(error)
    assert "sign" in said


@seeds(2)
def test_nothing_is_blamed_on_a_sound_run(seed: int) -> None:
    found = search(run(seed), CASE, MODEL)
    assert found is not None
    assert found.sound


def test_silent_sensors_are_not_blamed_on_their_cables() -> None:
    whole = run(0)
    with pytest.raises(IdentificationError, match=r"channel 1 reads 0\b.*every sample"):
        estimate_parameters(replace(whole, forces=np.zeros_like(whole.forces)), CASE)


@pytest.mark.slow
def test_exchanged_drives_are_mended_where_drives_are_named() -> None:
    """Struts that are computed from drives have no columns of their own."""
    drives = Drives(sign=(1.0,) * 6, offset_mm=(0.0,) * 6, order=(6, 5, 4, 3, 2, 1))
    case = CASE.model_copy(update={"recording": CASE.recording.model_copy(update={"drives": drives})})
    whole = run(0)
    mixed = replace(whole, drives=whole.drives[:, [1, 0, 2, 3, 4, 5]])
    with pytest.raises(IdentificationError, match="struts 1 and 2 are exchanged: then residuals") as caught:
        estimate_parameters(mixed, case)
    assert str(caught.value).endswith("recording.drives.order = [5, 6, 4, 3, 2, 1]")


def test_standstills_tell_exchanged_struts_too() -> None:
    draw = np.random.default_rng(0)
    away = draw.uniform(-1.0, 1.0, (40, 6)) * np.r_[[0.12] * 3, [0.15] * 3]
    still = simulate_standstills(CASE, HOME + away, 1000, 0)
    with pytest.raises(IdentificationError, match=r"struts 3 and 4\b.*exchanged"):
        estimate_parameters(replace(still, drives=still.drives[:, [0, 1, 3, 2, 4, 5]]), CASE, 5)


def standing_on_a_wrist(file: Path, scale: np.ndarray) -> Path:
    """Standstills of a body of 1.7 kg on a wrist's sensor, with channels as a recorder scales them."""
    case, draw = load_case("ft_wrist"), np.random.default_rng(0)
    turns, centre = Rotation.random(20, random_state=0), np.array([0.01, -0.02, 0.06])
    weights = 1.7 * turns.inv().apply(case.gravity.copy())
    noise = draw.normal(size=(20, 6)) * np.repeat([0.05, 2e-3], 3)
    wrenches = np.column_stack([weights, np.cross(centre, weights)]) + noise
    rows = np.column_stack([turns.as_matrix().reshape(-1, 9), wrenches * scale])
    names = [*(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)), "fx", "fy", "fz", "tx", "ty", "tz"]
    np.savetxt(file, rows, delimiter=",", header=",".join(names), comments="")
    return file


@pytest.mark.parametrize("channel", few(*range(6), kept=2))
def test_the_turned_sign_of_one_channel_is_named_alone_by_standstills_of_a_wrist(channel: int, tmp_path: Path) -> None:
    """All moments turned, with the centre of gravity, leave the same; a moment alone does not show in the newtons."""
    case = load_case("ft_wrist")
    file = standing_on_a_wrist(tmp_path / "run.csv", np.where(np.arange(6) == channel, -1.0, 1.0))
    with pytest.raises(IdentificationError, match=rf"force channels {channel + 1} are turned"):
        estimate_parameters(read(file, case), case)


def test_moments_in_newton_millimetres_are_noticed(tmp_path: Path) -> None:
    case = load_case("ft_wrist")
    sound, wrong = (standing_on_a_wrist(tmp_path / f"{k}.csv", np.repeat([1.0, k], 3)) for k in (1.0, 1e3))
    assert estimate_parameters(read(sound, case), case).warnings == ()
    (said,) = estimate_parameters(read(wrong, case), case).warnings
    assert "recording.units.moments = 'Nmm'" in said
