"""JSON objects survive the way through a file; what is none is named with the command that writes such files."""

import json
from pathlib import Path

import pytest

from cases.base.atomic import write_text
from cases.base.errors import FileProblem
from cases.base.file_reading import read_json
from cases.base.text_formats import json_text
from tests.helpers import one_line


def test_json_survives_the_way_through_its_file(tmp_path: Path) -> None:
    value = {"m": 31.83, "names": ["xC", "φ"], "none": None, "deep": {"k": [1, 2.5e-7]}}
    write_text(tmp_path / "r.json", json_text(value))
    assert read_json(tmp_path / "r.json", "hexcite identify") == value == json.loads(json_text(value))


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_is_not_json_is_not_written(value: float) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_text({"x": value})


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"{", "is not JSON"),
        (b"[1]", "holds no JSON object"),
        (b"", "is not JSON"),
        (b"\xff\xfe{}", "is not JSON"),
        (b'{"m": NaN}', "is not JSON"),
        (b'{"m": -Infinity}', "is not JSON"),
    ],
)
def test_what_is_not_a_json_object_is_named_with_its_maker(content: bytes, says: str, tmp_path: Path) -> None:
    (tmp_path / "r.json").write_bytes(content)
    with pytest.raises(FileProblem, match=rf"r\.json: {says}.*hexcite plan") as caught:
        read_json(tmp_path / "r.json", "hexcite plan")
    one_line(caught.value)


def test_a_json_file_that_is_missing_is_named_with_its_maker(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"r\.json: .*No such file.*hexcite plan"):
        read_json(tmp_path / "r.json", "hexcite plan")


def test_who_names_another_file_is_not_told_to_write_it_again(tmp_path: Path) -> None:
    (tmp_path / "run.ngc").write_text("G21 G90\n")
    with pytest.raises(FileProblem) as caught:
        read_json(tmp_path / "run.ngc", "hexcite identify")
    assert "write it again" not in str(caught.value)
    assert "hexcite identify" in str(caught.value)
