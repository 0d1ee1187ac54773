"""The grid of a study: which cells it has, and one line for what it cannot be."""

import itertools
from pathlib import Path

import pytest

from cases.base.errors import CaseError, FileProblem, HexciteError
from cases.schema import Case, load_case
from hexcite.studies.spec import ExecutionSpec, Grid, Spec, cells_of, command_of, load_spec, request_of
from planner.families.settings import FAMILIES
from planner.request import Request
from tests.helpers import one_line

HEAD = 'schema_version = 1\nname = "mine"\n'


def written(folder: Path, text: str) -> str:
    (folder / "study.toml").write_text(HEAD + text)
    return str(folder / "study.toml")


def test_every_combination_is_a_cell_once(tmp_path: Path, hexapod_case: Case) -> None:
    spec = load_spec(written(tmp_path, '[grid]\norder = [2, 3]\ncriterion = ["A", "D"]\nseed = [0, 1, 2]\n'))
    cells = list(cells_of(spec, hexapod_case).values())
    assert spec.size == 12
    wanted = set(itertools.product("AD", (2, 3), (0, 1, 2)))
    assert {(c["criterion"], c["order"], c["seed"]) for c in cells} == wanted
    assert len(cells) == 12


def test_settings_of_another_family_make_no_further_cells(hexapod_case: Case) -> None:
    spec = Spec(schema_version=1, name="x", grid=Grid(family=["fourier", "ptp"], order=[2, 3, 4], moves=[8, 16]))
    cells = list(cells_of(spec, hexapod_case).values())
    assert [c["family"] for c in cells] == ["fourier"] * 3 + ["ptp"] * 2
    assert all("moves" not in c for c in cells[:3])
    assert all("order" not in c for c in cells[3:])


def test_periods_moves_and_knots_that_are_not_stated_fit_every_duration(hexapod_case: Case) -> None:
    grid = Grid(family=["fourier", "ptp", "spline"], duration_s=[4.0, 7.0, 12.0])
    for settings in cells_of(Spec(schema_version=1, name="x", grid=grid), hexapod_case).values():
        request = request_of(settings)
        assert request == Request(FAMILIES[settings["family"]](), settings["duration_s"], starts=1)


def test_ten_million_cells_are_too_many(hexapod_case: Case) -> None:
    grid = Grid(seed=list(range(10_000)), order=[2, 3, 4, 5, 6], period_s=[1.0 + 0.01 * k for k in range(200)])
    with pytest.raises(HexciteError, match=r"10000000 cells, .*1000000; list fewer") as caught:
        cells_of(Spec(schema_version=1, name="x", grid=grid), hexapod_case)
    one_line(caught.value)


def test_a_cell_is_known_by_all_that_changes_its_rows(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    def key(case: Case = hexapod_case, order: int = 5, execute: ExecutionSpec | None = None) -> str:
        (cell,) = cells_of(Spec(schema_version=1, name="x", grid=Grid(order=[order]), execute=execute), case)
        return cell

    other = hexapod_case.model_copy(update={"gravity_m_s2": (0.0, 0.0, -9.8)})
    keys = {key(), key(order=4), key(execute=ExecutionSpec()), key(execute=ExecutionSpec(noise_seeds=50)), key(other)}
    assert len(keys) == 5
    assert key() in keys
    assert key(hexapod_case.model_copy(update={"title": "the same machine in other words"})) in keys
    monkeypatch.setattr("hexcite.studies.spec.version", lambda name: "9.9")
    assert key() not in keys


@pytest.mark.parametrize("name", ["paper", "validation"])
def test_built_in_studies_can_be_planned(name: str, hexapod_case: Case) -> None:
    cells = list(cells_of(load_spec(name), hexapod_case).values())
    assert len(cells) >= 8
    for settings in cells:
        assert request_of(settings).starts == 1


def test_the_command_of_a_cell_is_one_that_hexcite_takes() -> None:
    settings = {"family": "fourier", "criterion": "D", "duration_s": 12.0, "period_s": 3.0, "seed": 4}
    command = "hexcite plan hexapod --family fourier --criterion D --duration 12.0 --period 3.0"
    assert command_of(settings, "hexapod") == command
    other = {"family": "fourier", "equal_start": True, "solver": "active-set", "seed": 0}
    assert command_of(other, "hexapod") == "hexcite plan hexapod --family fourier --equal-start --solver active-set"
    assert "equal" not in command_of(other | {"equal_start": False}, "hexapod")


def test_the_seed_of_equal_start_values_makes_no_other_cell(hexapod_case: Case) -> None:
    grid = Grid(equal_start=[False, True], seed=[0, 1, 2])
    cells = cells_of(Spec(schema_version=1, name="x", grid=grid), hexapod_case).values()
    assert sorted((cell["equal_start"], cell["seed"]) for cell in cells) == [
        (False, 0),
        (False, 1),
        (False, 2),
        (True, 0),
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "[grid]\nordr = 3\n",
            "grid.ordr: is an unknown key; did you mean order? known keys here are criterion, ",
        ),
        (
            "[gird]\norder = 3\n",
            "gird: is an unknown key; did you mean grid? known keys here are cells, execute, ",
        ),
        ('[grid]\norder = "five"\n', "'five': is not a whole number"),
        ("[grid]\norder = []\n", "has 0 entries, at least 1"),
        ("[cells]\ntime_limit_s = 0.0\n", "greater than 0"),
        ("[execute]\nnoise_seeds = 0\n", "greater than or equal to 1"),
        ('[execute]\non = "moon"\n', "'moon': input should be 'virtual'"),
        ("[grid\n", "is not TOML"),
    ],
)
def test_a_mistake_is_named(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load_spec(written(tmp_path, text))
    assert says in one_line(caught.value)
    assert one_line(caught.value).startswith(str(tmp_path / "study.toml"))


def test_a_study_that_is_not_there() -> None:
    with pytest.raises(FileProblem, match=r"studies are paper, validation, .*TOML file"):
        load_spec("papr")


@pytest.mark.parametrize(("settings", "says"), [({"order": 50}, "order 50"), ({"criterion": "X"}, "criterion 'X'")])
def test_what_cannot_be_planned_is_refused_before_the_work(settings: dict, says: str) -> None:
    with pytest.raises(HexciteError, match=says):
        request_of({"family": "fourier"} | settings)


@pytest.mark.parametrize(("case", "model"), [("hexapod", 9), ("ur10_wrist", 6), ("strut_sensors", 6)])
def test_a_model_that_is_not_stated_is_the_largest_of_the_machine(case: str, model: int) -> None:
    cells = cells_of(Spec(schema_version=1, name="x", grid=Grid(family=["ptp"])), load_case(case))
    assert [settings["model"] for settings in cells.values()] == [model]
