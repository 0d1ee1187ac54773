"""The German page is German; what commands say in English is quoted, and marked as English."""

import ast
import json
import re
import shutil
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from string import Formatter

import pytest
from markupsafe import escape
from starlette.testclient import TestClient

import hexcite as hx
from cases.base.errors import CaseError, Code, IdentificationError
from cases.base.phrases import SIGNS, phrase, said
from cases.schema import load_case
from cases.tables import built_in_cases
from cases.tolerances import KINDS, PRIORS
from cases.urdf import read_urdf
from hexcite.page import values
from hexcite.page.jobs import Job
from hexcite.page.journal import PLACE, Journal
from hexcite.page.keys import example_of
from hexcite.page.refusals import Unfit
from hexcite.page.server import app_of
from hexcite.page.stages import built_in
from hexcite.page.words import ENGLISH, Words
from hexcite.reports import page as reports
from hexcite.reports.translated import in_german
from hexcite.texts import answers, sentences
from hexcite.texts.case_keys import KEYS, NOUNS, TABLES
from identification.finding import Kind
from identification.findings.causes.channels import order_words
from identification.findings.causes.hypothesis import Family
from identification.findings.tolerances import MEMORY, NOISE, SHOWN
from identification.limits.limit import LimitKind, OwnMove, Status
from identification.recording.formats.reasons import Why, because
from identification.results.verdicts import accept
from identification.texts import _BODY, _WORDS, as_sentences
from tests.cases.editing import edited
from tests.cases.test_bad_cases import MISTAKES
from tests.hexcite.command_line import call

from .conftest import HOST, OWN, TOKEN

GERMAN = Words("de")
ENGLISH_WORDS = frozenset(
    re.findall(
        r"\w+",
        """the of is are and with for not by from this that which where has have been to or its be than each other they
        mass velocity limit joint strut force jerk value file run machine recording result search share time noise
        offset angle length height name unit column row largest smallest distance between about until into before after
        there what how when who does do can must should found written file nothing""",
    )
)
SILENT = frozenset({"script", "style", "code", "pre", "q", "title"})


class Spoken(HTMLParser):
    """What a page says in its own language: texts and labels, without quotations, code and values."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []
        self._silent: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        about = dict(attrs)
        value = about.get("class") == "printed" or (tag == "option" and "value" not in about)  # of a file, or a name
        if tag in SILENT or value or about.get("lang") == "en" or self._silent:
            if tag not in ("input", "br", "meta", "link", "img", "circle", "path", "polyline", "rect"):
                self._silent.append(tag)
            return
        self.said += [about[name] or "" for name in ("aria-label", "placeholder", "alt") if name in about]

    def handle_endtag(self, tag: str) -> None:
        if self._silent and self._silent[-1] == tag:
            self._silent.pop()

    def handle_data(self, data: str) -> None:
        if not self._silent:
            self.said.append(data)


def english_in(page: str) -> set[str]:
    """English words that a page says, each with the text around it."""
    spoken = Spoken()
    spoken.feed(page)
    texts = (re.sub(r"`[^`]*`|\S*[._/\[\]]\S+|hexcite \w+|--\w+(?: [a-z]+)?", " ", text) for text in spoken.said)
    return {
        f"{word.lower()}: {text.strip()[:80]}"
        for text in texts
        for word in re.findall(r"[A-Za-zäöüß]+", text)
        if word in ENGLISH_WORDS
    }


def test_what_is_said_and_what_is_quoted_are_told_apart():
    page = '<p>Die mass <q lang="en">the mass</q> ist <code>of</code></p><label aria-label="for it">x</label>'
    assert english_in(page) == {"mass: Die mass", "for: for it"}


@pytest.fixture
def answered(root: Path, calibrated: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    """A client of a folder in which each stage has an answer of a command."""
    shutil.copytree(calibrated, root, dirs_exist_ok=True, ignore=shutil.ignore_patterns(PLACE))
    monkeypatch.chdir(root)
    table = (root / "rec" / "recording.csv").read_text().splitlines()
    head = table[0].replace("_mm", "").replace("_N", "").replace("f2", "Kraft no 2")
    (root / "trace.csv").write_text("\n".join([head, *table[1:4000]]).replace(",", ";"))
    commands = {
        ("machine", "check"): ("case", "check", "mill/case.toml", "--propose"),
        ("program", "plan"): ("post", "plan", "--dialect", "sinumerik", "-o", "again.mpf"),
        ("data", "trace.csv"): ("look", "trace.csv", "--case", "mill/case.toml", "-o", "trace-look.svg"),
        ("use", "res"): ("export", "res", "--to", "c", "--case", "mill/case.toml", "--preview"),
    }
    journal = Journal(root)
    for number, ((stage, about), command) in enumerate(commands.items(), 1):
        answer = call(*command, "--json")
        job = Job("+mill", stage, command, about=about, number=number, state="done" if answer.code == 0 else "failed")
        job.ended, job.finished, job.answer = job.began, 4e9, json.loads(answer.out)
        job.messages = ["the limit of this machine is reached"]
        if "error" in (job.answer or {}):
            job.refused, job.answer = job.answer["error"], None
        journal.write(f"{number}-1-1", job.record)
    with TestClient(app_of(root, frozenset({HOST}), TOKEN), follow_redirects=False) as client:
        client.get(f"/?token={TOKEN}")
        client.headers.update(OWN | {"accept-language": "de"})
        yield client


ARM = (
    '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/>'
    '<child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="1"/></joint></robot>'
)


@pytest.mark.repeats
def test_all_stages_speak_german(answered: TestClient):
    assert answered.put("/upload/arm.urdf", content=ARM.encode()).status_code == 200
    places = ["/", "/urdf/arm.urdf", "/nowhere", "/m/+mill/data?recording=trace.csv"]
    places += [f"/m/{key}/machine" for key in built_in_cases()]
    places += [f"/m/+mill/{stage}" for stage in ("machine", "plan", "program", "data", "result", "use")]
    found = {}
    for place in places:
        answer = answered.get(place)
        assert answer.status_code in (200, 404), place
        assert '<html lang="de">' in answer.text
        if english := english_in(answer.text):
            found[place] = english
    assert found == {}
    data = answered.get("/m/+mill/data?recording=trace.csv").text
    assert "ihre Beschriftung" in data or "nicht angegeben" in data
    result = answered.get("/m/+mill/result").text
    assert "Masse (m)" in result
    assert "Zeichnung" in result
    limits = answered.get("/m/+mill/motion/plan").json()["used"]["names"]
    assert any("Strebengeschwindigkeit" in name for name in limits)
    assert english_in("".join(f"<p>{name}</p>" for name in limits)) == set()
    refused = answered.post("/m/+mill/do/program", data={"plan": "none"})
    assert refused.status_code == 400
    assert "steht nicht zur Wahl" in refused.text


@pytest.mark.repeats
def test_reports_speak_german_in_their_frames(answered: TestClient, root: Path):
    case = load_case(str(root / "mill"))
    plan, result = hx.Plan.load(root / "plan", case), hx.Result.load(root / "res", case)
    values = {"plan": plan, "poses": hx.plan_poses(case, count=12, method="backward"), "res": result}
    for name, value in values.items():
        (root / name).mkdir(exist_ok=True)
        hx.report(value, root / name / "report.html")
    written = answered.get("/report/plan", headers={"accept-language": "en"}).text
    assert written == (root / "plan" / "report.html").read_text(encoding="utf-8")
    for name in values:
        page = answered.get(f"/report/{name}").text
        assert '<html lang="de">' in page
        assert english_in(re.sub(r"[0-9a-f]{16,}", "", page)) == set()  # without fingerprints
        of_the_case = {case.simulation.source} if case.simulation is not None else set()
        assert {*re.findall(r'lang="en">([^<]*)', page)} <= of_the_case
        assert "data-said" not in page
    assert "Masse (m)" in page
    figures = re.findall(r'data-plot="[^"]*">(.*?)</script>', answered.get("/report/plan").text, re.DOTALL)
    assert "Geschwindigkeit [mm/s]" in [
        json.loads(figure)["layout"]["yaxis"]["title"]["text"] for figure in figures[2:]
    ]


def test_a_report_in_german_keeps_what_users_wrote():
    written = '<script>alert("Velocity")</script> & {m} \\1'
    page = reports.page(
        phrase("page_of_plan", "Plan: {machine}", machine=written),
        reports.Head(
            as_sentences("the mass of this is odd", phrase("sound_run", "Nothing speaks against this run")),
            True,
            written,
        ),
        "How large",
        [("case", written)],
        [written],
        reports.section("Over time", reports.table(("value", written), [(written, "1")])),
    )
    german = in_german(page)
    assert page.count(str(escape(written))) == german.count(str(escape(written)))
    assert '<q lang="en">the mass of this is odd</q>. Nichts spricht gegen diesen Lauf.' in german
    assert "<h2>Über der Zeit</h2>" in german
    assert "<script>alert" not in german


def test_everything_with_a_code_has_german_words():
    assert {*map(str, LimitKind), *map(str, OwnMove)} == answers.LIMITS.keys()
    assert {*map(str, Status)} == answers.STATUSES.keys()
    assert {*map(str, Kind)} == answers.FINDINGS.keys()
    assert {*map(str, Code)} == answers.ERRORS.keys()
    assert {why.name.lower() for why in Why} == answers.REASONS.keys()
    assert _BODY.keys() | _WORDS.keys() == answers.PARAMETERS.keys()
    assert {*KINDS.values(), PRIORS, NOISE, MEMORY, SHOWN} <= answers.CAUSES.keys()
    assert built_in_cases().keys() == answers.TITLES.keys()


def places_of(words: str) -> set[str]:
    """Names of the places in a text."""
    return {name for _, name, _, _ in Formatter().parse(words) if name}


def english_phrases() -> dict[str, set[frozenset[str]]]:
    """Code of each phrase in the sources -> the sets of places that its English texts have."""
    found: dict[str, set[frozenset[str]]] = {}
    for package in ("cases", "identification", "planner", "postprocessors", "hexcite"):
        for file in sorted(Path(package).rglob("*.py")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            texts = {
                name.id: node.value.value
                for node in ast.walk(tree)
                if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
                for name in node.targets
                if isinstance(name, ast.Name)
            }
            for made in ast.walk(tree):
                if not (isinstance(made, ast.Call) and isinstance(made.func, ast.Name)):
                    continue
                if made.func.id in ("phrase", "_one", "_two") and isinstance(made.args[0], ast.Constant):
                    english = made.args[1]
                    words = english.value if isinstance(english, ast.Constant) else texts[ast.unparse(english)]
                    found.setdefault(made.args[0].value, set()).add(frozenset(places_of(words)))
    return found


def test_every_phrase_has_german_words_with_the_same_places():
    found = english_phrases()
    families = {f"family_{family.name.lower()}": {frozenset(places_of(family.value))} for family in Family}
    german = {code: {frozenset(places_of(words))} for code, words in sentences.SENTENCES.items()}
    assert german == found | families
    assert {*SIGNS} == sentences.SIGNS.keys()


def test_a_cause_is_said_in_german_and_what_has_no_code_is_quoted_in_it():
    words = order_words((1, 0, 2, 3, 4, 5), phrase("struts", "struts"), "123456")
    problem = phrase("explained", "{problem} ({tried})", problem=said("it <b> is"), tried=words)
    error = IdentificationError(problem=problem, code=Code.MISFIT, place="run.csv")
    entries = json.loads(json.dumps(error.to_json()))
    assert entries["problem"] == "it <b> is (struts 1 and 2 are exchanged)"
    german = GERMAN.error(entries)
    assert german == '<code>run.csv</code>: <q lang="en">it &lt;b&gt; is</q> (Streben: 1 und 2 vertauscht)'
    assert ENGLISH.error(entries) is None
    assert GERMAN.error({"problem": "x", "place": ""}) is None
    assert GERMAN.by_code({"code": "none of ours", "values": {}}) is None


def test_reasons_have_the_same_places_in_both_languages():
    for why in Why:
        assert re.findall(r"{(\w+)}", why.value) == re.findall(r"{(\w+)}", answers.REASONS[why.name.lower()]), why
    reason = because(Why.RATE, rate="500")
    assert (
        GERMAN.reasons(reason.codes, reason) == "ihre Schritte sind dann 500 Zeilen je Sekunde, wie Rekorder sie haben"
    )
    assert ENGLISH.reasons(reason.codes, reason) == str(reason)


def test_every_check_has_german_words(calibrated: Path):
    import hexcite as hx

    verdict = accept(hx.Result.load(calibrated / "res", hx.load_case(str(calibrated / "mill")), stale=True))
    assert verdict.checks
    for check in verdict.checks:
        assert not GERMAN.check(check.code, check.of, check.name).startswith("<q")


def test_keys_and_tables_of_cases_have_german_words():
    for machine in built_in():
        content = machine.file.read_text(encoding="utf-8")
        assert example_of
        for section in values.sections(content, machine.case):
            assert not section.words or {*section.owners} & TABLES.keys(), section.name
            for entry in (*section.entries, *section.more):
                assert not entry.words or {f"{owner}.{entry.key}" for owner in entry.owners} & KEYS.keys(), entry.name
                assert len(entry.noun) < 3 or entry.noun in NOUNS or not entry.noun.isalpha(), entry.noun


def test_a_refusal_of_the_page_is_a_text_and_one_of_the_library_a_quotation():
    assert GERMAN.refused(Unfit("no_choice", place="plan", text="x")) == "plan: &#39;x&#39; steht nicht zur Wahl"
    assert GERMAN.refused(Unfit.of(["it is <b>"])) == '<q lang="en">it is &lt;b&gt;</q>'
    assert str(Unfit("no_choice", place="plan", text="x")) == "plan: 'x' is not a choice"


def quotations_in(page: str) -> set[str]:
    """What a page quotes in English."""
    return set(re.findall(r'<q lang="en">(.*?)</q>', page, re.DOTALL))


@pytest.mark.repeats
def test_stages_quote_only_what_was_said_without_a_code(answered: TestClient):
    stages = ("machine", "plan", "program", "data", "data?recording=rec", "result", "use")
    quoted = set[str]().union(*(quotations_in(answered.get(f"/m/+mill/{stage}").text) for stage in stages))
    assert quoted == {"the limit of this machine is reached"}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_a_case_cannot_be_is_said_in_german(mistake: str, tmp_path: Path):
    old, new, _, _ = MISTAKES[mistake]
    with pytest.raises(CaseError) as caught:
        load_case(str(edited(tmp_path, old, new)))
    sentences = caught.value.sentences
    assert tuple(map(str, sentences)) == caught.value.lines
    assert [said for said in map(GERMAN.quoted, sentences) if "<q" in said] == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<limit", "<limit/><limit"),
        ('type="revolute"', 'type="floating"'),
        ('xyz="0 0 1"', 'xyz="0 0 0"'),
        ('lower="-1"', 'lower="x"'),
        ('lower="-1"', 'lower="3"'),
        ('<link name="b"/>', '<link name="b"/><link name="b"/>'),
        ("</robot>", "<xacro:if/></robot>"),
        ("</robot>", ""),
    ],
)
def test_what_a_urdf_cannot_be_is_said_in_german(old: str, new: str, tmp_path: Path):
    assert old in ARM
    (tmp_path / "arm.urdf").write_text(ARM.replace(old, new))
    with pytest.raises(CaseError) as caught:
        read_urdf(tmp_path / "arm.urdf", "b")
    said_of_it = [GERMAN.quoted(each) for each in caught.value.sentences]
    assert said_of_it
    assert [each for each in said_of_it if "<q" in each] == []
