"""Values of a case are changed by a form, one by one, and everything else of the file stays."""

import tomllib
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from cases.scaffold import new_case
from cases.schema import load_case
from hexcite.page import values
from hexcite.page.values import Refused, digest, edited, sections


@pytest.fixture
def file(root: Path) -> Path:
    return new_case("mill", "hexapod", root / "mill")


RADIUS = "machine.base.ring.radius_mm"


def form(file: Path, **given: str) -> dict[str, str]:
    return {"digest": digest(file.read_text()), **{f"v.{name}": value for name, value in given.items()}}


def test_every_value_of_a_case_has_a_field_that_reads_back(file: Path):
    content = file.read_text()
    entries = [entry for section in sections(content, load_case(str(file))) for entry in section.entries]
    assert {entry.name for entry in entries} >= {RADIUS, "limits.motion.x_mm", "machine.home.z_mm"}
    assert edited(content, {entry.name: entry.text for entry in entries}) == content
    assert sum(bool(entry.words) for entry in entries) > len(entries) / 2
    assert all(entry.example for entry in entries if entry.name.startswith("machine"))


@pytest.mark.parametrize("typed", ["701.5", "701,5", " 701.5 "])
def test_a_value_is_changed_and_comments_stay(file: Path, typed: str):
    content = file.read_text()
    after = edited(content, {RADIUS: typed})
    assert tomllib.loads(after)["machine"]["base"]["ring"]["radius_mm"] == 701.5
    comments = [line for line in content.splitlines() if line.startswith("#")]
    assert [line for line in after.splitlines() if line.startswith("#")] == comments


@pytest.mark.parametrize(
    ("name", "typed", "words"),
    [
        (RADIUS, "wide", "not a number"),
        (RADIUS, "true", "not a number"),
        (RADIUS, "1\nname = 'other'", "not a number"),
        ("limits.motion.x_mm", "3", "not a list"),
        ("name", "other", "no such value"),
        ("machine.base.ring.colour", "1", "no such value"),
    ],
)
def test_what_is_no_value_of_the_kind_is_refused(file: Path, name: str, typed: str, words: str):
    with pytest.raises(Refused, match=words):
        edited(file.read_text(), {name: typed})


def test_saving_writes_what_can_be_and_nothing_else(client: TestClient, file: Path):
    before = file.read_text()
    answer = client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "710"}))
    assert answer.headers["location"] == "/m/+mill/machine?saved=1"
    assert load_case(str(file)).hash != ""
    assert tomllib.loads(file.read_text())["machine"]["base"]["ring"]["radius_mm"] == 710.0
    impossible = client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "-5"}))
    assert impossible.status_code == 409
    assert "radius_mm" in impossible.text
    assert 'value="-5"' in impossible.text  # what was typed is not lost
    assert file.read_text() != before
    assert tomllib.loads(file.read_text())["machine"]["base"]["ring"]["radius_mm"] == 710.0


def test_a_second_window_does_not_overwrite_the_first(client: TestClient, file: Path):
    old = form(file, **{RADIUS: "720"})
    client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "710"}))
    answer = client.post("/m/+mill/do/save", data=old)
    assert answer.status_code == 409
    assert tomllib.loads(file.read_text())["machine"]["base"]["ring"]["radius_mm"] == 710.0


def test_a_built_in_case_stays(client: TestClient):
    assert client.post("/m/hexapod/do/save", data={"digest": "", f"v.{RADIUS}": "1"}).status_code == 400


def test_the_drawing_follows_what_is_typed(client: TestClient, file: Path):
    before = client.post("/m/+mill/do/preview", data=form(file)).text
    after = client.post("/m/+mill/do/preview", data=form(file, **{"machine.home.z_mm": "950"})).text
    assert before.count("<svg") == after.count("<svg") == 2
    assert "1038.91" in before  # length of the struts at home, by hand: sqrt(dx^2 + dy^2 + 900^2)
    assert "1038.91" not in after
    wrong = client.post("/m/+mill/do/preview", data=form(file, **{"machine.home.z_mm": "up"}))
    assert wrong.status_code == 200
    assert "not a number" in wrong.text
    assert values.digest(file.read_text()) == form(file)["digest"]
