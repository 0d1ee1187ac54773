"""Everything that a user can get wrong ends with exit code 1 and one line: place, value, remedy."""

from pathlib import Path

import pytest

from tests.hexcite.command_line import refused

PLAN = ("plan", "hexapod", "--json")
FOURIER = (*PLAN, "--family", "fourier")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("plan", "hexapo"), ("hexapo", "did you mean 'hexapod'", "ft_wrist, hexapod")),
        (("plan", "ft_wrist"), ("ft_wrist", "machine", "is missing")),
        ((*PLAN, "--family", "magic"), ("'magic'", "choose manual, fourier, ptp, spline")),
        ((*PLAN, "--criterion", "E"), ("'E'", "choose A, D, K, N")),
        ((*FOURIER, "--order", "8"), ("order 8", "to 7")),
        ((*FOURIER, "--period", "0"), ("period 0 ", "choose")),
        ((*FOURIER, "--period", "3", "--duration", "10"), ("10 s", "choose 9 s")),
        ((*PLAN, "--duration", "nan"), ("duration nan",)),
        ((*PLAN, "--starts", "0"), ("0 starts", "choose --starts 1 to 1000")),
        ((*PLAN, "--seed", "-1"), ("seed -1", "choose 0 or more")),
        ((*PLAN, "--model", "11"), ("model 11", "choose 0, 1, 2")),
        (("post", "nowhere"), ("nowhere/plan.json", "cannot be read", "hexcite plan writes it")),
        (("check", "nowhere.ngc", "--case", "hexapod"), ("nowhere.ngc", "cannot be read", "name a program")),
        (("check", ".", "--case", "hexapod"), ("suffix", ".ngc")),
        (("run", "nowhere.ngc", "--case", "hexapod"), ("nowhere.ngc", "cannot be read")),
        (("run", "nowhere.ngc", "--case", "hexapod", "--seed", "-1"), ("seed -1", "choose 0 or more")),
        (("run", "nowhere.ngc", "--case", "ft_wrist"), ("ft_wrist", "simulation", "is missing")),
        (("run", "nowhere.ngc", "--case", "hexapod", "--on", "moon"), ("'moon'", "choose virtual, linuxcnc")),
        (("identify", "nowhere.csv", "--case", "hexapod"), ("nowhere.csv", "cannot be read")),
        (("identify", "nowhere"), ("nowhere", "No such file")),
        (("identify", "."), ("which machine", "--case")),
        (("study", "hexapod", "--spec", "paper", "--workers", "0"), ("0 workers", "choose --workers 1 to 1000")),
        (("demo", "--case", "ft_wrist"), ("ft_wrist", "simulation", "is missing")),
        (("demo", "--starts", "0", "--json"), ("0 starts",)),
        (("case", "check", "nowhere.toml"), ("nowhere.toml", "no such case", "hexapod")),
    ],
)
def test_a_wrong_argument_is_named_with_its_remedy(
    arguments: tuple[str, ...], words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    line = refused(*arguments)
    for word in words:
        assert word in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("radius_mm = 700.0", "radius_mmm = 700.0", ("machine.base.ring.radius_mmm", "did you mean radius_mm")),
        ("radius_mm = 700.0", "radius = 700.0", ("machine.base.ring.radius", "has no unit", "write radius_mm")),
        ("x_mm = [-250.0, 250.0]", "x_mm = [250.0, -250.0]", ("limits.motion.x_mm", "250", "-250", "swap")),
        ("half_angle_deg = 52.0", "half_angle_deg = 20.0", ("sensor_frame.bars", "condition", "must not all")),
        ("radius_mm = 171.0", "radius_mm = 171.0.0", ("is not TOML", "(at line ")),
        ("z_mm = 900.0", "z_mm = 2900.0", ("machine.home", "strut length", "2946", "1460")),
    ],
)
def test_a_mistake_in_a_case_is_named_with_file_key_value_and_remedy(
    old: str, new: str, words: tuple[str, ...], hexapod_file: Path
):
    text = hexapod_file.read_text()
    hexapod_file.write_text(text.replace(old, new, 1).replace("radius_mm = 171.0,", "radius_mm = 146.0,", 1))
    if "52" not in old:  # only the singular frame needs both rings alike
        hexapod_file.write_text(text.replace(old, new, 1))
    assert hexapod_file.read_text() != text
    line = refused("case", "check", hexapod_file, "--json")
    for word in (str(hexapod_file), *words):
        assert word in line


def test_five_base_joints_are_one_too_few(hexapod_file: Path):
    points = ", ".join(f"[{100.0 * k}, {k * k}.0, 0.0]" for k in range(5))
    lines = hexapod_file.read_text().splitlines()
    lines = [f"base = {{ points_mm = [{points}] }}" if line.startswith("base = ") else line for line in lines]
    hexapod_file.write_text("\n".join(lines))
    line = refused("case", "check", hexapod_file)
    for word in (str(hexapod_file), "machine.base.points_mm", "5 entries", "6"):
        assert word in line
