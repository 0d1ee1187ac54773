"""The rows of a study: one a cell and seed of the noise, with its settings, what became of it, and where."""

from typing import TYPE_CHECKING, Any

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
