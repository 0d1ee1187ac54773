"""`hexcite identify` with what is done to a moving run beforehand."""

import json
from pathlib import Path

import pytest

from cases.loading import load_case
from identification.recording import write_recording
from tests.identification.repeating import Repeating, recorded
from tests.planner.command_line import call, refused

CASE = load_case("hexapod")
TRUTH = {"m": 31.83, "zC": 0.10505, "IC33": 0.91, "k3": 28.27}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of three periods of 1.5 s."""
    file = tmp_path_factory.mktemp("run") / "run.csv"
    write_recording(file, recorded(CASE, Repeating(1.5, 3)), CASE)
    return file


def identify(run: Path, tmp_path: Path, *words: object) -> list[object]:
    return ["identify", run, "--case", "hexapod", "-o", tmp_path / "result", *words]


@pytest.mark.parametrize("words", [("--period", "auto"), ("--period", "1.5s", "--harmonics", 12)])
def test_a_periodic_run_is_averaged(words: tuple, run: Path, tmp_path: Path) -> None:
    answer = call(*identify(run, tmp_path, "--json", *words)).json()
    found = answer["periodic"]
    assert found["period_s"] == pytest.approx(1.5, abs=1e-6)
    assert (found["periods"], found["harmonics_chosen"]) == (3, "auto" in words)
    assert (found["from_s"], found["to_s"]) == (pytest.approx(0.4, abs=2e-3), pytest.approx(4.9, abs=2e-3))
    assert json.loads((tmp_path / "result" / "result.json").read_text())["periodic"] == found
    for name, truth in TRUTH.items():
        p = answer["parameters"][name]
        assert abs(p["value"] - truth) < 4.5 * max(p["std"], p["std_robust"]), name


def test_people_are_told_which_part_was_used(run: Path, tmp_path: Path) -> None:
    text = " ".join(call(*identify(run, tmp_path, "--period", "auto")).out.split())
    assert "3 periods of 1.5 s averaged, from 0.400 to 4.899 s; struts repeat within" in text
    assert "harmonics, up to" in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--period", "soon"), "--period soon: is no period; give auto or seconds"),
        (("--period", "-1"), "--period -1: is no period"),
        (("--period", "nan"), "--period nan: is no period"),
        (("--period", "1.1"), "--period 1.1: a period later the struts are"),
        (("--period", "90"), "fits into it"),
        (("--harmonics", "5"), "add --period auto"),
        (("--period", "auto", "--harmonics", "0"), "--harmonics 0: is no number of harmonics"),
        (("--period", "auto", "--harmonics", "999"), "give 1 to 60"),
    ],
)
def test_what_cannot_be_is_refused(words: tuple, message: str, run: Path, tmp_path: Path) -> None:
    assert message in refused(*identify(run, tmp_path, *words))
    assert not (tmp_path / "result").exists()


def test_a_run_that_does_not_repeat_is_refused_with_what_was_measured(tmp_path: Path) -> None:
    file = tmp_path / "once.csv"
    write_recording(file, recorded(CASE, Repeating(3.0, 1)), CASE)
    assert "not periodic: after the best period" in refused(*identify(file, tmp_path, "--period", "auto"))
