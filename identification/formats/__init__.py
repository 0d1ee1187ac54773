"""Files of recorded runs, as tables of numbers in batches: one file a format, shared by all of them what is common."""

from identification.formats.reading import read_batches, read_tables
from identification.formats.table import Lines, Table

__all__ = ["Lines", "Table", "read_batches", "read_tables"]
