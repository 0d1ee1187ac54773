"""What commands print: one JSON object, or tables for people; progress goes to stderr, and only to a terminal."""

import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cases.files import FolderKind, atomic_folder
from identification.precision import bounds_text, share_text

if TYPE_CHECKING:
    from identification.limit import LimitCheck


LONGEST_NUMBER = 12  # characters
FOLDED = 12  # fewest characters of a column of words
EDGES, GAP = 2, 3  # characters around a table, and between its columns
EVERY = 10.0  # [s] between two lines of progress where there is no terminal
WIDEST = 1000  # characters that a table may take

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what an earlier run wrote there.")]
OwnCase = Annotated[
    str | None, typer.Option("--case", help="Built-in name, folder or case file; a plan, run or result knows its own.")
]
Stale = Annotated[
    bool, typer.Option("--stale", help="Go on although the case has changed since; what is written says so.")
]
Workers = Annotated[int | None, typer.Option(help="Processes on this computer; by default one a core.")]
Criterion = Annotated[
    str,
    typer.Option(
        help="What to optimise, Table 4: A average variance, D volume of the confidence ellipsoid, K condition, N "
        "noise amplification."
    ),
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


def answered(answer: dict[str, Any], as_json: bool) -> bool:
    """Prints the answer as one JSON object where that was requested; returns whether it was."""
    if as_json:
        print(json.dumps(answer, allow_nan=False))
    return as_json


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], right: bool = True) -> None:
    """Prints a table; all columns but the first are numbers unless `right` is False.

    A terminal too narrow for it folds words, never numbers; a pipe gets every row on one line.
    """
    from rich import box
    from rich.console import Console
    from rich.measure import Measurement
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    console = Console(markup=False)  # units in brackets and names of files are text
    narrowest = EDGES
    for k, column in enumerate(columns):
        words = k == 0 or not right or _are_words([row[k] for row in rows])
        folds = console.is_terminal and (words or any(_is_sentence(row[k]) for row in rows))
        table.add_column(column, justify="left" if words else "right", no_wrap=not folds, overflow="fold")
        longest = max(map(len, (column, *(row[k] for row in rows))))
        narrowest += GAP + (min(longest, FOLDED) if folds else longest)
    for row in rows:
        table.add_row(*row)
    if not console.is_terminal:
        narrowest = Measurement.get(console, console.options.update(width=WIDEST), table).maximum
    console.width = max(console.width, narrowest)
    console.print(table)


def _is_sentence(cell: str) -> bool:
    return len(cell) > LONGEST_NUMBER and not cell.lstrip("~-")[:1].isdigit()


def _are_words(cells: Sequence[str]) -> bool:
    """Whether a column holds sentences, as a status does, not numbers with their units."""
    return any(len(cell) > LONGEST_NUMBER for cell in cells) and not any(cell[:1].isdigit() for cell in cells)


@contextmanager
def status(text: str, quiet: bool) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr; yields a function that shows a remark beside it, without a terminal as a line every 10 s."""
    from rich.console import Console

    console = Console(stderr=True)
    if quiet:
        yield lambda _: None
        return
    if console.is_terminal:
        with console.status(text) as spinner:
            yield lambda remark: spinner.update(f"{text}: {remark}")
        return
    last_report = time.monotonic()

    def say(remark: str) -> None:
        nonlocal last_report
        if time.monotonic() - last_report >= EVERY:
            last_report = time.monotonic()
            print(f"{text}: {remark}", file=sys.stderr, flush=True)

    yield say


def limit_rows(checks: Iterable["LimitCheck"]) -> list[list[str]]:
    """Rows of a limit report; values that follow from a controller's own time law are predictions, marked with ~."""
    rows = []
    for check in checks:
        proven = check.status == "proven"
        about, words = "" if proven else "~", "EXCEEDED" if proven and not check.kept else str(check.status)
        share = f"{about}{share_text(check.ratio)}"
        rows.append([check.name, f"{about}{check.worst:.4g}", bounds_text(check), check.unit, share, words])
    return rows


LIMIT_COLUMNS = ("limit", "worst", "allowed", "unit", "used", "status")


def save_with_page(value: Any, kind: FolderKind, folder: Path, overwrite: bool) -> None:
    """Writes a value with its page, report.html; raises FileProblem where the folder is taken or cannot be written."""
    from planner.reports import page_of

    with atomic_folder(folder, kind, overwrite) as part:
        value.write(part)
        (part / "report.html").write_text(page_of(value), encoding="utf-8")
