"""The stages Result and Use show what a result says, write limits and what certificates say, and ask commands."""

import html
import json
import re
import shutil
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from starlette.testclient import TestClient

import hexcite as hx
from cases.schema import load_case
from hexcite.page.actions import table as actions
from hexcite.page.actions.common import Context
from hexcite.page.forms import Fields
from hexcite.page.jobs import Job
from hexcite.page.refusals import Unfit
from hexcite.page.stages import machine_of
from hexcite.page.views.use import targets_of
from hexcite.texts import text
from identification.results.estimate import entries_of_parameters, physical_values
from postprocessors.export.targets import TARGETS


class NoJobs:
    """Nothing is under way."""

    outputs = frozenset[str]()

    def latest(self, *of: str) -> None:
        """None."""


@pytest.fixture(scope="module")
def own(calibrated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the calibrated folder, which tests write into."""
    return Path(shutil.copytree(calibrated, tmp_path_factory.mktemp("own") / "root"))


@pytest.fixture
def root(own: Path) -> Path:
    return own


def asked(root: Path, action: str, **fields: str) -> Job:
    machine = machine_of(root, "+mill")
    assert machine is not None
    context = Context(root, machine, NoJobs())
    typed: Fields = {name.replace("__", "."): [value] for name, value in fields.items()}
    return actions.asked(actions.ACTIONS[action], context, typed)


def test_limits_are_judged_and_stated(client: TestClient, root: Path) -> None:
    page = client.get("/m/+mill/result?result=res").text
    assert "PASS" in page
    assert "U (k=2)" in page
    assert 'class="stack"' in page
    file = root / "mill" / "case.toml"
    before = file.read_text()
    form = {"stage": "result", "result": "res", "accept.deviations.mass_kg": "1e-6", "accept.noise_times": "1,7"}
    assert client.post("/m/+mill/do/state", data=form).status_code == 303
    stated = load_case(str(file)).accept
    assert stated is not None
    assert stated.noise_times == 1.7
    page = client.get("/m/+mill/result?result=res").text
    assert "Acceptance: FAIL" in page
    headline = page[page.index('class="verdict doubt"') : page.index("Acceptance: FAIL")]
    assert "mass (m)" in headline  # above what the run says of itself
    assert "Out of date" not in page
    use = client.get("/m/+mill/use?result=res").text
    assert "mass (m)" in use[use.index('role="alert"><b>') : use.index("<h2>")]  # above exports and certificates
    wrong = form | {"accept.reference.mass_kg": "2"}  # without its uncertainty
    answer = client.post("/m/+mill/do/state", data=wrong)
    assert answer.status_code == 400
    assert "mass_U_kg" in answer.text
    form = {name: "" for name in (*form, "accept.deviations.mass_kg") if name.startswith("accept")}
    assert client.post("/m/+mill/do/state", data=form | {"stage": "result", "result": "res"}).status_code == 303
    assert load_case(str(file)).accept is None
    assert file.read_text().strip() == before.strip()
    assert client.post("/m/hexapod/do/state", data=form).status_code == 400


def test_a_result_that_is_out_of_date_is_identified_again_by_a_button(client: TestClient, root: Path) -> None:
    """On both stages, with the recording that it is of; and where that is gone, a sentence says so."""
    file, gone = root / "mill" / "case.toml", root / "elsewhere"
    before = file.read_text()
    file.write_text(before.replace("gain_percent = 0.1", "gain_percent = 0.2"))
    try:
        for stage in ("result", "use"):
            address = f"/m/+mill/{stage}?result=res"
            (form,) = re.findall(r'(?s)<form[^>]*do/identify".*?</form>', client.get(address).text)
            assert 'name="recording" value="rec"' in form
            (root / "rec").rename(gone)
            try:
                page = client.get(address).text
            finally:
                gone.rename(root / "rec")
            assert "do/identify" not in page
            assert "bring its recording on the stage Data" in page
    finally:
        file.write_text(before)
    assert "do/identify" not in client.get("/m/+mill/use?result=res").text


def test_what_a_run_cannot_show_stands_beside_its_values(client: TestClient, root: Path) -> None:
    """The largest five, in both languages, each with what it would move and the U that does not count it."""
    record = json.loads((root / "res" / "result.json").read_text())
    (entries,) = (f["quantity"]["not_shown"] for f in record["findings"] if "not_shown" in f["quantity"])
    address, pages = "/m/+mill/result?result=res", []
    for language in ("en", "de"):
        client.cookies.set("hexcite-language", language)
        page = client.get(address).text
        (section,) = re.findall(r'(?s)<section class="unseen-effects".*?</section>', page)
        assert section.count("<tr>") == 1 + min(5, len(entries))
        assert f"{len(entries)}</summary>" in section
        assert f"{entries[0]['bias']:+.2g}" in section
        assert "clock_ppm" in section
        assert "result.json" not in page
        pages.append(html.unescape(section))
    causes = [entry["as_with"] for entry in entries[:5]]
    assert all(cause in pages[0] for cause in causes)
    assert not any(cause in pages[1] for cause in causes)


def test_certificates_and_their_texts(client: TestClient, root: Path) -> None:
    name = '<script>alert("Müller")</script>'
    form = {"stage": "use", "result": "res", "certificate.laboratory": name, "certificate.serial_numbers.machine": "7"}
    assert client.post("/m/+mill/do/state", data=form).status_code == 303
    about = load_case(str(root / "mill" / "case.toml")).certificate
    assert about is not None
    assert about.laboratory == name
    page = client.get("/m/+mill/use?result=res").text
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page
    with pytest.raises(Unfit, match="operator"):
        asked(root, "certificate", result="res", operator="a\x00b")
    job = asked(root, "certificate", result="res", operator="--json", number="7")
    assert job.command == (
        "certificate", "res", "--case", "mill/case.toml", "--operator=--json", "--number=7", "-o", "res-certificate.pdf"
    )  # fmt: skip
    with pytest.raises(Unfit, match="certificate"):
        asked(root, "verify", result="res", certificate="../x.pdf")
    (root / "x.pdf").write_bytes(b"%PDF-1.4")
    assert asked(root, "verify", result="res", certificate="x.pdf").command[:3] == ("certificate", "x.pdf", "--verify")


def test_the_result_without_the_payload_is_another_one(client: TestClient, root: Path) -> None:
    shutil.copytree(root / "res", root / "later")
    try:
        for chosen, other in (("res", "later"), ("later", "res")):
            page = client.get(f"/m/+mill/result?result={chosen}").text
            menu = re.search(r'<select id="f-before".*?</select>', page, re.DOTALL)
            assert menu is not None
            assert f"<option selected>{other}</option>" in menu[0]
    finally:
        shutil.rmtree(root / "later")


def test_payloads_exports_and_history_become_commands(root: Path) -> None:
    payload = asked(root, "payload", before="res", after="res", r__m="19,93", U__m="0.01")
    assert payload.command[-3:] == ("--reference=m=19.93+-0.01kg", "-o", "res-payload.json")
    kuka = asked(root, "payload", before="res", after="res", to="kuka", frame="flange", force="1")
    assert kuka.command[5:] == ("--to", "kuka", "--force", "-o", "res-payload-kuka.dat")  # which needs no frame
    urdf = asked(root, "payload", before="res", after="res", to="urdf", frame="flange")
    assert urdf.command[5:] == ("--frame", "flange", "--to", "urdf", "-o", "res-payload-urdf.xml")
    with pytest.raises(Unfit, match="not a choice"):
        asked(root, "payload", before="res", after="res", to="c")  # which writes models, not loads
    with pytest.raises(Unfit, match="not a number"):
        asked(root, "payload", before="res", after="res", r__m="19,93")
    export = asked(root, "export", result="res", to="urdf", frame="flange", preview="1")
    assert export.command[-3:] == ("--frame", "flange", "--preview")
    assert "--frame" not in asked(root, "export", result="res", to="kuka", frame="flange").command
    assert asked(root, "history").command[:2] == ("history", "res")


def test_the_run_that_differs_has_the_largest_share(client: TestClient, root: Path) -> None:
    case = load_case(str(root / "mill" / "case.toml"))
    first = hx.Result.load(root / "res", case, stale=True)
    both = first.covariance, first.covariance_robust
    for name, heavier in (("second", 0.0), ("odd", 0.5)):
        u = first.values + heavier * (np.array(first.record.names) == "m")
        entries = entries_of_parameters(physical_values(first.model, u, *both), u, *both)
        digest = tuple({**entry, "sha256": name.ljust(64, "0")} for entry in first.record.inputs)
        record = first.record.replaced(**entries, recording=name, inputs=digest)
        replace(first, record=record).save(root / name)
    pooled = hx.pool([hx.Result.load(root / name, case, stale=True) for name in ("res", "second", "odd")])
    pooled.save(root / "pooled")
    page = client.get("/m/+mill/result?result=pooled").text
    shares = dict(re.findall(r'<td class="word">(res|second|odd)</td><td><meter min="0" max="100" value="(\d+)"', page))
    assert {*shares} == {"res", "second", "odd"}
    assert max(shares, key=lambda name: int(shares[name])) == "odd"
    assert re.search(r'<tr class="bound"><td class="word">odd<', page)


def test_a_result_beside_itself_and_another(client: TestClient, root: Path) -> None:
    assert "E_n" not in client.get("/m/+mill/result?result=res&other=res").text
    assert client.get("/m/+mill/result?result=res&other=../x").status_code == 200
    case = load_case(str(root / "mill" / "case.toml"))
    lines = (root / "rec" / "recording.csv").read_text().splitlines(keepends=True)
    (root / "still.csv").write_text("".join(lines[:400]))
    still = hx.Recording.load(root / "still.csv", case)
    hx.tare(still, hx.Result.load(root / "res", case, stale=True)).save(root / "tared")
    page = client.get("/m/+mill/result?result=tared&other=res").text
    assert '<th scope="col">E_n</th>' in page


def test_a_result_is_judged_once(client: TestClient, root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hexcite.page.views import result

    judged: list[str] = []

    def judge(of: hx.Result) -> hx.Verdict:
        judged.append(of.source)
        return hx.accept(of)

    monkeypatch.setattr(result, "accept", judge)
    result._verdict.cache_clear()
    for _ in range(3):
        client.get("/m/+mill/result?result=res")
    assert len(judged) == 1
    begun = time.process_time()
    assert client.get("/m/+mill/result?result=res").status_code == 200
    assert time.process_time() - begun < 0.2
    file = root / "mill" / "case.toml"
    text = file.read_text()
    file.write_text(text + "\n[accept]\nnoise_times = 1e-6\n")
    assert "Acceptance: FAIL" in client.get("/m/+mill/result?result=res").text  # by the case as it is now
    file.write_text(text)


def test_style_and_script_are_kept_by_their_content(client: TestClient) -> None:
    page = client.get("/").text
    for name in ("page.css", "page.js"):
        address = re.search(rf"/static/{name}\?v=\w+", page)
        assert address is not None
        assert "immutable" in client.get(address[0]).headers["cache-control"]
        assert client.get(f"/static/{name}?v=other").headers["cache-control"] == "no-cache"


def test_exports_that_fit_the_machine_come_first_and_in_words(client: TestClient, root: Path) -> None:
    shown = client.get("/m/+mill/use?result=res").text
    groups = dict(re.findall(r'(?s)<optgroup label="([^"]*)">(.*?)</optgroup>', shown))
    first, others = (
        re.findall(r'value="([^"]*)"', groups[text(key, "en")]) for key in ("targets_fit", "targets_other")
    )
    assert first[:2] == ["linuxcnc", "st"]  # whose programs the machine runs
    assert {"kuka", "ros2", "mjcf"} <= set(others)
    assert sorted([*first, *others]) == sorted(TARGETS)
    assert "C99" in text("to_c", "en")
    machine = machine_of(root, "ur10_wrist")
    assert machine is not None
    arm = [member for _, members in targets_of(machine) for member in members]
    assert arm[0] == "urscript"
    assert set(arm) == set(TARGETS)


def test_a_failed_acceptance_stands_above_all_else(client: TestClient, root: Path) -> None:
    client.post("/m/+mill/do/state", data={"stage": "use", "result": "res", "accept.mass_percent": "0.000001"})
    shown = client.get("/m/+mill/use?result=res").text.partition("<h1>")[2]
    failed = shown.index(text("verdict_fails", "en"))
    assert failed < shown.index(text("use_lead", "en"))
