"""The command line, `hexcite`: commands that belong together in a file; this one turns every outcome into an exit code.

Heavy imports happen inside the commands, so that `hexcite --help` stays fast.
"""

import gc
import io
import logging
import os
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import typer

# Before NumPy is loaded. Matrices here are small: a second thread of its linear algebra only waits for the first, and
# on a machine that works on something else it waits for long. `identify` of the library limits itself; the planner does
# not, and its worker processes take the setting from here.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from cases.errors import FileProblem, HexciteError, Interrupted
from planner.cli import cases, compare, demo, force, identify, limits, plan, poses, programs, study

app = typer.Typer(
    name="hexcite",
    help="Plans, programs and evaluates the motion that calibrates a force-measuring machine in seconds.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.command("cases")(cases.list_cases)
app.add_typer(cases.app, name="case")
for command in (
    plan.plan, poses.poses, programs.post, programs.check, programs.run, identify.look, identify.identify,
    force.force, force.tare, force.payload, force.export, limits.bound, study.study, limits.retime,
    compare.compare, compare.validate, demo.demo,
):  # fmt: skip
    app.command()(command)


def main() -> None:
    """Entry point: 0 done, 1 a line on stderr for each reason why not, 2 wrong usage, 130 interrupted."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # where the terminal's letters are fewer than ours
    gc.set_threshold(100_000)  # the usual 700 looks through all that imports create, again and again
    try:
        with ctrl_c_raises(), warnings_on_stderr():
            app()
    except HexciteError as error:
        _stop(*error.lines)
    except Interrupted as error:
        print(f"hexcite: interrupted; {str(error) or 'nothing was written'}", file=sys.stderr)
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
    handler, log, said = logging.StreamHandler(sys.stderr), logging.getLogger("hexcite"), set[str]()

    def first(record: logging.LogRecord) -> bool:
        new = record.getMessage() not in said
        said.add(record.getMessage())
        return new

    handler.addFilter(first)
    handler.setFormatter(logging.Formatter("hexcite: %(message)s"))
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)


@contextmanager
def ctrl_c_raises() -> Iterator[None]:
    """Inside, Ctrl-C raises `Interrupted`."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise Interrupted

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _stop(*lines: str) -> None:
    for line in lines:
        print(f"hexcite: {' '.join(line.split())}", file=sys.stderr)
    sys.exit(1)
