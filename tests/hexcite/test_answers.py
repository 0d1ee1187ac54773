"""`--json`: one JSON object with the promised keys on standard output, and nothing else anywhere."""

import re
from pathlib import Path
from typing import Any

import pytest

import hexcite
from cases.base.errors import NotProven, Violation
from cases.schema import load_case
from tests.hexcite.command_line import ACCEPT, call
from tests.hexcite.json_answer import one_json_object

Chain = dict[str, dict[str, Any]]

KEYS = {  # that other programs may rely on
    "plan": "plan family criterion status duration_s solve_s starts logdet condition d_efficiency predicted_std limits",
    "post": "program dialect blocks duration_s limits",
    "check": "ok violations duration_s limits",
    "run": "recording samples duration_s planned_s path_error_mm d_efficiency",
    "identify": "result model s0 white_noise s0_N samples rank condition parameters warnings",
}
LIMIT = {"kind", "box", "move", "place", "at", "worst", "limit", "unit", "ratio", "time_s", "status"}
PROMISES = {"proven", "enforced by controller", "NOT enforced"}


@pytest.mark.parametrize("command", KEYS)
def test_a_command_answers_with_the_promised_keys(command: str, chain: Chain):
    assert set(KEYS[command].split()) <= set(chain[command])


@pytest.mark.parametrize("command", ["plan", "post", "check"])
def test_every_limit_comes_with_its_worst_case_and_says_who_answers_for_it(command: str, chain: Chain):
    limits = chain[command]["limits"]
    assert len(limits) >= 14
    for name, limit in limits.items():
        assert LIMIT <= set(limit) <= LIMIT | {"bounds"}, name
        assert limit["status"] in PROMISES
        assert limit["ratio"] >= 0.0
        assert limit["ratio"] <= 1.0 or limit["status"] == "NOT enforced"


def test_every_parameter_comes_with_both_standard_deviations_and_its_unit(chain: Chain):
    for name, p in chain["identify"]["parameters"].items():
        assert set(p) == {"value", "std", "std_robust", "unit"}, name
        assert p["std"] > 0.0 < p["std_robust"]


def test_the_paths_in_the_answers_are_those_that_were_asked_for(chain: Chain, shared: Path):
    asked = {"post": ("program", "excitation.ngc"), "run": ("recording", "recording"), "identify": ("result", "result")}
    for command, (key, name) in asked.items():
        assert chain[command][key] == name
        assert (shared / name).exists()


def test_cases_lists_the_built_in_cases():
    rows = call("cases", "--json").json()["cases"]
    assert {r["name"] for r in rows} == {
        "hexapod",
        "strut_sensors",
        "ft_wrist",
        "clamping_table",
        "ur10_wrist",
        "five_axis_table",
    }
    assert all(Path(r["file"]).is_file() for r in rows)


@pytest.mark.parametrize("case", ["hexapod", "ft_wrist", "clamping_table"])
def test_case_check_answers_with_figures(case: str):
    answer = call("case", "check", case, "--json").json()
    assert answer["ok"] is True
    assert answer["figures"]["name"] == case
    assert answer["figures"]["hash"] == load_case(case).hash


def test_force_answers_with_what_is_left_of_a_run_without_contact(chain: Chain, shared: Path, tmp_path: Path):
    files = (shared / "recording", "--parameters", shared / "result")
    answer = call("force", *files, "-o", tmp_path / "force.csv", "--json").json()
    assert {"rms", "peak"} <= set(answer)
    assert len(answer["rms"]) == len(answer["peak"]) == 6
    for axis, rms in answer["rms"].items():
        assert 0.0 < rms <= answer["peak"][axis]
        assert rms < 2.0  # [N, N m]: the noise of a newton a sensor, behind the filter


def test_a_check_that_fails_still_answers(chain: Chain, shared: Path, tmp_path: Path):
    lines = (shared / "excitation.ngc").read_text().splitlines()
    line = (lines.index("M62 P0") + lines.index("M65 P0")) // 2  # in the middle of the excitation
    lines[line] = re.sub(r" Y-?", " Y9", lines[line], count=1)
    (tmp_path / "edited.ngc").write_text("\n".join(lines))
    code, out, err = call("check", tmp_path / "edited.ngc", "--case", "hexapod", "--json")
    assert code == 1
    assert len(err.splitlines()) == 1
    answer = one_json_object(out)
    assert answer["ok"] is False
    assert abs(answer["violations"][0]["line"] - (line + 1)) <= 2
    assert len(answer["violations"]) > 2
    assert f"({len(answer['violations']) - 1} more: --all shows them)" in err
    listed = call("check", tmp_path / "edited.ngc", "--case", "hexapod", "--all")
    assert "--all" not in listed.err  # which was asked for
    shown = listed.out.splitlines()
    assert [f"line {v['line']}: {v['sentence']}" in shown for v in answer["violations"]] == [True] * len(
        answer["violations"]
    )


@pytest.mark.parametrize("options", [(), ("--all",), ("--json",), ("--all", "--json")])
def test_a_program_that_is_not_written_says_every_limit_that_it_exceeds(
    options: tuple[str, ...], shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    violations = [Violation(7, "jerk", "jerk (x) reaches 101"), Violation(9, "velocity", "velocity (x) reaches 7")]

    def written(*_: object, **__: object) -> None:
        raise NotProven(file="p.ngc", violations=violations, remedy="slow down")

    monkeypatch.setattr(hexcite, "write", written)
    code, out, err = call("post", shared / "plan", "-o", tmp_path / "p.ngc", *options)
    assert (code, len(err.splitlines()), (tmp_path / "p.ngc").exists()) == (1, 1, False)
    others = "1 more, as listed" if "--all" in options else "1 more: --all shows them"
    assert f"line 7: jerk (x) reaches 101; slow down ({others})" in err
    if "--json" in options:
        assert one_json_object(out) == {"ok": False, "violations": [v._asdict() for v in violations]}
    else:
        lines = ["line 7: jerk (x) reaches 101", "line 9: velocity (x) reaches 7"]
        assert out.splitlines() == (lines if options else [])


@pytest.mark.parametrize("command", ["post", "check", "run", "identify"])
def test_without_json_a_command_tells_people_what_it_did(command: str, chain: Chain, shared: Path, tmp_path: Path):
    arguments = {
        "post": (shared / "plan", *ACCEPT, "-o", tmp_path / "p.ngc"),
        "check": (shared / "excitation.ngc", "--case", "hexapod"),
        "run": (shared / "excitation.ngc", "--case", "hexapod", "-o", tmp_path / "recording"),
        "identify": (shared / "recording", "-o", tmp_path / "result"),
    }
    answer = call(command, *arguments[command])
    assert (answer.code, answer.err) == (0, "")
    said = {
        "post": "nobody enforces: sensor force, acceleration, jerk, strut acceleration",
        "check": "nobody enforces: sensor force, acceleration",
        "run": "simulated",
        "identify": "result written",
    }
    assert said[command] in answer.out


def test_an_error_is_a_json_object_where_one_is_asked_for() -> None:
    """With the code by which programs know it; people read the same line on stderr as without."""
    code, out, err = call("bound", "hexapod", "--time-limit", "0", "--json")
    error = one_json_object(out)["error"]
    assert (code, error["code"], error["remedy"]) == (1, "out_of_range", "give seconds above 0, such as 120")
    assert err == call("bound", "hexapod", "--time-limit", "0").err
    assert error["problem"].startswith("--time-limit 0 s")
