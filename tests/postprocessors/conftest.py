"""What tests of programs share: LinuxCNC's own interpreter."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.postprocessors.canonical import Canonical, canonical


@pytest.fixture
def rs274(tmp_path: Path) -> Callable[[str], Canonical | str]:
    """Runs a text through `rs274 -g`: the machine commands that it makes of it, or what it says against it.

    For tests marked `linuxcnc`.
    """
    return lambda text: canonical(text.encode(), tmp_path)
