"""What tests of controllers share."""

from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    def write(text: str) -> Path:
        program = tmp_path / "program.ngc"
        program.write_text(text)
        return program

    return write
