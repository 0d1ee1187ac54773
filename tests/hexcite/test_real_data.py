"""`hexcite identify` on recordings of a real force/torque sensor, against what others found in them."""

import json
from pathlib import Path

import pytest

from tests.hexcite.command_line import Answer, call, skip_without

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "ft_wrist_ntnu"
STATIC = FOLDER / "0-calibration_fts-accel.csv"
OFFSETS = [9.0765, -1.0181, 9.9848, 0.4325, -0.6916, -0.1570]


@pytest.fixture(scope="module")
def static(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The result of the static set."""
    folder = tmp_path_factory.mktemp("static") / "result"
    call("identify", STATIC, "--case", "ft_wrist", "-o", folder, "--json").json()
    return folder


def identified(names: tuple[str, ...], *words: object) -> Answer:
    """The answer about the moving run, from these of its files."""
    return call("identify", *(FOLDER / f"1-baseline_{name}.csv" for name in names), "--case", "ft_wrist", *words)


@skip_without(STATIC)
def test_the_static_set_gives_mass_centre_of_gravity_and_offsets_of_the_literature(static: Path):
    answer = json.loads((static / "result.json").read_text(encoding="utf-8"))
    assert (answer["model"], answer["weights"], answer["rank"]) == (0, "per_unit", 10)
    p = answer["parameters"]
    expected = {"m": (0.932, 0.004), "zC": (0.0439, 0.0005), "xC": (0.0003, 0.0005), "yC": (0.0001, 0.0005)}
    for name, (value, tolerance) in expected.items():
        assert p[name]["value"] == pytest.approx(value, abs=tolerance), name
        assert p[name]["std"] < tolerance
    for k, offset in enumerate(OFFSETS, start=1):
        found = p[f"f_q0_{k}"]
        assert abs(found["value"] - offset) < 2.1 * max(found["std"], found["std_robust"]), k
    assert answer["residual_rms"][:3] == pytest.approx([0.1] * 3, abs=0.1)


@skip_without(STATIC)
def test_a_model_that_standstills_cannot_excite_is_refused(tmp_path: Path):
    answer = call("identify", STATIC, "--case", "ft_wrist", "--model", "6", "-o", tmp_path / "r")
    assert "inertia" in answer.refusal()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.first(1)
@skip_without(STATIC)
@pytest.mark.parametrize("order", [("accel", "wrench", "orientations"), ("orientations", "accel", "wrench")])
def test_a_moving_run_of_three_clocks_gives_the_mass_and_the_delay_of_the_accelerometer(
    order: tuple[str, ...], tmp_path: Path
):
    """Others find 0.923 to 0.940 kg by treatment, 5.8 to 6.5 ms of delay where misalignment is estimated too."""
    answer = identified(order, "-o", tmp_path / "r", "--json").json()
    mass = answer["parameters"]["m"]
    assert abs(mass["value"] - 0.932) < 3.0 * max(mass["std"], mass["std_robust"])
    assert answer["parameters"]["zC"]["value"] == pytest.approx(0.0439, abs=0.0005)
    assert -6.6e-3 < answer["delay_s"]["value"] < -4.9e-3


@skip_without(STATIC)
def test_a_moving_run_without_accelerometer_is_refused(tmp_path: Path):
    answer = identified(("wrench", "orientations"), "-o", tmp_path / "r")
    assert "rotation matrices and an accelerometer" in answer.refusal()
