"""What tests of exports share: skips where a compiler is missing."""

import os
import shutil

import pytest


@pytest.fixture(scope="session")
def gcc() -> None:
    if shutil.which("gcc") is None:
        if os.environ.get("HEXCITE_REQUIRE_LINUXCNC") == "1":
            pytest.fail("HEXCITE_REQUIRE_LINUXCNC=1, but gcc is missing")
        pytest.skip("gcc is missing; install the packages gcc and libc6-dev")
