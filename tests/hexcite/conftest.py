"""What tests of the planner share, made once for all workers: a cache of their own, a plan, and the chain behind it."""

import fcntl
import json
import os
from collections.abc import Callable, Iterator
from contextlib import chdir
from pathlib import Path
from typing import Any

import pytest

from cases.tables import built_in_cases
from planner.plans.plan import Plan
from tests.hexcite.browser import browser
from tests.hexcite.command_line import ACCEPT, call, hexcite, pictures

__all__ = ["browser"]

SHORT = ("--order", 3, "--duration", 6)  # of the plan that many tests read: half as long in the making as the usual one


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that all workers of this run share."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "planner"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="session", autouse=True)
def cache(shared: Path) -> Iterator[Path]:
    """A cache folder of this run, so that bounds are computed by the code under test and not taken from the user's."""
    before = os.environ.get("XDG_CACHE_HOME")
    os.environ["XDG_CACHE_HOME"] = str(shared / "cache")
    yield shared / "cache"
    if before is None:
        del os.environ["XDG_CACHE_HOME"]
    else:
        os.environ["XDG_CACHE_HOME"] = before


@pytest.fixture(scope="session")
def once(shared: Path, cache: Path) -> Callable[[str, Callable[[], Any]], Any]:
    """Computes a JSON value by name in one worker; the others wait for it and read it."""

    def once(name: str, compute: Callable[[], Any]) -> Any:
        file = shared / f"{name}.json"
        with (shared / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not file.exists():
                file.write_text(json.dumps(compute()), encoding="utf-8")
        return json.loads(file.read_text(encoding="utf-8"))

    return once


@pytest.fixture(scope="module")
def every_picture() -> Iterator[None]:
    """Pages show every figure's own picture."""
    pictures["every"] = True
    yield
    pictures["every"] = False


@pytest.fixture(scope="session")
def planned(shared: Path, once: Callable[[str, Callable[[], Any]], Any]) -> dict[str, Any]:
    """The answer of `hexcite plan hexapod --family fourier --order 3 --duration 6 --starts 1`, in `shared/plan`."""
    plan = ("plan", "hexapod", "--family", "fourier", *SHORT, "--starts", 1, "-o", shared / "plan", "--json")
    return once("planned", lambda: hexcite(*plan, cwd=shared).json())


@pytest.fixture(scope="session")
def saved_plan(planned: dict[str, Any]) -> Plan:
    """The plan as other commands load it."""
    return Plan.load(Path(planned["plan"]))


@pytest.fixture(scope="session")
def chain(
    shared: Path, planned: dict[str, Any], once: Callable[[str, Callable[[], Any]], Any]
) -> dict[str, dict[str, Any]]:
    """The answers of plan, post, check, run and identify, each fed with what the one before it wrote."""
    steps = {
        "post": ("post", "plan", *ACCEPT, "-o", "excitation.ngc"),
        "check": ("check", "excitation.ngc", "--case", "hexapod"),
        "run": ("run", "excitation.ngc", "--case", "hexapod", "-o", "recording"),
        "identify": ("identify", "recording", "-o", "result"),
    }

    def answers() -> dict[str, Any]:
        with chdir(shared):
            return {name: call(*step, "--json").json() for name, step in steps.items()}

    return {"plan": planned, **once("chain", answers)}


@pytest.fixture
def hexapod_file(tmp_path: Path) -> Path:
    """A copy of the hexapod's case file, to be edited."""
    file = tmp_path / "machine.toml"
    file.write_text(built_in_cases()["hexapod"].read_text(encoding="utf-8"), encoding="utf-8")
    return file
