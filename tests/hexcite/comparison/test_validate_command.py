"""The command `validate`: simulated machines, recordings of a real one, and what it refuses."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser

from hexcite.comparison.trials import METHODS
from tests.helpers import few, tells
from tests.hexcite.browser import opened
from tests.hexcite.command_line import call, refused

Q5N = (1.81, 1.93, 2.07, 2.33, 2.74, 3.14)  # Table 7


@pytest.mark.slow
@pytest.mark.parametrize("weights", few("0", "0,5"))
def test_the_command_prints_table_7_and_says_what_machine_it_was(weights: str, tmp_path: Path, browser: Browser):
    answer = call(
        "validate", "hexapod", "--methods", "Q5N", "--weights", weights, "-o", tmp_path / "v", "--json"
    ).json()
    assert answer["simulated"] is True
    assert "structural mode" in answer["machine"]
    assert answer["not_run"] == {}
    alone, truth = answer["recommendation"]["sentences"]
    assert "nothing to choose from" in alone
    errors = [abs(error) for row in answer["rows"] for error in row["error_in_std"].values()]
    assert tells(truth, f"{sum(error <= 3.0 for error in errors)} of {4 * len(answer['rows'])}", "of the truth")
    assert [row["weights"] for row in answer["rows"]] == [int(k) for k in weights.split(",")]
    for row in answer["rows"]:
        printed = Q5N[row["weights"]]
        assert printed / 1.5 < row["s0_N"] < printed * 1.5
        assert row["duration_s"] == pytest.approx(70.0, abs=2.0)
        assert abs(row["relative_deviation"]["m"]) < 0.02
    held = {p.name for p in (tmp_path / "v").iterdir()}
    assert held == {".hexcite", "report.html", "validation.json", "plans", "programs"}
    assert (tmp_path / "v" / "programs" / "Q5N.mpf").is_file()
    with opened(browser, Path(answer["report"]), 400) as tab:
        assert (tab.errors, tab.requests) == ([], [])
        assert f"{20 * int(weights[-1])} kg" in tab.page.locator("table").nth(2).inner_text()


def test_the_help_names_every_method():
    shown = " ".join(call("validate", "--help").out.replace("│", " ").split())
    assert f"by default all: {', '.join(METHODS)}." in shown


def test_what_cannot_be_validated_is_refused(tmp_path: Path):
    assert "method 'Q6' is unknown" in refused("validate", "hexapod", "--methods", "Q6", "-o", tmp_path / "v")
    assert "name each once" in refused("validate", "hexapod", "--methods", "ptp,ptp", "-o", tmp_path / "v")
    assert "how many are mounted" in refused("validate", "hexapod", "--weights", "1", "-o", tmp_path / "v")
    assert "--starts 1 to 1000" in refused("validate", "hexapod", "--starts", "0", "-o", tmp_path / "v")
    assert "payloads: is missing" in refused("validate", "ft_wrist", "-o", tmp_path / "v")
    assert not (tmp_path / "v").exists()
