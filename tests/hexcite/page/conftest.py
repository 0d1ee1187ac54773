"""The page in a folder of its own, asked by a client that a browser would be."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

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
