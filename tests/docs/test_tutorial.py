"""What the tutorial shows is what its commands print today, word for word and in figures."""

import importlib.util
from pathlib import Path

import pytest

from cases.readiness import readiness
from cases.schema import load_case

DOCS = Path(__file__).parents[2] / "docs"
spec = importlib.util.spec_from_file_location("transcript", DOCS / "transcript.py")
assert spec is not None
assert spec.loader is not None
transcript = importlib.util.module_from_spec(spec)
spec.loader.exec_module(transcript)


@pytest.mark.slow
def test_the_tutorial_shows_what_its_commands_print(tmp_path: Path) -> None:
    page = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    commands = list(transcript.steps_of(page))
    assert len(commands) >= 8
    for command, shown in commands:
        now = transcript.matched(shown, transcript.printed(command, tmp_path))
        for one, line in zip(shown, now, strict=True):
            assert not transcript.far_off(one, line), f"{command}: shows {one!r}, prints {line!r}"


def test_the_case_of_the_second_tutorial_is_a_case(tmp_path: Path) -> None:
    page = (DOCS / "own-machine.md").read_text(encoding="utf-8")
    (tmp_path / "case.toml").write_text(page.split("```toml\n")[1].split("```")[0])
    case = load_case(str(tmp_path))
    assert {command for command, missing in readiness(case).items() if not missing} >= {"identify a motion"}


def test_a_page_is_compared_by_words_and_figures() -> None:
    shown = ["first 1.0 mm", "...", "last 3"]
    assert transcript.matched(shown, ["first 1.1 mm", "more", "last 4"]) == ["first 1.1 mm", "...", "last 4"]
    with pytest.raises(ValueError, match="first"):
        transcript.matched(shown, ["other 1.1 mm", "more", "last 4"])
    with pytest.raises(ValueError, match="does not show"):
        transcript.matched(["first 1"], ["first 1", "second"])
    assert not transcript.far_off("off 1.0 of 12.0 s", "off 1.1 of 12.2 s")
    assert transcript.far_off("off 1.0 of 12.0 s", "off 1.9 of 12.2 s")
    assert not transcript.far_off("strayed 0.001 mm", "strayed 0.002 mm")  # 1.4 and 1.6 um
    assert transcript.far_off("strayed 0.001 mm", "strayed 0.003 mm")
