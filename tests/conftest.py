"""Settings of all tests: hypothesis is seeded and never timed, slow studies run only where they are asked for."""

import pytest
from hypothesis import settings

from cases.loading import load_case
from cases.schema import Case

settings.register_profile("check", derandomize=True, deadline=None, max_examples=60, print_blob=True)
settings.register_profile("bench", deadline=None, max_examples=5000, print_blob=True)
settings.load_profile("check")


def pytest_configure(config: pytest.Config) -> None:
    if not config.option.markexpr:
        config.option.markexpr = "not slow"  # `pytest -m slow` runs the studies


@pytest.fixture(scope="session")
def hexapod_case() -> Case:
    return load_case("hexapod")


@pytest.fixture(scope="session")
def wrist_case() -> Case:
    return load_case("ft_wrist")
