"""`hexcite bound` as its users call it."""

import json
from pathlib import Path

import pytest

from tests.hexcite.command_line import call, refused


def test_it_answers_with_a_certificate(cache: Path, tmp_path: Path):
    file = tmp_path / "bound.json"
    answer = call("bound", "hexapod", "--model", 2, "--json", "-o", file).json()
    assert answer["certified"]
    assert set(answer["certificate"]) == {"dmax", "p", "method"}
    p, dmax = answer["certificate"]["p"], answer["certificate"]["dmax"]
    assert p == 12
    assert p <= dmax <= p * 1.001 * (1 + 1e-9)
    assert answer["logdet_design"] < answer["logdet_bound"]
    assert json.loads(file.read_text()) == answer


def test_people_read_that_it_is_proven(cache: Path):
    told = call("bound", "hexapod", "--model", 2)
    assert told.code == 0
    assert "proven" in told.out
    assert "reference scaling" in told.out
    assert told.err == ""


def test_people_read_that_it_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))  # nobody has proven it there
    told = call("bound", "hexapod", "--model", 2, "--time-limit", 1e-6)
    assert told.code == 0
    assert "an estimate" in told.out
    assert "time limit" in told.out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("hexapod", "--model", 11), ("model 11", "0, 1, 2")),
        (("hexapod", "--time-limit", "nan"), ("--time-limit", "above 0")),
        (("hexapod", "--time-limit", "0"), ("--time-limit", "above 0")),
        (("ft_wrist",), ("machine", "information limit")),
        (("nowhere",), ("nowhere",)),
        (("hexapod", "-o", "bound.txt"), ("bound.txt", ".json")),
        (("hexapod", "-o", "."), ("no suffix",)),
    ],
)
def test_bad_requests_are_refused_in_one_line(arguments: tuple[object, ...], words: tuple[str, ...]):
    line = refused("bound", *arguments)
    for word in words:
        assert word in line


def test_an_answer_that_cannot_be_written_is_refused(tmp_path: Path):
    (tmp_path / "file").write_text("x")
    assert "cannot be written" in refused("bound", "hexapod", "--model", 2, "-o", tmp_path / "file" / "bound.json")
