"""Start-up and wrong usage: fast help, exit code 2, and no heavy import before there is work."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cases.schema import load_case
from cases.tables import built_in_cases
from identification.machines.hexapod import Hexapod
from identification.recording.recording import write_recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.hexcite.command_line import PROGRAM, call
from tests.postprocessors.programs import typed
from tests.simulated_machine import PoseExecution

HEAVY = ("casadi", "scipy", "matplotlib", "plotly", "pyarrow", "numpy", "jinja2", "toppra", "ruckig")
WATCH = f"""
import sys
sys.argv = ["hexcite", *sys.argv[1:]]
from hexcite.cli import main
try:
    main()
except SystemExit as stop:
    loaded = [m for m in {HEAVY!r} if m in sys.modules]
    print("LOADED", *loaded)
    sys.exit(stop.code)
"""


@pytest.mark.parametrize("arguments", [("--help",), ("plan", "--help"), ("case", "--help"), ("nonsense",)])
def test_help_imports_nothing_heavy(arguments: tuple[str, ...]):
    run = subprocess.run([sys.executable, "-c", WATCH, *arguments], capture_output=True, text=True, timeout=300)
    assert run.stdout.splitlines()[-1] == "LOADED"
    assert run.returncode == (0 if "--help" in arguments else 2)


def test_a_check_of_moves_imports_what_proves_them_and_no_more(tmp_path: Path):
    program = tmp_path / "moves.ngc"
    program.write_text(typed("M64 P0\nG1 X5 F3000\nM65 P0"))
    words = ("check", str(program), "--case", "hexapod", "--json")
    run = subprocess.run([sys.executable, "-c", WATCH, *words], capture_output=True, text=True, timeout=300)
    assert run.stdout.splitlines()[-1].split()[1:] == ["casadi", "numpy"]


def test_a_plan_loads_neither_identification_nor_most_of_scipy():
    """They take longer to import than a plan of few moves takes."""
    late = ("scipy.linalg", "identification.results.estimate")
    code = f"import planner._plan, sys; print([m for m in {late} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert run.stdout == "[]\n", run.stderr


def test_identify_imports_no_interactive_plots_no_planner_and_no_parts_of_scipy_for_single_functions(tmp_path: Path):
    """Each of them takes as long to import as an identification takes."""
    case = load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=2.0))
    file = tmp_path / "run.csv"
    write_recording(file, simulate_recording(case, execution, np.array([[0.2, 1.8]]), seed=1), case)
    needless = ("matplotlib.pyplot", "plotly.graph_objs", "scipy.signal", "scipy.stats", "cvxpy", "toppra", "ruckig")
    words = ("identify", str(file), "--case", "hexapod", "-o", str(tmp_path / "result"), "--json")
    watch = WATCH.replace(repr(HEAVY), repr((*needless, "planner.plans.making")))
    run = subprocess.run([sys.executable, "-c", watch, *words], capture_output=True, text=True, timeout=300)
    assert run.stdout.splitlines()[-1] == "LOADED", run.stderr


def test_help_lists_every_command_in_a_whole_sentence():
    answer = call("--help")
    assert answer.code == 0
    commands = "cases case plan poses post check run look identify force tare payload export bound study retime"
    for command in (*commands.split(), "compare", "validate", "demo"):
        assert f"\n  {command} " in answer.out
    assert "..." not in answer.out.partition("Commands:")[2]


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("nonsense",),
        ("plan",),
        ("plan", "hexapod", "--nonsense"),
        ("plan", "hexapod", "--family", "fourier", "--order", "five"),
        ("plan", "hexapod", "surplus"),
        ("validate", "hexapod", "--recordings", "runs"),
        ("check", "p.ngc"),
        ("run", "p.ngc"),
        ("identify",),
        ("case", "nonsense"),
    ],
)
def test_wrong_usage_ends_with_2_and_says_how_to_use_it(arguments: tuple[str, ...]):
    answer = call(*arguments)
    assert answer.code == 2
    assert "Usage: hexcite" in answer.out + answer.err
    assert "Traceback" not in answer.err


def test_a_terminal_with_few_letters_gets_escapes(tmp_path: Path):
    """Not an internal error of a command that has succeeded."""
    text = load_case("hexapod").title
    file = tmp_path / "case.toml"
    file.write_text(
        built_in_cases()["hexapod"]
        .read_text(encoding="utf-8")
        .replace(text, "M\N{LATIN SMALL LETTER U WITH DIAERESIS}hle"),
        "utf-8",
    )
    plain = os.environ | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    run = subprocess.run([PROGRAM, "case", "check", file], capture_output=True, env=plain, timeout=120)
    assert (run.returncode, run.stderr) == (0, b"")
    assert b"M\\xfchle" in run.stdout
