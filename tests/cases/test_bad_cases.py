"""Each mistake in a case file is answered with one line: file, key, value, remedy."""

import os
import re
from pathlib import Path

import pytest

from cases.base.errors import MOST_PROBLEMS, CaseError
from cases.schema import load_case
from cases.tables import built_in_cases
from tests.cases.editing import HEXAPOD, edited
from tests.helpers import one_line, refused_at

RING, BOX, FRAME = "machine.base.ring", "limits.motion", "sensor_frame.bars"
BASE = re.search(r"base = \{ (ring = \{.*?\}) \}", HEXAPOD)[1]
LOWER, UPPER = (re.search(rf"{side} = (.*)", HEXAPOD)[0] for side in ("lower", "upper"))
HIGHER = LOWER.replace("lower", "upper").replace("z_mm = 9", "z_mm = 99")
GRAVITY, INERTIA = "gravity_m_s2 = [0.0, 0.0, -9.81]", "[1.65, 0.0, 0.0, 1.65, 0.0, 1.51]"


def points(count: int) -> str:
    return "points_mm = [" + ", ".join(f"[{100 * k}.0, {k * k}.0, 0.0]" for k in range(count)) + "]"


# mistake -> what is replaced by what, key, what the message says
LENGTH = "pose_error_length_mm = 28.0"
MISTAKES: dict[str, tuple[str, str, str, str]] = {
    "unknown key": ("mass_kg = 33.0", "mas_kg = 33.0", "nominal.mas_kg", "unknown key; did you mean mass_kg"),
    "unknown table": ("[machine]", "[machin]", "machin", "unknown key; did you mean machine"),
    "table without its s": ("[sensors]", "[sensor]", "sensor", "did you mean sensors"),
    "unknown nested table": ("[limits.motion]", "[limits.moton]", "limits.moton", "did you mean motion"),
    "no unit": ("radius_mm = 700.0", "radius = 700.0", f"{RING}.radius", "has no unit.*write radius_mm"),
    "no unit in gravity": (GRAVITY, "gravity = [0.0, 0.0, -9.81]", "gravity", "has no unit.*write gravity_m_s2"),
    "another unit": ("radius_mm = 700.0", "radius_cm = 70.0", f"{RING}.radius_cm", "unit.*write radius_mm"),
    "another unit of rates": ("velocity_mm_s =", "velocity_m_s =", "limits.motion.velocity_m_s", "velocity_mm_s"),
    "missing key": ("mass_kg = 33.0\n", "", "nominal.mass_kg", "is missing; add it"),
    "no table": ("home = {", "home = 900.0 #", "machine.home", "900.0: is not a table; write .* x_mm = .., y_mm"),
    "missing component": (GRAVITY, "gravity_m_s2 = [0.0, -9.81]", "gravity_m_s2[3]", "is missing; add it"),
    "one component too many": (GRAVITY, "gravity_m_s2 = [0.0, 0.0, -9.81, 0.0]", "gravity_m_s2", "4 .* at most 3"),
    "number for a vector": (GRAVITY, "gravity_m_s2 = -9.81", "gravity_m_s2", "-9.81: is not a list; write "),
    "text for a number": ("radius_mm = 700.0", 'radius_mm = "700"', f"{RING}.radius_mm", "'700': .* number"),
    "true for a number": ("radius_mm = 700.0", "radius_mm = true", f"{RING}.radius_mm", "True: .* number"),
    "NaN": ("radius_mm = 700.0", "radius_mm = nan", f"{RING}.radius_mm", "nan: .*finite number"),
    "infinity": ("radius_mm = 700.0", "radius_mm = inf", f"{RING}.radius_mm", "inf: .*finite number"),
    "ripple beyond the step of simulated runs": (
        "strut_velocity_band_Hz = 60.0", "strut_velocity_band_Hz = 500.0",
        "simulation.disturbances.strut_velocity_band_Hz",
        "less than or equal to 400",
    ),
    "beyond any machine": ("radius_mm = 700.0", "radius_mm = 1e308", f"{RING}.radius_mm", "less than or equal to 10"),
    "strut without a length": (
        "strut_length_mm = [650.0, 1550.0]", "strut_length_mm = [-1550.0, -650.0]", "workspace",
        "strut_length_mm ends at -650 mm",
    ),
    "negative radius": ("radius_mm = 700.0", "radius_mm = -7.0", f"{RING}.radius_mm", "-7.0: .*greater than 0"),
    "negative tolerance": (
        "[machine]",
        "[tolerances]\ngain_percent = -0.1\n[machine]",
        "tolerances.gain_percent",
        "-0.1: .*greater than or equal to 0",
    ),
    "text for a tolerance": (
        "[machine]",
        "[tolerances]\njoints_mm = '0.03'\n[machine]",
        "tolerances.joints_mm",
        "'0.03': is not a number",
    ),
    "tolerance that is not finite": (
        "[machine]",
        "[tolerances]\njoints_mm = inf\n[machine]",
        "tolerances.joints_mm",
        "inf: .*finite number",
    ),
    "tolerance beyond any machine": (
        "[machine]",
        "[tolerances]\njoints_mm = 1e300\n[machine]",
        "tolerances.joints_mm",
        "less than or equal to 10",
    ),
    "negative limit of a tolerance": (
        "[machine]",
        "[tolerances]\njoints_mm = { limit = -1 }\n[machine]",
        "tolerances.joints_mm.limit",
        "-1: .*greater than or equal to 0",
    ),
    "five joints": (BASE, points(5), "machine.base.points_mm", "has 5 entries, at least 6"),
    "points and ring": (BASE, f"{BASE}, {points(6)}", "machine.base", "either points_mm .* or ring"),
    "neither points nor ring": (BASE, "", "machine.base", "either points_mm .* or ring"),
    "limits upside down": ("x_mm = [-250.0, 250.0]", "x_mm = [250.0, -250.0]", f"{BOX}.x_mm", "250 .*-250; swap"),
    "empty range": ("x_mm = [-250.0, 250.0]", "x_mm = [5.0, 5.0]", f"{BOX}.x_mm", "5 is not below.* 5"),
    "box without home": ("z_mm = [-100.0, 100.0]", "z_mm = [10.0, 100.0]", BOX, r"z_mm = \[10, 100\].*contain 0"),
    "struts of motions that are none of the workspace": (
        "strut_length_mm = [650.0, 1550.0]",
        "strut_length_mm = [650.0, 700.0]",
        "",
        "no length in common",
    ),
    "box beyond the workspace": ("x_mm = [-250.0, 250.0]", "x_mm = [-350.0, 250.0]", "", "beyond workspace.x_mm"),
    "parallel bars": (UPPER, HIGHER, FRAME, "parallel"),
    "bars that meet": (UPPER, f"upper = {{ points_mm = {[[0.0, 0.0, 100.0]] * 6} }}", FRAME, "six bars"),
    "bars that all meet the axis": (
        UPPER,
        f"upper = {{ points_mm = {[[0.0, 0.0, 100.0 + 20 * k] for k in range(6)]} }}",
        FRAME,
        "meet one line",
    ),
    "bars in a plane": (
        f"{LOWER}\n{UPPER}",
        f"lower = {{ {points(6)} }}\nupper = {{ points_mm = {[[50.0 * k * k, 300.0, 0.0] for k in range(6)]} }}",
        FRAME,
        "coplanar",
    ),
    "bar without length": (UPPER, LOWER.replace("lower", "upper"), FRAME, "bar 1 has no length"),
    "impossible inertia": (INERTIA, "[1.65, 0.0, 0.0, 0.05, 0.0, 1.51]", "nominal", "no rigid body has .*0.05, 1.51"),
    "negative inertia": (INERTIA, "[1.65, 0.0, 0.0, -1.65, 0.0, 1.51]", "nominal", "no rigid body"),
    "large moments of deviation": (INERTIA, "[1.65, 2.0, 0.0, 1.65, 0.0, 1.51]", "nominal", "no rigid body"),
    "noise of zero": ("range_N = 5000.0", "force_noise_N = 0.0", "sensors.force_noise_N", "0.0: .*greater than 0"),
    "noise of moments of bars": ("range_N = 5000.0", "moment_noise_Nm = 0.1", "", "moment_noise_Nm goes with .*remove"),
    "weights by no noise": ('weights = "equal"', 'weights = "stated"', "", "force_noise_N is missing; w"),
    "vibration alone": ("range_N = 5000.0", "acceleration_noise_m_s2 = 0.1", "", "force_noise_N is missing; .*noise"),
    "negative pose error": ("range_N = 5000.0", f"pose_error_N = -1.0\n{LENGTH}", "sensors.pose_error_N", "-1.0: .* 0"),
    "pose error over no length": (
        "range_N = 5000.0",
        "pose_error_N = 1.0\npose_error_length_mm = 0.0",
        "sensors.pose_error_length_mm",
        "0.0: .*equal to 0.1",
    ),
    "pose error in metres": (
        "range_N = 5000.0",
        "pose_error_N = 1.0\npose_error_length_mm = 0.028",
        "sensors.pose_error_length_mm",
        "0.028: .*equal to 0.1",
    ),
    "pose error over an angle": (
        "range_N = 5000.0",
        "pose_error_N = 1.0\npose_error_angle_deg = 3.0",
        "sensors.pose_error_angle_deg",
        "unknown key",
    ),
    "pose error without length": ("range_N = 5000.0", "pose_error_N = 1.0", "", "pose_error_length_mm is missing"),
    "pose error without size": ("range_N = 5000.0", LENGTH, "", "pose_error_N or .* is missing"),
    "another unit of noise": ("range_N = 5000.0", "pose_error_mm = 0.1", "sensors.pose_error_mm", "pose_error_"),
    "another version": ("schema_version = 1", "schema_version = 2", "schema_version", "2: .*1"),
    "setup of another sensor": ('setup = "1b"', 'setup = "R"', "", r"sensor_frame\.transducer"),
    "unknown setup": ('setup = "1b"', 'setup = "r"', "setup", "'r': .*'1a', '1b', '2x' or 'R'"),
    "safe feed that is too fast": ("safe_feed_mm_min = ", "safe_feed_mm_min = 99", "", "faster than limits.motion.vel"),
    "name with a blank": ('name = "hexapod"', 'name = "Hexa pod"', "name", "'Hexa pod'"),
    "more than a cycle": ("offset_cycles = 0.5", "offset_cycles = 1.5", "simulation.force_sampling", "1.5: "),
    "column that is a number": ("[recording]", "[recording]\ncolumns = { t_s = 3 }", "recording.columns.t_s", "3: "),
    "key of two lines": ("[workspace]", '[workspace]\n"x\\ny" = 3.0', "workspace.", "unknown key"),
    "machine that is singular": (
        "radius_mm = 250.0, half_angle_deg = 48.0",
        "radius_mm = 250.0, half_angle_deg = 12.0",
        "machine",
        "singular",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_its_key(mistake: str, tmp_path: Path) -> None:
    old, new, key, says = MISTAKES[mistake]
    file = edited(tmp_path, old, new)
    with pytest.raises(CaseError, match=says) as caught:
        load_case(file)
    message = one_line(caught.value)
    assert message.startswith(f"{file}: {key}")
    assert str(caught.value.file) == file


@pytest.mark.parametrize("broken", ["radius_mm = ", "radius_mm = 7,0", "radius_mm 700.0", "radius_mm = 700.0 mm"])
def test_what_is_not_toml_is_named_with_its_line(broken: str, tmp_path: Path) -> None:
    line = next(k for k, text in enumerate(HEXAPOD.splitlines(), 1) if "radius_mm = 700.0" in text)
    file = edited(tmp_path, "radius_mm = 700.0", broken)
    with pytest.raises(CaseError, match=rf"not TOML.*line {line}\b.*correct") as caught:
        load_case(file)
    assert one_line(caught.value).startswith(file)


def test_a_file_that_is_not_text_is_named(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_bytes(HEXAPOD.encode("utf-16"))
    with refused_at(tmp_path, "UTF-8", CaseError):
        load_case(str(tmp_path))


def test_all_mistakes_are_told_at_once_causes_first(tmp_path: Path) -> None:
    """A key that is only misspelt is not missing too; what several entries of a list lack is one line."""
    file = edited(
        tmp_path, "base_joint_angle_deg = 55.0\nplatform_joint_angle_deg = 80.0", "base_joint_angle_degs = -1"
    )
    text = (
        Path(file).read_text(encoding="utf-8").replace("mass_kg = 19.93, ", "").replace("range_N = 5", 'range_N = "5"#')
    )
    Path(file).write_text(text, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(file)
    problems = caught.value.problems
    places = [problem.split(":")[0] for problem in problems]
    assert places[:2] == ["workspace.base_joint_angle_degs", "sensors.range_N"]
    assert set(places[2:]) == {
        "workspace.platform_joint_angle_deg",
        *(f"payloads.weights[{k}].mass_kg" for k in range(1, 6)),
    }
    assert not any(problem.startswith("workspace.base_joint_angle_deg:") for problem in problems)
    assert all(problem in one_line(caught.value) for problem in problems)
    assert len(caught.value.lines) == len(problems) == 8
    assert all(line.startswith(f"{file}: ") for line in caught.value.lines)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (f"range_N = {'9' * 5000}", "too long"),
        (f"range_N = {'[' * 2000}{']' * 2000}", "too deep"),
        (f"range_N = {'{a = ' * 200}1{'}' * 200}", "tables or lists inside each other"),
        (f"{'.'.join('a' * 30)} = 1.0", "tables or lists inside each other"),
        (f"{'.'.join('a' * 60_000)} = 1.0", r"line \d+ has a key of 50 parts"),
        (f"x = {{ {' . '.join(['b', *'c' * 60])} = 1 }}", r"line \d+ has a key of 50 parts"),
        ("\n".join(f"k{k} = 1" for k in range(30_000)), "keys, at most"),
        ("x = '" + "y" * 2**21 + "'", "larger than 1 MB"),
    ],
)
def test_numbers_and_lists_that_python_cannot_read_are_named(line: str, says: str, tmp_path: Path) -> None:
    with refused_at(tmp_path, says, CaseError):
        load_case(edited(tmp_path, "range_N = 5000.0", line))


def test_of_very_many_problems_the_first_are_listed_and_the_others_counted(tmp_path: Path) -> None:
    lines = "".join(f"unknown_{k} = 1\n" for k in range(4000))
    with pytest.raises(CaseError) as caught:
        load_case(edited(tmp_path, "range_N = 5000.0\n", f"range_N = 5000.0\n{lines}"))
    assert len(caught.value.problems) == MOST_PROBLEMS
    assert f"has {4000 - MOST_PROBLEMS + 1} more problems" in one_line(caught.value)


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(pipe := tmp_path / "case.toml")
    for name in (pipe, tmp_path, Path("/dev/zero")):
        with pytest.raises(CaseError, match="not a file") as caught:
            load_case(str(name))
        one_line(caught.value)


def test_a_transducer_has_noise_of_forces_and_of_moments(tmp_path: Path) -> None:
    text = built_in_cases()["ft_wrist"].read_text(encoding="utf-8")
    text = text.replace("[sensors]", "[sensors]\nforce_noise_N = 0.1")
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CaseError, match=r"sensors\.moment_noise_Nm.*force_noise_N.*add") as caught:
        load_case(str(tmp_path))
    one_line(caught.value)


@pytest.mark.parametrize("character", ["\\u001b[31m", "\\u0007", "\\u202e", "\\u0000"])
def test_nothing_that_a_terminal_obeys_gets_into_a_case(character: str, tmp_path: Path) -> None:
    for old in ('title = "', 'source = "'):
        with pytest.raises(CaseError, match="holds control characters") as caught:
            load_case(edited(tmp_path, old, old + character))
        one_line(caught.value)


def test_a_title_of_several_lines_is_one(tmp_path: Path) -> None:
    title = load_case("hexapod").title
    assert load_case(edited(tmp_path, title, title.replace(", ", ",\\n  "))).title == title
