"""Settings of all tests: hypothesis is seeded and never timed, slow studies run only where they are asked for."""

import os
from collections import Counter
from importlib import import_module

# Small matrices: BLAS threads only wait for each other, all the more so when several tests run side by side.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import Phase, settings

from cases.schema import Case, load_case
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing
from tests.helpers import EXAMPLES

# A failure is told at once; `--hypothesis-profile bench` takes its time to make it small.
AT_ONCE = (Phase.explicit, Phase.reuse, Phase.generate)
settings.register_profile(
    "full", derandomize=True, deadline=None, max_examples=EXAMPLES, print_blob=True, phases=AT_ONCE
)
settings.register_profile("check", settings.get_profile("full"), max_examples=6)
settings.register_profile("bench", deadline=None, max_examples=5000, print_blob=True)
settings.load_profile("check")


def pytest_configure(config: pytest.Config) -> None:
    if not config.option.markexpr:
        config.option.markexpr = "not slow"  # `pytest -m slow` runs the studies


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of a test marked `first(n)`, `make test` runs the first n variants; CI and `make nightly` run the others too."""
    variants = Counter[tuple[str, str]]()
    for item in items:
        if first := item.get_closest_marker("first"):
            variants[own := (item.location[0], getattr(item, "originalname", item.name))] += 1
            if variants[own] > first.args[0]:
                item.add_marker(pytest.mark.repeats)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Tests marked `linuxcnc` run the real thing; without one they are skipped, or fail where it is required."""
    if item.get_closest_marker("linuxcnc") and (missing := linuxcnc_missing()) is not None:
        if os.environ.get("HEXCITE_REQUIRE_LINUXCNC") == "1":
            pytest.fail(f"HEXCITE_REQUIRE_LINUXCNC=1, but {missing}")
        pytest.skip(missing)


@pytest.fixture(params=["causes aside", pytest.param("causes sought", marks=pytest.mark.repeats)])
def causes_aside(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Estimates that speak against themselves without the search for their cause, which a test does not ask for.

    It takes several times as long as the estimate; `make full` runs such tests with it too.
    """
    if request.param == "causes aside":
        monkeypatch.setattr(import_module("identification.identify"), "answer", lambda *_: None)


@pytest.fixture(scope="session")
def hexapod_case() -> Case:
    return load_case("hexapod")


@pytest.fixture(scope="session")
def wrist_case() -> Case:
    return load_case("ft_wrist")
