"""The page in a folder of its own, asked by a client that a browser would be."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

import hexcite as hx
from cases.scaffold import new_case
from cases.schema import load_case
from cases.tables import built_in_cases
from hexcite.page.server import app_of

HOST, TOKEN = "testserver", "a-token-of-the-tests"
OWN = {"origin": f"http://{HOST}", "sec-fetch-site": "same-origin"}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / "root"
    folder.mkdir()
    return folder.resolve()


@pytest.fixture
def stranger(root: Path) -> Iterator[TestClient]:
    """A client that has seen neither the address nor a cookie."""
    with TestClient(app_of(root, frozenset({HOST}), TOKEN), follow_redirects=False) as client:
        yield client


@pytest.fixture
def client(stranger: TestClient) -> TestClient:
    """A client that has opened the address of the page."""
    assert stranger.get(f"/?token={TOKEN}").status_code == 303
    stranger.headers.update(OWN)
    return stranger


@pytest.fixture(scope="session")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a machine that states tolerances, and the result of a rehearsal."""
    root = tmp_path_factory.mktemp("calibrated")
    file = new_case("mill", "hexapod", root / "mill")
    file.write_text(file.read_text() + "\n[tolerances]\njoints_mm = 0.02\ngain_percent = 0.1\n")
    case = load_case(str(file))
    plan = hx.plan(case, hx.Manual(sequence=built_in_cases()["hexapod"].parent / "manual.toml"))
    plan.save(root / "plan")
    program = hx.write(plan, "sinumerik", file=root / "made.mpf")
    program.save(root / "made.mpf")
    run = hx.run(program, case, on="virtual", seed=1)
    run.save(root / "rec")
    hx.identify(hx.Recording.load(root / "rec", case)).save(root / "res")
    return root
