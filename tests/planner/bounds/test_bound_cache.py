"""The bound is computed once for a case and model, and again wherever the cache cannot be trusted."""

import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from cases.basis import bound_hash
from cases.schema import Case
from identification.model.model import identification_model
from planner.bounds import bound as bound_module
from planner.bounds.bound import Bound, code_hash, information_limit
from tests.postprocessors.changed_case import changed

UNUSED = {".venv", ".git", "tests", "docs", "examples", "hexcite", "postprocessors", "cases", "__pycache__"}
KNOWN = Bound(1.25, 10.01, 10, "as computed", True, 1.24)
HASTY = replace(KNOWN, certified=False)


def changed_text(**values: object) -> str:
    """The text of a cache file with other values."""
    return json.dumps(asdict(KNOWN) | values)


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Replaces the computation; holds one entry for each time it was needed."""
    calls: list[str] = []

    def compute(case: Case, *_: object) -> Bound:
        calls.append(case.hash)
        return KNOWN

    monkeypatch.setattr(bound_module, "compute_bound", compute)
    return calls


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of the bounds in a cache of its own."""
    monkeypatch.setattr(bound_module, "user_cache_path", lambda name: tmp_path)
    return tmp_path / "bounds"


def ask(case: Case, number: int = 0) -> Bound:
    return information_limit(case, identification_model(case, number))


def test_it_is_computed_once(computed: list[str], hexapod_case: Case, folder: Path):
    assert ask(hexapod_case) == ask(hexapod_case) == KNOWN
    assert len(computed) == 1


def test_another_model_or_case_is_another_bound(computed: list[str], hexapod_case: Case, folder: Path):
    lighter = changed(hexapod_case, gravity_m_s2=[0.0, 0.0, -9.8])
    for case, number in ((hexapod_case, 0), (hexapod_case, 6), (lighter, 0)):
        ask(case, number)
    assert len(computed) == 3
    assert len(list(folder.iterdir())) == 3


@pytest.mark.parametrize(
    "damage",
    [
        "",
        "{",
        "[1, 2]",
        "null",
        '{"logdet": 1.25}',
        changed_text(logdet="x"),
        changed_text(logdet=None),
        changed_text(logdet=float("nan")),
        changed_text(design_logdet=float("inf")),
        changed_text(parameters=0),
        changed_text(certified="yes"),
        changed_text(certified=1),
        changed_text(dmax=-1.0),
        "\x00" * 100,
    ],
)
def test_a_damaged_file_is_computed_again_and_mended(
    damage: str, computed: list[str], hexapod_case: Case, folder: Path
):
    ask(hexapod_case)
    (file,) = folder.iterdir()
    whole = file.read_text()
    file.write_text(damage)
    assert ask(hexapod_case) == KNOWN
    assert len(computed) == 2
    assert file.read_text() == whole


def test_bytes_that_are_no_text_are_damage_too(computed: list[str], hexapod_case: Case, folder: Path):
    ask(hexapod_case)
    (file,) = folder.iterdir()
    file.write_bytes(b"\xff\xfe\x00")
    assert ask(hexapod_case) == KNOWN


def test_a_cache_that_cannot_be_written_only_costs_time(computed: list[str], hexapod_case: Case, folder: Path):
    folder.write_text("not a folder")
    for _ in range(2):
        assert ask(hexapod_case) == KNOWN
    assert len(computed) == 2


def test_the_cache_lies_where_the_system_wants_it(computed: list[str], hexapod_case: Case, cache: Path):
    model = identification_model(hexapod_case, 1)  # a model that no other test plans with
    information_limit(hexapod_case, model)
    (file,) = cache.rglob(f"{bound_hash(hexapod_case)}-model1-*.json")
    assert json.loads(file.read_text())["method"] == KNOWN.method
    file.unlink()


def test_an_estimate_is_known_as_one_and_renewed_on_request(
    monkeypatch: pytest.MonkeyPatch, hexapod_case: Case, folder: Path
):
    model = identification_model(hexapod_case, 0)
    answers = [HASTY, KNOWN]
    monkeypatch.setattr(bound_module, "compute_bound", lambda *_: answers.pop(0))
    assert information_limit(hexapod_case, model) == HASTY
    assert information_limit(hexapod_case, model) == HASTY
    assert information_limit(hexapod_case, model, renew=True) == KNOWN
    assert information_limit(hexapod_case, model, renew=True) == KNOWN
    assert not answers


def test_another_version_of_the_code_computes_anew(
    computed: list[str], hexapod_case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    ask(hexapod_case)
    monkeypatch.setattr(bound_module, "code_hash", lambda: "another")
    ask(hexapod_case)
    assert len(computed) == 2


def test_the_hash_follows_the_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A copy of the files that compute, with a blank line more in one of them."""
    home = Path(bound_module.__file__).parents[2]
    shutil.copytree(home, tmp_path / "copy", ignore=lambda _, names: {n for n in names if n in UNUSED})
    copied = tmp_path / "copy" / "planner" / "bounds" / "bound.py"
    monkeypatch.setattr(bound_module, "__file__", str(copied))
    same, certificate = code_hash.__wrapped__(), copied.with_name("certificate.py")
    assert same == code_hash.__wrapped__()
    certificate.write_bytes(certificate.read_bytes() + b"\n")
    assert code_hash.__wrapped__() != same


def test_the_cache_can_be_switched_off(
    computed: list[str], hexapod_case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    ask(hexapod_case)
    monkeypatch.setenv("HEXCITE_CACHE", "off")
    ask(hexapod_case)
    assert len(computed) == 2
    assert len(list(folder.iterdir())) == 1
