"""The page answers its own browser window and nobody else, and no path leaves its folder."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.testclient import TestClient

from hexcite.page import server
from hexcite.page.security import Outside, file_name, inside

from .conftest import OWN, TOKEN

PLACES = ("/", "/m/hexapod/plan", "/jobs/1/events", "/files/a.csv", "/report/plan", "/picture/a.svg", "/static/page.js")
CHANGES = (
    ("POST", "/new"), ("POST", "/language"), ("PUT", "/upload/a.csv"), ("POST", "/m/hexapod/do/plan"),
    ("POST", "/m/hexapod/do/save"), ("POST", "/m/hexapod/do/preview"), ("POST", "/jobs/1/stop"),
)  # fmt: skip


@pytest.mark.parametrize("place", PLACES)
def test_nothing_is_shown_without_the_token(stranger: TestClient, place: str):
    assert stranger.get(place).status_code == 403
    assert stranger.get(place, params={"token": "guessed"}).status_code == 403
    assert stranger.get(place, headers={"cookie": "hexcite=guessed"}).status_code == 403


def test_the_token_becomes_a_cookie_that_scripts_and_other_sites_do_not_have(stranger: TestClient):
    answer = stranger.get(f"/?token={TOKEN}")
    assert answer.headers["location"] == "/"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:1", "testserver.evil.example", ""])
def test_another_host_is_refused(client: TestClient, host: str):
    assert client.get("/", headers={"host": host}).status_code == 421


@pytest.mark.parametrize(("method", "place"), CHANGES)
@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://testserver", "sec-fetch-site": "cross-site"},
        {"origin": "http://testserver", "sec-fetch-site": "same-site"},
        {},
    ],
)
def test_nothing_changes_for_another_page(
    client: TestClient, root: Path, method: str, place: str, headers: dict[str, str]
):
    for name in OWN:
        del client.headers[name]
    answer = client.request(method, place, headers=headers, content=b"a=1")
    assert answer.status_code == 403
    assert list(root.iterdir()) == []


def test_every_answer_has_the_policy(client: TestClient):
    for place in (*PLACES, "/nowhere"):
        if "events" in place:
            continue
        policy = client.get(place).headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy


def test_a_report_has_an_origin_of_its_own(client: TestClient, root: Path):
    (root / "plan").mkdir()
    (root / "plan" / "report.html").write_text("<script>parent.document</script>")
    policy = client.get("/report/plan").headers["content-security-policy"]
    assert policy.startswith("sandbox allow-scripts;")
    assert "allow-same-origin" not in policy
    assert "default-src 'none'" in policy


@pytest.mark.parametrize(
    "place",
    [
        "/files/..%2Fsecret.csv", "/files/%2e%2e/secret.csv", "/files/plan/../../secret.csv", "/files/%2Fetc%2Fpasswd",
        "/files/..%5Csecret.csv", "/files/.hidden.csv", "/files/link.csv", "/files/linked/secret.csv",
        "/files/a%00.csv", "/report/%2e%2e", "/report/linked", "/picture/..%2Fsecret.svg", "/m/..%2F..%2Fetc/plan",
        "/m/+..%2Foutside/machine", "/m/+linked/machine", "/m/.ssh/machine",
    ],
)  # fmt: skip
def test_no_path_leaves_the_folder(client: TestClient, root: Path, place: str):
    outside = root.parent / "outside"
    outside.mkdir()
    for name in ("secret.csv", "secret.svg", "report.html", "case.toml"):
        (outside / name).write_text("secret")
        (root.parent / name).write_text("secret")
    (root / ".hidden.csv").write_text("secret")
    (root / "link.csv").symlink_to(outside / "secret.csv")
    (root / "linked").symlink_to(outside)
    answer = client.get(place)
    assert answer.status_code == 404
    assert "secret" not in answer.text.replace("secret.", "")


@given(parts=st.lists(st.text(max_size=12), min_size=1, max_size=4))
def test_whatever_is_asked_for_lies_below_the_root(parts: list[str]):
    root = Path("/tmp").resolve()
    try:
        path = inside(root, *parts)
    except Outside:
        return
    assert path.is_relative_to(root)


@given(name=st.text(max_size=300))
def test_a_name_of_an_upload_is_one_of_a_file_here(name: str):
    try:
        own = file_name(name)
    except Outside:
        return
    assert own == Path(own).name
    assert not own.startswith((".", "-"))
    assert len(own) <= 120


def test_an_upload_comes_whole_and_replaces_nothing(client: TestClient, root: Path):
    (root / "run.csv").write_text("mine")
    answer = client.put("/upload/run.csv", content=b"1,2\n" * 100_000)
    assert answer.json() == {"name": "run-2.csv"}
    assert (root / "run.csv").read_text() == "mine"
    assert (root / "run-2.csv").stat().st_size == 400_000
    assert client.put("/upload/..%5C..%5Cevil.csv", content=b"1").json() == {"name": "evil.csv"}
    assert client.put("/upload/a.html", content=b"1").status_code == 415
    assert client.put("/upload/case.toml", content=b"1").status_code == 415
    assert sorted(path.name for path in root.iterdir()) == ["evil.csv", "run-2.csv", "run.csv"]


def test_too_large_an_upload_leaves_nothing(client: TestClient, root: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(server, "MOST_UPLOAD", 1000)
    assert client.put("/upload/run.csv", content=b"1" * 1001).status_code == 413
    parts = (b"1" * 600 for _ in range(3))  # of a length that is not stated
    assert client.put("/upload/run.csv", content=parts).status_code == 413
    assert list(root.iterdir()) == []


def test_too_long_a_form_is_refused(client: TestClient):
    answer = client.post("/m/hexapod/do/plan", content=b"a=" + b"1" * 300_000)
    assert answer.status_code == 404


EVIL = "<script>alert(1)</script>"


def test_texts_of_users_are_texts(client: TestClient, root: Path):
    import json

    from cases.scaffold import new_case

    file = new_case("mill", "hexapod", root / "mill")
    file.write_text(file.read_text().replace("what it is, in a line", EVIL))
    name = f"{EVIL.replace('/', '-')}.csv"
    (root / name).write_text("1")
    (root / "broken").mkdir()
    (root / "broken" / "case.toml").write_text(f"title = '{EVIL}'")
    (root / "res").mkdir()
    record = {
        "case": "mill",
        "findings": [{"severity": "warning", "sentence": EVIL, "kind": "model"}],
        "parameters": {EVIL: {"value": 1.0, "std": 0.1, "std_robust": None, "unit": EVIL}},
    }
    (root / "res" / "result.json").write_text(json.dumps(record))
    for place in ("/", "/m/+mill/machine", "/m/+mill/data", "/m/+mill/result", "/m/+mill/use", "/m/+broken/machine"):
        answer = client.get(place)
        assert answer.status_code == 200
        assert "<script>alert" not in answer.text
        assert "&lt;script&gt;alert" in answer.text


def test_the_way_back_stays_on_the_page(client: TestClient):
    for back in ("//evil.example", "https://evil.example", "/\\evil.example"):
        assert client.post("/language", data={"language": "de", "back": back}).headers["location"] == "/"
