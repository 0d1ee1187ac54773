"""The command line as its users call it: in a process of its own, or in this one where the import time would add up."""

import contextlib
import io
import json
import subprocess
import sys
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import pytest
from hypothesis import settings

from cases.base.errors import Code
from hexcite.cli import main
from hexcite.reports.drawing import still
from hexcite.reports.drawing.chart import Chart
from hexcite.reports.drawing.scene import Scene
from tests.helpers import EXAMPLES
from tests.hexcite.json_answer import one_json_object

PROGRAM = Path(sys.executable).with_name("hexcite")
ACCEPT = (
    "--accept",
    "acceleration,jerk,strut-acceleration,sensor-force",
)  # what LinuxCNC does not enforce on a timed path


drawn: dict[Hashable, str] = {}  # by the kind of figure


def _like_the_first(draw: Callable[[Any], str]) -> Callable[[Any], str]:
    """Draws the first figure or machine of each kind; others of the kind get its picture."""

    def picture(of: Chart | Scene) -> str:
        kind = _kind(of) if isinstance(of, Chart) else (of.steps, len(of.parts))
        if kind not in drawn:
            drawn[kind] = draw(of)
        return drawn[kind]

    return picture


def _kind(chart: Chart) -> Hashable:
    """All of a figure but its numbers and names."""
    looks = ("width", "dash", "dots", "hollow", "in_legend")
    series = frozenset((type(each), *(getattr(each, look, None) for look in looks)) for each in chart.series)
    axes = [(axis.logarithmic, axis.ends is None, bool(axis.names), axis.tilt) for axis in (chart.x, chart.y)]
    rules = frozenset((rule.axis, rule.dash) for rule in chart.rules)
    return series, *axes, rules, len(chart.bands), bool(chart.legend), chart.height, chart.half


class Answer(NamedTuple):
    """What a command left: exit code, standard output and standard error."""

    code: int
    out: str
    err: str

    def json(self) -> dict[str, Any]:
        """The one JSON object that stands on standard output of a command that succeeded."""
        assert (self.code, self.err) == (0, "")
        return one_json_object(self.out)

    def refusal(self) -> str:
        """The one line on standard error of a command that failed, which is not a bug's."""
        assert self.code == 1, self
        assert self.err.endswith("\n")
        (line,) = self.err.splitlines()
        assert line.startswith("hexcite: ")
        assert "internal error" not in line, line
        assert "Traceback" not in line, line
        return line


def hexcite(*arguments: object, cwd: Path | None = None) -> Answer:
    """Runs a command in a process of its own."""
    run = subprocess.run([PROGRAM, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=1200)
    return Answer(run.returncode, run.stdout, run.stderr)


@contextlib.contextmanager
def _arguments(arguments: tuple[object, ...]) -> Iterator[None]:
    before, sys.argv = sys.argv, ["hexcite", *map(str, arguments)]
    try:
        yield
    finally:
        sys.argv = before


pictures = {"every": False}  # whether pages show every figure's own picture, as with the profile `full` they do


@contextlib.contextmanager
def _pictures() -> Iterator[None]:
    """To draw the figures of a page takes as long as to identify."""
    if pictures["every"] or settings.default.max_examples >= EXAMPLES:
        yield
    else:
        with (
            patch.object(still, "picture", _like_the_first(still.picture)),
            patch.object(still, "machine_picture", _like_the_first(still.machine_picture)),
        ):
            yield


def call(*arguments: object) -> Answer:
    """Runs a command through its entry point in this process.

    Figures of a page that are alike show the picture of the first of them, but where the fixture `every_picture` is.
    """
    out, err = io.StringIO(), io.StringIO()
    with _arguments(arguments), _pictures(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    return Answer(code, out.getvalue(), err.getvalue())


def refused(*arguments: object) -> str:
    """The one line with which a command is refused; on standard output stands the error, where JSON is asked for."""
    answer = call(*arguments)
    if "--json" in arguments:
        error = json.loads(answer.out)["error"]
        assert error["code"] in list(Code)
        assert error["problem"] in answer.err
    else:
        assert answer.out == ""
    return answer.refusal()


def skip_without(path: Path) -> pytest.MarkDecorator:
    """Skips where data beside the checkout are missing, saying so."""
    return pytest.mark.skipif(not path.exists(), reason=f"{path} is missing")
