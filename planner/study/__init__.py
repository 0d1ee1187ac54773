"""A study: the cells of its file, and its folder with a Parquet file for each finished cell.

A file has a row for the cell's plan and one for each seed of the noise.
"""

import itertools
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from pydantic import BeforeValidator, Field

from cases.basis import KEPT, changes_since
from cases.errors import FileProblem, HexciteError
from cases.files import atomic_file, check_folder, json_text, read_json, write_text
from cases.tables import Part, Positive, read_tables
from planner.families.settings import Fourier, family_class
from planner.request import OWNERS, Request

if TYPE_CHECKING:
    import pyarrow as pa


MOST_CELLS = 1_000_000

T = TypeVar("T")


def _listed(value: object) -> object:
    return value if isinstance(value, list) else [value]


Values = Annotated[tuple[T, ...], BeforeValidator(_listed), Field(min_length=1)]
Whole = Annotated[int, Field(strict=True)]

_USUAL = Request()
OPTIONS = {"duration_s": "duration", "period_s": "period"}  # of settings whose columns carry a unit


class Grid(Part):
    """Values of most settings of `hexcite plan`; every combination is a cell. One value may stand without brackets.

    A model that is not stated is the machine's largest; period, moves and knots fit the duration, as they do there.
    """

    family: Values[str] = ("fourier",)
    criterion: Values[str] = (str(_USUAL.criterion),)
    model: Values[Whole | None] = (None,)
    duration_s: Values[Positive] = (_USUAL.duration,)
    order: Values[Whole] = (Fourier().order,)
    period_s: Values[Positive | None] = (None,)
    moves: Values[Whole | None] = (None,)
    knots: Values[Whole | None] = (None,)
    payload: Values[Whole] = (_USUAL.payload,)
    seed: Values[Whole] = (_USUAL.seed,)


CellSettings = dict[str, Any]
"""One value of each setting of a `Grid`; those of the machine's choice, or of other families, are absent."""


class ExecutionSpec(Part):
    """Settings of the runs: each plan is run and identified with several seeds of the sensors' noise."""

    on: Literal["virtual"] = "virtual"
    disturbed: bool = False
    noise_seeds: Annotated[int, Field(strict=True, ge=1, le=100_000)] = 1


class Cells(Part):
    """Limits of a cell."""

    time_limit_s: Positive = 600.0
    memory_GB: Positive = 2.0


class Spec(Part):
    """A study."""

    schema_version: Literal[1]
    name: str = Field(pattern=r"^[A-Za-z0-9_-]{1,60}$")
    grid: Grid = Grid()
    execute: ExecutionSpec | None = None
    cells: Cells = Cells()

    @property
    def size(self) -> int:
        """Number of combinations of the grid."""
        return math.prod(len(getattr(self.grid, name)) for name in Grid.model_fields)


BUILT_IN = Path(__file__).parent / "specs"


def load_spec(name: str) -> Spec:
    """Reads a study by its built-in name or its file; raises FileProblem or CaseError where it cannot be."""
    files = {file.stem: file for file in sorted(BUILT_IN.glob("*.toml"))}
    path = files.get(name, Path(name))
    if not path.is_file():
        raise FileProblem(name, "cannot be read", f"built-in studies are {', '.join(files)}, else name a TOML file")
    return read_tables(Spec, path)


def settings_of(spec: Spec) -> Iterator[CellSettings]:
    """The settings of every cell, each once, in the order of the grid; HexciteError where they are too many."""
    if spec.size > MOST_CELLS:
        hours = spec.size * 5.0 / 3600.0
        raise HexciteError(
            f"study {spec.name}",
            f"the grid has {spec.size} cells, at most {MOST_CELLS}; at 5 s a cell they would take "
            f"{hours:.0f} hours of one core: list fewer values",
        )
    names = list(Grid.model_fields)
    texts: set[str] = set()
    for values in itertools.product(*(getattr(spec.grid, name) for name in names)):
        settings = dict(zip(names, values, strict=True))
        family = settings["family"]
        # Settings of another family do not make another cell.
        own = [k for k in settings if OWNERS.get(OPTIONS.get(k, k), family) == family]
        settings = {k: settings[k] for k in own if settings[k] is not None}
        text = json.dumps(settings, sort_keys=True)
        if text not in texts:
            texts.add(text)
            yield settings


def request_of(settings: CellSettings) -> Request:
    """The request of a cell, with one start; HexciteError where its settings cannot be planned."""
    ours = {OPTIONS.get(k, k): v for k, v in settings.items()}
    kind = family_class(ours.pop("family"))
    own = {name: ours.pop(name) for name in OWNERS if name in ours}
    return Request(kind(**own), starts=1, **ours)


SETTINGS = tuple(Grid.model_fields)
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


ABOUT = "study.json"
ROWS = "rows"


def open_study(folder: Path, about: dict[str, Any]) -> None:
    """Makes a study folder with study.json."""
    (folder / ROWS).mkdir(parents=True, exist_ok=True)
    write_text(folder / ABOUT, json_text(about))


def keep(folder: Path, name: str, rows: Sequence[dict[str, Any]]) -> None:
    """Writes the rows of one cell to a file of their own, `rows/NAME.parquet`: all of them or, if killed here, none."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    with atomic_file(folder / ROWS / f"{name}.parquet") as part:
        pq.write_table(pa.Table.from_pylist(list(rows), schema()), part)


def check_study(folder: Path, about: dict[str, Any]) -> None:
    """Refuses, before the work starts, a folder that a study cannot use.

    Args:
        about: entries of study.json; `name` and the used part of the case must be those of an existing study.

    Raises:
        FileProblem: the folder belongs to another study or to something else, or cannot be written.
    """
    if not (folder / ABOUT).exists():
        check_folder(folder, ("a study", frozenset({ROWS})), overwrite=True)
        return
    record = read_json(folder / ABOUT, "hexcite study")
    if record.get("name") != about["name"]:
        raise FileProblem(
            folder, f"holds another study ({record.get('name')}, not {about['name']})", "choose another place with -o"
        )
    if changes := changes_since(record, about[KEPT], about["case_hash"]):
        raise FileProblem(
            folder,
            f"holds a study of case {record.get('case')} before {changes[0]}",
            "choose another place with -o, or restore the case",
        )


def read_rows(folder: Path) -> "pa.Table":
    """All rows of a study, each once; FileProblem where a file is damaged."""
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
