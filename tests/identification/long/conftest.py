"""Lengths that let short runs go through many blocks."""

import pytest

from identification.formats import parquet
from identification.long import blocks


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lengths that let a short run go through many blocks."""
    monkeypatch.setattr(blocks, "HEAD", 2000)
    monkeypatch.setattr(blocks, "LEAST", 1)
    monkeypatch.setattr(parquet, "_BATCH", 700)
