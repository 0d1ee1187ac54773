"""`hexcite export` as its users call it: what it writes, what it says, and that a mistake leaves nothing behind."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import FileProblem
from cases.base.folder_kinds import MARKER
from cases.schema import load_case
from cases.tables import built_in_cases
from identification.finding import Finding, Kind, warning
from identification.results.result import Result
from postprocessors.export.calibration import require_exportable
from postprocessors.export.targets import TARGETS
from tests.hexcite.command_line import call, refused
from tests.postprocessors.export.calibrations import write_result

CASE = load_case("hexapod")


def machine(target: str) -> tuple[str, int]:
    """A built-in machine whose result a target takes, and the model: payloads are of robots."""
    return (
        ("hexapod", 9)
        if target in ("c", "linuxcnc", "st", "python", "json", "urdf", "mjcf", "sdf")
        else ("ur10_wrist", 6)
    )


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def result(tmp_path: Path) -> Path:
    return write_result(tmp_path / "result", CASE, 9)


@pytest.mark.parametrize("target", TARGETS)
def test_every_target_is_written_whole_and_says_where_it_is_from(target: str, tmp_path: Path, here: Path) -> None:
    name, model = machine(target)
    result = write_result(tmp_path / "result", load_case(name), model)
    answer = call("export", result, "--to", target, "--json").json()
    assert answer["target"] == target
    assert answer["file"] == answer["files"][0]
    for file in answer["files"]:
        text = Path(file).read_text(encoding="utf-8")
        for word in (str(result / "result.json"), load_case(name).hash, name):
            assert word in text
    written = {path for path in here.rglob("*") if path.is_file() and path.name != MARKER}
    assert written == {here / file for file in answer["files"]}


@pytest.mark.parametrize("name", ["mine", pytest.param("a" * 30, marks=pytest.mark.repeats)])
@pytest.mark.parametrize("target", TARGETS)
def test_what_is_exported_again_gets_a_free_name(target: str, name: str, tmp_path: Path, here: Path) -> None:
    like, model = machine(target)
    text = built_in_cases()[like].read_text(encoding="utf-8").replace(f'name = "{like}"', f'name = "{name}"')
    (folder := tmp_path / name).mkdir()
    (folder / "case.toml").write_text(text, encoding="utf-8")
    result = write_result(tmp_path / "result", load_case(str(folder)), model)
    files = [call("export", result, "--to", target, "--case", folder, "--json").json()["files"] for _ in range(3)]
    written = [str(f.relative_to(here)) for f in here.rglob("*") if f.is_file() and f.name != MARKER]
    assert sorted(written) == sorted(file for run in files for file in run)
    assert len(set(written)) == 3 * len(files[0])


@pytest.mark.parametrize("target", TARGETS)
def test_a_result_with_warnings_needs_force_and_the_file_tells(target: str, tmp_path: Path, here: Path) -> None:
    name, model = machine(target)
    result = write_result(
        tmp_path / "doubtful", load_case(name), model, warnings=["rank 19 of 20: k1 is free", "short"]
    )
    line = refused("export", result, "--to", target)
    for word in ("doubtful/result.json", "rank 19 of 20: k1 is free", "and 1 more", "--force"):
        assert word in line
    assert list(here.iterdir()) == []
    answer = call("export", result, "--to", target, "--force", "--json").json()
    assert answer["warnings"] == ["rank 19 of 20: k1 is free", "short"]
    for file in answer["files"]:
        assert "rank 19 of 20: k1" in Path(file).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--to", "fortran"), ("'fortran'", "choose c, ")),
        (("--to", "c", "--case", "ft_wrist"), ("result.json", "case hexapod, not ft_wrist")),
        (("--to", "c", "--case", "nowhere"), ("nowhere", "no such case")),
        (("--to", "c", "-o", "model.c"), ("model.c", "folder", "-o")),
        (("--to", "c", "-o", "."), ("folder that you work in",)),
        (("--to", "json", "-o", "model.txt"), ("model.txt", ".json")),
        (("--to", "st", "-o", "My-Model.st"), ("My-Model", "small letters", "-o")),
        (("--to", "isg-load"), ("'isg-load'", "choose c, ")),
    ],
)
def test_a_wrong_argument_is_named_and_nothing_written(
    arguments: tuple[str, ...], words: tuple[str, ...], result: Path, here: Path
) -> None:
    line = refused("export", result, *arguments)
    for word in words:
        assert word in line
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"case_hash": "0" * 16}, ("case hexapod has changed since", "--stale")),
        ({"case": "my_machine"}, ("my_machine", "--case")),
        ({"findings": None}, ("missing or damaged", "identify again")),
        ({"parameters": {}}, ("parameters are not those of model 9",)),
        ({"model": 8}, ("parameters are not those of model 8",)),
        ({"schema_version": 7}, ("schema_version 7",)),
    ],
)
def test_a_result_that_does_not_fit_is_named(
    changes: dict[str, Any], words: tuple[str, ...], tmp_path: Path, here: Path
) -> None:
    result = write_result(tmp_path / "result", CASE, 9, **changes)
    line = refused("export", result, "--to", "c")
    for word in ("result.json", *words):
        assert word in line
    assert list(here.iterdir()) == []


def test_a_payload_from_an_unknown_flange_is_refused_with_the_key(result: Path, tmp_path: Path, here: Path) -> None:
    assert "setup: is that of no robot" in refused("export", result, "--to", "urscript")
    wrist = write_result(tmp_path / "wrist", load_case("ft_wrist"), 6)
    line = refused("export", wrist, "--to", "urscript")
    for word in ("ft_wrist", "sensor_frame.transducer.flange", "origin_mm"):
        assert word in line
    assert list(here.iterdir()) == []


def test_a_tared_result_says_so(tmp_path: Path, here: Path) -> None:
    for target in TARGETS:
        name, model = machine(target)
        result = write_result(tmp_path / name, load_case(name), model, tared_with="still.csv")
        answer = call("export", result, "--to", target, "--json").json()
        assert "from run.csv, tared with still.csv" in Path(answer["file"]).read_text() or target == "json"
    assert json.loads(Path("hexapod_force.json").read_text())["origin"]["recording"] == "run.csv, tared with still.csv"


def test_a_negative_mass_is_no_machine(tmp_path: Path, here: Path) -> None:
    from identification.model.model import identification_model
    from tests.postprocessors.export.calibrations import plausible

    u = plausible(CASE, identification_model(CASE, 9))
    u[0] = -1.0
    line = refused("export", write_result(tmp_path / "result", CASE, 9, u), "--to", "json")
    assert "mass -1 kg" in line
    assert list(here.iterdir()) == []


def test_the_result_itself_is_never_overwritten(result: Path, here: Path) -> None:
    before = (result / "result.json").read_bytes()
    refused("export", result, "--to", "json", "-o", result / "result.json")
    refused("export", result, "--to", "c", "-o", result)
    assert (result / "result.json").read_bytes() == before


def test_a_case_that_is_not_built_in_is_named_by_file(tmp_path: Path, here: Path) -> None:
    file = tmp_path / "machine.toml"
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8")
    file.write_text(text.replace('name = "hexapod"', 'name = "mine"'), encoding="utf-8")
    result = write_result(tmp_path / "result", load_case(str(file)), 9)
    answer = call("export", result, "--to", "json", "--case", file, "--json").json()
    assert answer["file"] == "mine_force.json"
    assert json.loads(Path(answer["file"]).read_text())["origin"]["case"] == "mine"


def test_a_folder_of_c_is_replaced_on_request_and_another_never(result: Path, here: Path) -> None:
    answer = call("export", result, "--to", "c", "-o", "model", "--json").json()
    assert [Path(f).name for f in answer["files"]] == ["hexapod_force.c", "hexapod_force.h"]
    assert "--overwrite" in refused("export", result, "--to", "c", "-o", "model")
    call("export", result, "--to", "c", "-o", "model", "--overwrite", "--json").json()
    shutil.copy(result / "result.json", here / "model")
    assert "is not a C model" in refused("export", result, "--to", "c", "-o", "model")


def test_warnings_that_deviations_allow_for_do_not_stop_an_export(result: Path) -> None:
    """Nor do those about what was left out, or how the run went: values come from what was measured and is sound."""
    counted = warning(Kind.MODEL, "residuals follow the speed; deviations allow for it", counted=True)
    slower = warning(Kind.PROGRAM, "2.00 times slower than planned")
    left_out = warning(Kind.DAMAGE, "lines 3 to 5 were left out")
    contact = warning(Kind.CONTACT, "contact from 1 to 2 s; left out")
    assert [f.doubts_values for f in (counted, slower, left_out, contact)] == [False, False, False, True]
    loaded = Result.load(result)
    require_exportable(with_findings(loaded, counted, slower, left_out))
    with pytest.raises(FileProblem, match=r"contact from 1 to 2 s.*identify again, or export with force"):
        require_exportable(with_findings(loaded, counted, contact))


def with_findings(result: Result, *findings: Finding) -> Result:
    """A result with other findings."""
    return replace(result, record=result.record.replaced(findings=findings))
