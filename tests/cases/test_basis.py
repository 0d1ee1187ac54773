"""What artefacts depend on in a case, and what may be edited without making them worthless."""

import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import CaseError, FileProblem
from cases.basis import (
    COMPUTED_FROM,
    bound_hash,
    case_of,
    changes_since,
    motion_hash,
    plan_basis,
    recording_basis,
    require_unchanged,
    result_basis,
)
from cases.schema import Case, load_case
from cases.tables import built_in_cases


def edited(key: str, value: Any) -> Case:
    """The hexapod with another value."""
    data = tomllib.loads(built_in_cases()["hexapod"].read_text(encoding="utf-8"))
    *tables, name = key.split(".")
    table = data
    for inner in tables:
        table = table[inner]
    table[name] = value
    return Case.model_validate(data)


def kept(case: Case) -> dict[str, dict[str, Any]]:
    bases = {"plan": plan_basis(case), "recording": recording_basis(case), "result": result_basis(case)}
    return {name: {"case": "hexapod", COMPUTED_FROM: basis} for name, basis in bases.items()}


@pytest.mark.parametrize(
    ("key", "value", "stale"),
    [
        ("title", "another title", ()),
        ("simulation.source", "a better balance", ()),
        ("recording.rate_Hz", 500.0, ()),
        ("recording.filter_cutoff_Hz", 8.0, ("result",)),
        ("controller.block_ms", 12.0, ()),
        ("controller.cycle_ms", 2.0, ("plan",)),
        ("simulation.force_noise_N", 2.0, ()),
        ("limits.motion.x_mm", [-90.0, 90.0], ("plan",)),
        ("nominal.mass_kg", 94.0, ("plan",)),
        ("gravity_m_s2", [0.0, 0.0, -9.8], ("plan", "recording", "result")),
        ("machine.home.z_mm", 901.0, ("plan", "recording", "result")),
    ],
)
def test_only_what_an_artefact_was_computed_from_makes_it_stale(key: str, value: Any, stale: tuple[str, ...]):
    before = load_case("hexapod")
    if key == "simulation.force_noise_N" and before.sensors.force_noise_N is None:
        stale = ("plan",)
    now = edited(key, value)
    bases = {"plan": plan_basis(now), "recording": recording_basis(now), "result": result_basis(now)}
    for name, about in kept(before).items():
        changes = changes_since(about, bases[name], now.hash)
        checked = partial(require_unchanged, Path(f"{name}.json"), about, bases[name], now, again="do it again")
        assert bool(changes) == (name in stale), name
        if not changes:
            assert checked(stale=False) == ()
            continue
        assert changes[0].startswith(f"{key} was ")
        with pytest.raises(FileProblem, match=rf"{name}\.json: case hexapod.*changed.*stale"):
            checked(stale=False)
        (remark,) = checked(stale=True)
        assert remark.startswith("stale: ")
        assert key in remark


def test_bounds_and_programs_outlive_a_new_title() -> None:
    before, now = load_case("hexapod"), edited("title", "another title")
    assert (bound_hash(now), motion_hash(now)) == (bound_hash(before), motion_hash(before))
    assert bound_hash(edited("machine.home.z_mm", 901.0)) != bound_hash(before)


def test_the_case_is_found_by_what_the_artefact_says() -> None:
    file = Path("result.json")
    assert case_of(file, {"case_file": "hexapod"}, "identify again").name == "hexapod"
    with pytest.raises(FileProblem, match=r"no case.*identify again.* case"):
        case_of(file, {}, "identify again")
    with pytest.raises(CaseError, match=r"gone\.toml: no such case.*with case"):
        case_of(file, {"case_file": "/gone.toml"}, "identify again")


FIRST = {f"f{k}_N": f"Force{k}" for k in range(1, 7)}


def recorded(columns: dict[str, str], unit: str, cutoff: float = 20.0) -> dict[str, Any]:
    """Values behind a result of a run whose files have these columns."""
    table = {"columns": columns, "units": {"forces": unit}, "filter_cutoff_Hz": cutoff}
    return result_basis(edited("recording", table))


@pytest.mark.parametrize(
    ("columns", "unit", "cutoff", "changed"),
    [
        (FIRST, "N", 20.0, {"recording.units.forces"}),  # files of the same recorder were read wrongly
        (
            FIRST | {"f1_N": "Force2", "f2_N": "Force1"},
            "kN",
            20.0,
            {"recording.columns.f1_N", "recording.columns.f2_N"},
        ),
        (FIRST | {"f1_N": "Kraft1"}, "kN", 20.0, {"recording.columns.f1_N"}),
        ({name: f"Kraft{k}" for k, name in enumerate(FIRST)}, "N", 20.0, set()),  # those of another recorder
        ({}, "N", 20.0, set()),
        ({name: f"Kraft{k}" for k, name in enumerate(FIRST)}, "N", 10.0, {"recording.filter_cutoff_Hz"}),
    ],
)
def test_how_files_of_another_recorder_are_read_makes_no_result_stale(
    columns: dict[str, str], unit: str, cutoff: float, changed: set[str]
):
    about = {COMPUTED_FROM: recorded(FIRST, "kN")}
    changes = changes_since(about, recorded(columns, unit, cutoff), "")
    assert {change.partition(" was ")[0] for change in changes} == changed
