"""The cases that ship with hexcite, and how a case is found and told apart."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from cases.base.errors import CaseError, FileProblem
from cases.schema import Case, load_case
from cases.tables import built_in_cases, find_case
from tests.cases.editing import HEXAPOD, edited
from tests.helpers import answer, one_line


@pytest.mark.parametrize("name", built_in_cases())
def test_every_built_in_case_loads_by_name_folder_and_file(name: str) -> None:
    file = built_in_cases()[name]
    cases = [load_case(n) for n in (name, str(file.parent), str(file))]
    assert {case.name for case in cases} == {name}
    assert len({case.hash for case in cases}) == 1


def test_cases_are_equal_when_their_values_are(hexapod_case: Case, wrist_case: Case) -> None:
    assert hexapod_case == load_case("hexapod")
    assert hexapod_case != wrist_case


def test_hexapod_and_wrist_sensor_are_built_in() -> None:
    assert {"hexapod", "ft_wrist"} <= set(built_in_cases())


def test_values_of_the_file_become_si_and_radians(hexapod_case: Case) -> None:
    machine, box = hexapod_case.machine, hexapod_case.limits.motion
    np.testing.assert_allclose(np.linalg.norm(machine.base.points[:, :2], axis=1), 0.7)
    np.testing.assert_allclose(machine.home.vector, [0, 0, 0.9, 0, 0, 0])
    np.testing.assert_allclose(box.rate, [0.6] * 3 + [np.pi / 3] * 3)
    np.testing.assert_allclose(box.acceleration, [6.0] * 3 + [10.0] * 3)
    np.testing.assert_allclose(box.coordinates[1], [0.25, 0.25, 0.1] + [np.pi / 9] * 3)
    np.testing.assert_allclose(box.strut_length, [0.72, 1.46])
    assert hexapod_case.simulation.force_delay == 0.002
    assert hexapod_case.simulation.encoder_resolution == 1e-7
    assert hexapod_case.controller.block == 0.01
    assert hexapod_case.controller.safe_feed == 0.05


def test_joints_of_a_ring_stand_in_pairs_minus_side_first(hexapod_case: Case) -> None:
    angles = np.rad2deg(np.arctan2(*hexapod_case.machine.base.points[:, 1::-1].T)) % 360
    np.testing.assert_allclose(angles, [78, 102, 198, 222, 318, 342])


def test_a_case_cannot_be_changed(hexapod_case: Case) -> None:
    with pytest.raises(ValidationError, match="frozen"):
        hexapod_case.nominal.mass_kg = 1.0
    for array in (hexapod_case.gravity, hexapod_case.machine.base.points, hexapod_case.limits.motion.coordinates):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_comments_layout_and_spelling_of_numbers_do_not_change_the_hash(tmp_path: Path, hexapod_case: Case) -> None:
    lines = [line.split(" #")[0] for line in HEXAPOD.splitlines() if line and not line.startswith("#")]
    text = "\n\n# nothing\n".join(lines).replace("radius_mm = 700.0", "radius_mm   =   7e2")
    (tmp_path / "case.toml").write_text(text.replace("mass_kg = 33.0", "mass_kg = 33"))
    assert load_case(str(tmp_path)).hash == hexapod_case.hash


def values(data: object, path: tuple[str | int, ...] = ()) -> list[tuple[tuple[str | int, ...], object]]:
    if isinstance(data, dict | list):
        items = data.items() if isinstance(data, dict) else enumerate(data)
        return [found for k, v in items for found in values(v, (*path, k))]
    return [(path, data)]


def changed(data: Any, path: tuple[str | int, ...], value: object) -> object:
    if not path:
        return value
    copy: Any = dict(data) if isinstance(data, dict) else list(data)
    copy[path[0]] = changed(data[path[0]], path[1:], value)
    return copy


NUMBERS = [
    (p, v)
    for p, v in values(tomllib.loads(HEXAPOD))
    if isinstance(v, float) and (v or p[0] != "poses")  # a range from 0.001 to 0 is none
]


@given(which=st.integers(0, len(NUMBERS) - 1))
def test_any_value_that_changes_changes_the_hash_of_the_machine_or_that_of_its_controller(which: int) -> None:
    path, value = NUMBERS[which]
    data = changed(tomllib.loads(HEXAPOD), path, value * 1.001 if value else 1e-3)
    case, whole = Case.model_validate(data), load_case("hexapod")
    assert (case.hash != whole.hash) == (path[0] != "controller")
    assert (case.controller_hash != whole.controller_hash) == (path[0] == "controller")


def test_stating_a_default_does_not_make_another_case(tmp_path: Path, hexapod_case: Case) -> None:
    stated = HEXAPOD.replace("[recording]", '[recording]\nformat = "csv"')
    assert "\nformat =" not in HEXAPOD
    (tmp_path / "case.toml").write_text(stated)
    assert load_case(str(tmp_path)).hash == hexapod_case.hash


@pytest.mark.parametrize(
    ("name", "hint"),
    [("hexapd", "did you mean 'hexapod'"), ("ft-wrist", "did you mean 'ft_wrist'"), ("lathe", "hexapod")],
)
def test_an_unknown_name_is_answered_with_the_known_ones(name: str, hint: str) -> None:
    with pytest.raises(CaseError, match=hint) as caught:
        load_case(name)
    message = one_line(caught.value)
    assert message.startswith(f"{name}: no such case")
    assert "ft_wrist, hexapod" in message


@given(name=st.text(max_size=20) | st.text("ab./ ", min_size=250, max_size=5000))
def test_whatever_is_given_as_a_name_the_answer_is_a_file_or_one_line(name: str) -> None:
    file = answer(lambda: find_case(name), "no such case")
    assert file is None or file.is_file()


def test_a_folder_without_a_case_is_no_case(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no such case") as caught:
        load_case(str(tmp_path))
    assert str(tmp_path) in one_line(caught.value)


def test_a_byte_order_mark_as_windows_editors_write_it_does_no_harm(tmp_path: Path, hexapod_case: Case) -> None:
    (tmp_path / "case.toml").write_bytes(b"\xef\xbb\xbf" + HEXAPOD.encode())
    assert load_case(str(tmp_path)).hash == hexapod_case.hash


@pytest.mark.parametrize(
    ("need", "part"),
    [("need_machine", "machine"), ("need_controller", "controller"), ("need_simulation", "simulation")],
)
def test_a_part_that_a_case_lacks_is_asked_for_by_name(wrist_case: Case, need: str, part: str) -> None:
    with pytest.raises(CaseError, match=f"case ft_wrist: {part}: .*missing.*baking") as caught:
        getattr(wrist_case, need)("baking")
    assert caught.value.key == part


def test_a_case_with_a_machine_but_without_limits_lacks_the_limits(tmp_path: Path) -> None:
    start = HEXAPOD.index("[limits.motion]")
    end = HEXAPOD.index("[sensor_frame.bars]")
    case = load_case(edited(tmp_path, HEXAPOD[start:end], ""))
    with pytest.raises(CaseError, match=r"limits\.motion: is missing"):
        case.need_machine("planning")


@pytest.mark.parametrize("name", built_in_cases())
def test_a_case_that_is_saved_loads_as_the_same_case(name: str, tmp_path: Path) -> None:
    case = load_case(name)
    found = Case.load(str(case.save(tmp_path / "case.toml")))
    assert (found, found.hash, found.controller_hash) == (case, case.hash, case.controller_hash)
    with pytest.raises(FileProblem, match=r"case\.toml: .*overwrite"):
        case.save(tmp_path / "case.toml")


@given(
    name=st.sampled_from(list(built_in_cases())),
    title=st.text(),
    column=st.text(min_size=1),
    gravity=st.floats(9.7, 9.9),
    noise=st.floats(1e-300, 1e3),
)
def test_saving_and_loading_a_case_are_inverse(
    name: str, title: str, column: str, gravity: float, noise: float, tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = load_case(name).model_dump(mode="json", exclude_defaults=True)
    data |= {"title": title, "gravity_m_s2": [0.0, 0.0, -gravity]}
    data["recording"] = data["recording"] | {"columns": {"t_s": column}}
    if data["sensors"].get("force_noise_N") is not None:
        data["sensors"] = data["sensors"] | {"force_noise_N": noise}
    try:
        case = Case.model_validate(data)
    except ValidationError:
        return  # a name of a column that the case refuses
    file = case.save(tmp_path_factory.mktemp("case") / "case.toml")
    assert Case.load(str(file)) == case


def test_a_path_names_a_case_as_a_text_does(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_bytes(built_in_cases()["hexapod"].read_bytes())
    assert load_case(tmp_path) == load_case(str(tmp_path)) == load_case("hexapod")
    with pytest.raises(CaseError, match="no such case"):
        load_case(tmp_path / "nowhere")
