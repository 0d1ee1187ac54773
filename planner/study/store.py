"""A study folder: rows that arrive one by one and are never lost, computed twice or mixed with another study's.

A row goes to `journal.jsonl` first, flushed to the disk; many rows are moved to a Parquet file at once. A
process that is killed in between leaves rows in both, and reading counts them once.
"""

import fcntl
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.basis import KEPT, Artefact
from cases.errors import FileProblem
from cases.files import atomic_file, json_text, read_json, write_text

if TYPE_CHECKING:
    import pyarrow as pa


SETTINGS = (
    "family",
    "criterion",
    "model",
    "duration_s",
    "order",
    "period_s",
    "moves",
    "knots",
    "payload",
    "seed",
)
PLANNED = -1  # noise seed of the row that holds the plan itself

DONE, FAILED = "done", "failed"


def schema() -> "pa.Schema":
    """Columns of the rows and their types."""
    import pyarrow as pa

    text, whole, number = pa.string(), pa.int64(), pa.float64()
    return pa.schema(
        [
            ("cell", text),
            ("noise_seed", whole),
            ("case_hash", text),
            ("version", text),
            ("family", text),
            ("criterion", text),
            ("model", whole),
            ("duration_s", number),
            ("order", whole),
            ("period_s", number),
            ("moves", whole),
            ("knots", whole),
            ("payload", whole),
            ("seed", whole),
            ("status", text),
            ("reason", text),
            ("tries", whole),
            ("seconds", number),
            ("worker", text),
            ("converged", pa.bool_()),
            ("iterations", whole),
            ("score", number),
            ("logdet", number),
            ("d_efficiency", number),
            ("parameters", whole),
            ("inside_95", whole),
            ("worst_error_in_std", number),
            ("mass_error_kg", number),
            ("mass_std_kg", number),
        ]
    )


def completed(row: dict[str, Any]) -> dict[str, Any]:
    """The row with every column; what is not known is null."""
    known = schema().names
    unknown = set(row) - set(known)
    if unknown:
        raise ValueError(f"no such columns: {', '.join(sorted(unknown))}")
    return {name: row.get(name) for name in known}


ABOUT = "study.json"
JOURNAL = "journal.jsonl"
LOCK = "study.lock"
ROWS = "rows"
COMPACT = 5000  # rows of the journal from which they are moved to Parquet


class Store:
    """The rows of a study. Made by `opened`.

    Args:
        folder: of the study.
        schema: of the rows; the columns `cell` and `noise_seed` tell them apart.
    """

    def __init__(self, folder: Path, schema: "pa.Schema") -> None:
        self._folder, self._schema = folder, schema
        self._pending = len(_journal(folder))

    def add(self, rows: Sequence[dict[str, Any]]) -> None:
        """Keeps the rows of one cell: all of them or, if the process is killed here, none.

        Raises:
            FileProblem: the disk is full or gone.
        """
        line = json.dumps(list(rows), allow_nan=False) + "\n"
        try:
            with (self._folder / JOURNAL).open("a", encoding="utf-8") as file:
                file.write(line)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise FileProblem(
                f"{self._folder / JOURNAL}: cannot be written ({error.strerror}); what is done so far is kept"
            ) from error
        self._pending += len(rows)
        if self._pending >= COMPACT:
            self.compact()

    def compact(self) -> None:
        """Moves the journal's rows to a Parquet file."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        rows = _journal(self._folder)
        if not rows:
            return
        (self._folder / ROWS).mkdir(exist_ok=True)
        number = 1 + max((int(p.stem) for p in (self._folder / ROWS).glob("*.parquet")), default=0)
        with atomic_file(self._folder / ROWS / f"{number:06d}.parquet") as part:
            pq.write_table(pa.Table.from_pylist(rows, self._schema), part)
        write_text(self._folder / JOURNAL, "")
        self._pending = 0


@contextmanager
def opened(folder: Path, schema: "pa.Schema", about: dict[str, Any]) -> Iterator[Store]:
    """Opens a study folder for writing, new or to go on with; nobody else writes to it meanwhile.

    Args:
        folder: of the study.
        schema: of its rows.
        about: what study.json holds; `name` and what was used of the case must be those of the study there.

    Raises:
        FileProblem: another study's or somebody else's folder, one that is being written to, or no place to write.
    """
    check_study(folder, about)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileProblem(f"{folder}: cannot be written ({error.strerror}); choose another place with -o") from error
    with (folder / LOCK).open("a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise FileProblem(f"{folder}: another process is at work on this study; wait for it or use -o") from error
        write_text(folder / ABOUT, json_text(about))
        store = Store(folder, schema)
        store.compact()  # a killed process may have left half a line, which the next would be appended to
        try:
            yield store
        finally:
            store.compact()


def check_study(folder: Path, about: dict[str, Any]) -> None:
    """Says before the work starts what would keep a study from its folder.

    Args:
        folder: of the study; need not exist.
        about: as for `opened`.

    Raises:
        FileProblem: another study's folder, or somebody else's.
    """
    try:
        names = {entry.name for entry in folder.iterdir()} if folder.exists() else set()
    except OSError as error:
        raise FileProblem(f"{folder}: cannot be read ({error.strerror}); choose another place with -o") from error
    if ABOUT not in names:
        if names - {LOCK}:
            first = sorted(names)[0]
            raise FileProblem(f"{folder}: is not a study of hexcite's (it holds {first}); choose another with -o")
        return
    held = read_json(folder / ABOUT, "hexcite study")
    if held.get("name") != about["name"]:
        raise FileProblem(
            f"{folder}: holds another study ({held.get('name')}, not {about['name']}); choose another place with -o"
        )
    if changes := Artefact(folder / ABOUT, held, "").changes(about[KEPT], about["case_hash"]):
        raise FileProblem(
            f"{folder}: holds a study of case {held.get('case')} before {changes[0]}; choose another place with -o, or "
            "restore the case"
        )


def _journal(folder: Path) -> list[dict[str, Any]]:
    """Rows of the journal; a last line that was cut off when the process was killed is not one."""
    file = folder / JOURNAL
    if not file.exists():
        return []
    rows: list[dict[str, Any]] = []
    for line in file.read_text(encoding="utf-8", errors="replace").split("\n"):
        try:
            rows += json.loads(line)
        except ValueError:
            continue
    return rows


def read_rows(folder: Path, schema: "pa.Schema") -> "pa.Table":
    """All rows of a study, each once: the last one where a cell was tried again.

    Args:
        folder: of the study.
        schema: of its rows.

    Raises:
        FileProblem: a file is damaged.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    tables = []
    for file in sorted((folder / ROWS).glob("*.parquet")):
        try:
            tables.append(pq.read_table(file, schema=schema))
        except (OSError, pa.ArrowException) as error:
            raise FileProblem(f"{file}: is damaged ({error}); delete it, its cells are then computed again") from error
    table = pa.concat_tables([*tables, pa.Table.from_pylist(_journal(folder), schema)])
    number = table.append_column("row", pa.array(range(len(table))))
    last = number.group_by(["cell", "noise_seed"]).aggregate([("row", "max")])["row_max"]
    return table.take(last.sort()) if len(table) else table
