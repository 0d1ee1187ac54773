"""The command line, `hexcite`: commands that belong together in a file; this one turns every outcome into an exit code.

Heavy imports happen inside the commands, so that `hexcite --help` stays fast.
"""

import gc
import io
import json
import logging
import os
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer
from platformdirs import user_cache_path

# Before NumPy is loaded. Matrices here are small: a second thread of its linear algebra only waits for the first, and
# on a machine that works on something else it waits for long. `identify` of the library limits itself; the planner does
# not, and its worker processes take the setting from here.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from cases.base.atomic import WRITTEN
from cases.base.errors import AT_OWN_RISK, UNTOUCHED, FileProblem, HexciteError, Interrupted
from hexcite.cli import cases, compare, console, demo, identify, limits, page, plan, poses, programs, results, study
from hexcite.cli import use as force

app = typer.Typer(
    name="hexcite",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(asked: bool) -> None:
    if asked:
        from hexcite._version import __version__

        print(f"hexcite {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and end.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Plans, programs and evaluates the motion that calibrates a force-measuring machine in seconds."""


app.command("cases")(cases.list_cases)
app.add_typer(cases.app, name="case")
for command in (
    plan.plan, poses.poses, programs.post, programs.check, programs.run, identify.look, identify.identify,
    results.pool, results.history, results.accept, results.certificate,
    force.force, force.tare, force.payload, force.export,
    limits.bound, study.study, limits.retime, compare.compare, compare.validate, demo.demo,
    page.page,
):  # fmt: skip
    app.command()(command)


def main(own_risk: bool = True) -> None:
    """Entry point: 0 done, 1 a line on stderr for each reason why not, 2 wrong usage, 130 interrupted.

    Interrupted is a command by Ctrl-C, and where it is to end: kill, a terminal that is closed.

    Args:
        own_risk: whether errors offer what is done at one's own risk, by an option that a page does not have.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # where the terminal's letters are fewer than ours
    gc.set_threshold(100_000)  # the usual 700 looks through all that imports create, again and again
    written: list[str] = []
    console.given.clear()
    try:
        with ctrl_c_raises(), warnings_on_stderr(), noted(written):
            app()
    except HexciteError as refusal:
        error = refusal if own_risk else refusal.without(AT_OWN_RISK)
        if "--json" in sys.argv and not console.given:
            print(json.dumps({"error": error.to_json()}), flush=True)
        _stop(*error.lines)
    except Interrupted as error:
        there = f"interrupted; {', '.join(written)} stand{'s' * (len(written) == 1)} there" if written else UNTOUCHED
        print(f"hexcite: {f'interrupted; {error}' if str(error) else there}", file=sys.stderr)
        sys.exit(130)
    except OSError as error:
        _stop(*FileProblem.of(error).lines)
    except Exception as error:  # a bug of ours: still no traceback unless asked for
        if os.environ.get("HEXCITE_TRACEBACK"):
            traceback.print_exc()
        _stop(f"internal error, {type(error).__name__}: {error}; please report it (HEXCITE_TRACEBACK=1 shows where)")


@contextmanager
def warnings_on_stderr() -> Iterator[None]:
    """Inside, what the library logs as a warning is a line on stderr, once."""
    handler, log, earlier = logging.StreamHandler(sys.stderr), logging.getLogger("hexcite"), set[str]()

    def first(record: logging.LogRecord) -> bool:
        new = record.getMessage() not in earlier
        earlier.add(record.getMessage())
        return new

    handler.setLevel(logging.WARNING)
    handler.addFilter(first)
    handler.setFormatter(logging.Formatter("hexcite: %(message)s"))
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)


@contextmanager
def noted(written: list[str]) -> Iterator[None]:
    """Inside, names of files and folders are added as they appear; what is kept for later commands is none of them."""
    cache = user_cache_path("hexcite")

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if not Path(name := record.getMessage()).is_relative_to(cache):
                written[:] = dict.fromkeys([*written, name])

    handler, before = Handler(), WRITTEN.level
    WRITTEN.addHandler(handler)
    WRITTEN.setLevel(logging.INFO)
    try:
        yield
    finally:
        WRITTEN.removeHandler(handler)
        WRITTEN.setLevel(before)


ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals by which a command is asked to end."""


@contextmanager
def ctrl_c_raises() -> Iterator[None]:
    """Inside, Ctrl-C raises `Interrupted`, and so does what else asks the process to end."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise Interrupted

    before = {number: signal.getsignal(number) for number in ENDING}
    for number, handler in list(before.items()):
        if handler is None or (handler is signal.SIG_IGN and number != signal.SIGINT):  # as under nohup
            del before[number]
    for number in before:
        signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(*lines: str) -> None:
    for line in lines:
        print(f"hexcite: {' '.join(line.split())}", file=sys.stderr)
    sys.exit(1)
