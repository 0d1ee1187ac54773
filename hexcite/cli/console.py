"""What commands print: one JSON object, or tables for people; progress goes to stderr, and only to a terminal."""

import json
import logging
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cases.base.atomic import atomic_folder
from cases.base.errors import legible
from cases.base.folder_kinds import FolderKind
from identification.texts import aligned

if TYPE_CHECKING:
    from planner.plans.progress import Standing

EVERY = 10.0  # [s] between two lines of progress where there is no terminal

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what an earlier run wrote there.")]
OwnCase = Annotated[
    str | None, typer.Option("--case", help="Built-in name, folder or case file; a plan, run or result knows its own.")
]
Stale = Annotated[
    bool, typer.Option("--stale", help="Go on although the case has changed since; what is written says so.")
]


def option(text: str, *names: str) -> Any:
    """An option for typer: its meaning, and its names where they differ from the parameter's."""
    return typer.Option(*names, help=text)


def argument(text: str) -> Any:
    """An argument for typer: its meaning."""
    return typer.Argument(help=text)


def out(text: str) -> Any:
    """The option for typer that says where to write."""
    return typer.Option("-o", "--output", help=text)


given: list[dict[str, Any]] = []
"""The JSON object that this run of a command has printed: one at most, also where it ends in an error."""


def answered(answer: dict[str, Any], as_json: bool, *texts: object) -> bool:
    """Prints the answer as one JSON object where that was requested, texts for people else; returns whether it was."""
    for text in [json.dumps(answer, allow_nan=False)] if as_json else texts:
        say(text)
    given.extend([answer] if as_json else [])
    return as_json


@contextmanager
def remedies(as_json: bool) -> Iterator[None]:
    """Inside, an error that keys of the case would mend prints them as JSON before it ends the command."""
    from cases.base.errors import HexciteError

    try:
        yield
    except HexciteError as error:
        if as_json and error.remedies:
            keys = [each.to_json() for each in error.remedies]
            answered({"refused": error.typed, "error": error.to_json(), "remedies": keys}, True)
        raise


def say(*texts: object) -> None:
    """Prints texts for people, without characters that steer a terminal."""
    print(*(legible(str(text)) for text in texts), sep="\n", flush=True)


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Prints a table; every row is a line."""
    say(title, *aligned(columns, *rows), "")


@contextmanager
def status(text: str, quiet: bool) -> Iterator[Callable[[object], None]]:
    """A spinner on stderr; yields a function that shows a remark beside it, without a terminal as a line every 10 s."""
    if quiet:
        yield lambda _: None
        return
    from rich.console import Console
    from rich.text import Text  # names may hold what is markup in a plain string

    console = Console(stderr=True)
    if console.is_terminal:
        with console.status(Text(legible(text))) as spinner:
            yield lambda remark: spinner.update(Text(legible(f"{text}: {remark}")))
        return
    last_report = time.monotonic()

    def report(remark: object) -> None:
        nonlocal last_report
        if time.monotonic() - last_report >= EVERY:
            last_report = time.monotonic()
            print(legible(f"{text}: {remark}"), file=sys.stderr, flush=True)

    yield report


@contextmanager
def causes_followed(remark: Callable[[object], None], as_json: bool = False) -> Iterator[None]:
    """Inside, steps of a search for causes are remarks, or JSON objects on stderr, one a line."""
    from identification.findings.causes.steps import SEARCHING, Standing

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            standing: Standing = vars(record)["standing"]
            if not as_json:
                remark(standing.line)
                return
            with suppress(OSError):  # whoever listened has gone: that ends no search
                print(json.dumps(standing.to_json()), file=sys.stderr, flush=True)

    handler, before = Handler(), SEARCHING.level
    SEARCHING.addHandler(handler)
    SEARCHING.setLevel(logging.INFO)
    try:
        yield
    finally:
        SEARCHING.removeHandler(handler)
        SEARCHING.setLevel(before)


def as_lines() -> "Callable[[Standing], None]":
    """A listener that prints on stderr, as a JSON object a line, where a search stands: whatever is new, or a second
    after the last one.
    """
    shown: tuple[float, tuple[object, ...]] = (-math.inf, ())

    def report(standing: "Standing") -> None:
        nonlocal shown
        news = (standing.done, standing.least, standing.best)
        if news != shown[1] or time.monotonic() - shown[0] >= 1.0:
            shown = time.monotonic(), news
            with suppress(OSError):  # whoever listened has gone: that ends no search
                print(json.dumps(standing.to_json()), file=sys.stderr, flush=True)

    return report


def save_with_page(
    value: Any, kind: FolderKind, folder: Path, overwrite: bool, inside: Mapping[Path, Any] | None = None
) -> None:
    """Writes a value with its page, report.html, and others inside, each into a folder of its own, all or nothing.

    Raises:
        FileProblem: the folder is taken, or cannot be written.
    """
    from hexcite.reports import page_of

    with atomic_folder(folder, kind, overwrite) as part:
        for place, each in {Path(): value, **(inside or {})}.items():
            (part / place).mkdir(parents=True, exist_ok=True)
            each.write(part / place)
            (part / place / "report.html").write_text(page_of(each), encoding="utf-8")
