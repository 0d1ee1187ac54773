"""A study folder: a Parquet file for each finished cell, with a row for its plan and one for each seed of the noise."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.basis import KEPT, Artefact
from cases.errors import FileProblem
from cases.files import atomic_file, json_text, read_json, write_text

if TYPE_CHECKING:
    import pyarrow as pa


SETTINGS = ("family", "criterion", "model", "duration_s", "order", "period_s", "moves", "knots", "payload", "seed")
PLANNED = -1  # noise seed of the row that holds the plan itself

DONE, FAILED = "done", "failed"


def schema() -> "pa.Schema":
    """Columns of the rows and their types."""
    import pyarrow as pa

    text, whole, number = pa.string(), pa.int64(), pa.float64()
    columns = {
        text: "cell case_hash version family criterion status reason",
        whole: "noise_seed model order moves knots payload seed iterations parameters inside_95",
        number: "duration_s period_s seconds score logdet d_efficiency worst_error_in_std mass_error_kg mass_std_kg",
        pa.bool_(): "converged",
    }
    return pa.schema([(name, kind) for kind, names in columns.items() for name in names.split()])


def completed(row: dict[str, Any]) -> dict[str, Any]:
    """The row with every column; what is not known is null."""
    columns = schema().names
    unknown = set(row) - set(columns)
    if unknown:
        raise ValueError(f"no such columns: {', '.join(sorted(unknown))}")
    return {name: row.get(name) for name in columns}


ABOUT = "study.json"
ROWS = "rows"


def open_study(folder: Path, about: dict[str, Any]) -> None:
    """Makes a study folder, or finds that an older one is of the same study.

    Args:
        about: what study.json holds; `name` and what was used of the case must be those of the study there.

    Raises:
        FileProblem: another study's or somebody else's folder, or no place to write.
    """
    check_study(folder, about)
    try:
        (folder / ROWS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileProblem(folder, f"cannot be written ({error.strerror})", "choose another place with -o") from error
    write_text(folder / ABOUT, json_text(about))


def keep(folder: Path, name: str, rows: Sequence[dict[str, Any]]) -> None:
    """Writes the rows of one cell to a file of their own, `rows/NAME.parquet`: all of them or, if killed here, none.

    Raises:
        FileProblem: the disk is full or gone.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    with atomic_file(folder / ROWS / f"{name}.parquet") as part:
        pq.write_table(pa.Table.from_pylist([completed(row) for row in rows], schema()), part)


def check_study(folder: Path, about: dict[str, Any]) -> None:
    """Says before the work starts what would keep a study from its folder.

    Args:
        folder: folder of the study; need not exist.

    Raises:
        FileProblem: another study's folder, or somebody else's.
    """
    try:
        names = {entry.name for entry in folder.iterdir()} if folder.exists() else set()
    except OSError as error:
        raise FileProblem(folder, f"cannot be read ({error.strerror})", "choose another place with -o") from error
    if ABOUT not in names:
        if names:
            first = sorted(names)[0]
            raise FileProblem(folder, f"is not a study of hexcite's (it holds {first})", "choose another with -o")
        return
    record = read_json(folder / ABOUT, "hexcite study")
    if record.get("name") != about["name"]:
        raise FileProblem(
            folder, f"holds another study ({record.get('name')}, not {about['name']})", "choose another place with -o"
        )
    if changes := Artefact(folder / ABOUT, record, "").changes(about[KEPT], about["case_hash"]):
        raise FileProblem(
            folder,
            f"holds a study of case {record.get('case')} before {changes[0]}",
            "choose another place with -o, or restore the case",
        )


def read_rows(folder: Path) -> "pa.Table":
    """All rows of a study, each once.

    Raises:
        FileProblem: a file is damaged.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    tables = [schema().empty_table()]
    for file in sorted((folder / ROWS).glob("*.parquet")):
        try:
            tables.append(pq.read_table(file, schema=schema(), partitioning=None))
        except (OSError, pa.ArrowException) as error:
            raise FileProblem(file, f"is damaged ({error})", "delete it, its cells are then computed again") from error
    table = pa.concat_tables(tables)
    number = table.append_column("row", pa.array(range(len(table))))
    last = number.group_by(["cell", "noise_seed"]).aggregate([("row", "max")])["row_max"]
    return table.take(last.sort()) if len(table) else table
