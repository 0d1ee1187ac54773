"""A study: its file, and the cells that follow from it, each a combination of the grid's settings."""

import itertools
import math
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import BeforeValidator, Field, create_model

from cases.base.errors import Code, FileProblem, HexciteError
from cases.base.options import Declared, Option, options_of
from cases.basis import study_basis
from cases.schema import Case, fingerprint
from cases.tables import Part, Positive, read_tables
from identification.model.model import full_model
from planner.families.settings import family_class
from planner.options import DURATION, OF_FAMILIES, PlanOptions
from planner.request import OWNERS, Request

MOST_CELLS = 1_000_000

T = TypeVar("T")


def _listed(value: object) -> object:
    return value if isinstance(value, list) else [value]


Values = Annotated[tuple[T, ...], BeforeValidator(_listed), Field(min_length=1)]
Whole = Annotated[int, Field(strict=True)]

VARIED = (
    "criterion", "model", "duration", "order", "period", "moves", "knots", "equal_start", "solver", "payload", "seed",
)  # fmt: skip
"""Options of `hexcite plan` that a grid may vary."""
_ALL = {each.name: each for kind in (PlanOptions, *OF_FAMILIES.values()) for each in options_of(kind)}
_ALL["duration"] = Declared("duration", float, DURATION, Option("", unit="s"))  # studies state no targets
OPTIONS = {_ALL[name].key: _ALL[name] for name in VARIED}
"""Options by their keys in a grid."""


def _field(declared: Declared) -> tuple[Any, tuple[object]]:
    """Type and default of a field of the grid; where the machine decides by default, None says so."""
    strict: Mapping[type, Any] = {int: Whole, float: Positive, str: str, bool: bool}
    kind: Any = strict[(get_args(declared.kind) or (declared.kind,))[0]]
    values: Any = Values
    return values[kind if declared.default is not None else kind | None], (declared.default,)


def _made() -> Any:
    """The model of a grid, which no type checker knows before this module runs."""
    fields: dict[str, Any] = {key: _field(declared) for key, declared in OPTIONS.items()}
    return create_model("Grid", __base__=Part, __module__=__name__, family=(Values[str], ("fourier",)), **fields)


Grid = _made()
"""Values of most options of `hexcite plan`, one or a list each; every combination is a cell.

A model that is not stated is the machine's largest; period, moves and knots fit the duration, as they do there.
"""
SETTINGS = tuple(Grid.model_fields)
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
    grid: Grid = Grid()  # type: ignore[valid-type]
    execute: ExecutionSpec | None = None
    cells: Cells = Cells()

    @property
    def size(self) -> int:
        """Number of combinations of the grid."""
        return math.prod(len(getattr(self.grid, name)) for name in SETTINGS)


BUILT_IN = Path(__file__).parent / "specs"


def load_spec(name: str) -> Spec:
    """Reads a study by its built-in name or its file; raises FileProblem or CaseError where it cannot be."""
    files = {file.stem: file for file in sorted(BUILT_IN.glob("*.toml"))}
    path = files.get(name, Path(name))
    if not path.is_file():
        raise FileProblem(
            place=name,
            problem="cannot be read",
            remedy=f"built-in studies are {', '.join(files)}, else name a TOML file",
            code=Code.UNREADABLE,
        )
    return read_tables(Spec, path)


def cells_of(spec: Spec, case: Case) -> dict[str, CellSettings]:
    """Settings of each cell, by a fingerprint of all that its rows follow from.

    Raises:
        HexciteError: a cell cannot be planned, or there are too many.
    """
    if spec.size > MOST_CELLS:
        raise HexciteError(
            place=f"study {spec.name}",
            problem=f"the grid has {spec.size} cells, at most {MOST_CELLS}",
            remedy="list fewer values",
            code=Code.OUT_OF_RANGE,
        )
    executed = None if spec.execute is None else [*spec.execute.model_dump().values(), case.controller_hash]
    behind = [executed, fingerprint(study_basis(case)), version("hexcite")]
    cells = {}
    for values in itertools.product(*(getattr(spec.grid, name) for name in SETTINGS)):
        settings = dict(zip(SETTINGS, values, strict=True))
        family = settings["family"]
        # Settings of another family do not make another cell.
        axes = [k for k in settings if k not in OPTIONS or OWNERS.get(OPTIONS[k].name, family) == family]
        settings = {"model": full_model(case)} | {k: settings[k] for k in axes if settings[k] is not None}
        if settings.get("equal_start"):  # its seed decides nothing
            settings["seed"] = 0
        request_of(settings)
        cells[fingerprint([settings, *behind])] = settings
    return cells


def request_of(settings: CellSettings) -> Request:
    """The request of a cell, with one start; HexciteError where its settings cannot be planned."""
    ours = {OPTIONS[key].name: value for key, value in settings.items() if key != "family"}
    kind = family_class(settings["family"])
    of_family = {name: ours.pop(name) for name in OWNERS if name in ours}
    return Request(kind(**of_family), starts=1, **ours)


def command_of(settings: CellSettings, case: str) -> str:
    """The command line that plans a cell anew, from as many starts as pay."""
    flags = {"family": "family"} | {key: each.flag for key, each in OPTIONS.items() if key != "seed"}
    plain = {flags[key]: value for key, value in settings.items() if key in flags and value is not False}
    words = [f"--{option}" if v is True else f"--{option} {v}" for option, v in plain.items()]
    return " ".join(["hexcite plan", case, *words])
