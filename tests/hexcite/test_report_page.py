"""The report page in a real browser: no network, fits every width, reads in the dark, shows text as text."""

import base64
import json
import re
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from markupsafe import Markup
from playwright.sync_api import Browser
from playwright.sync_api import Page as Tab
from pypdf import PdfReader

from cases.schema import Case
from hexcite.reports.drawing.chart import Axis, Chart, Heat, Line, thinned
from hexcite.reports.drawing.figures import limits_table, motion_blocks
from hexcite.reports.drawing.interactive import plotly_figure
from hexcite.reports.drawing.scene import moving_machine, posing_machine
from hexcite.reports.page import TERMS, Head, explained, note, page, script_json, section, table
from identification.limits.limit import Limit, LimitCheck, LimitKind, LimitReport, Status
from identification.machines.hexapod import Hexapod
from identification.motion.motion import sample
from identification.recording.recording import write_recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.hexcite.browser import CHROMIUM, DRAWN, FLAGS, PATIENCE, Opened, opened
from tests.hexcite.command_line import call
from tests.postprocessors.changed_case import changed
from tests.simulated_machine import PoseExecution

pytestmark = [pytest.mark.usefixtures("every_picture"), pytest.mark.repeats]  # each page in a browser

FIGURES = 14  # of a result: forces, residuals, spectrum, order; 2 of accelerations, 5 of densities, 3 of correlations
HEAD = Head("All is well.", True, "hexapod")
HOSTILE = "<img src=x onerror=\"document.title='taken over'\"><b>column</b></script>"
CHART = re.compile(r'data-plot="[^"]+">(.*?)</script>', re.DOTALL)
FITS = "document.documentElement.scrollWidth <= window.innerWidth"
STICKS_OUT = """[...document.querySelectorAll('body *')].filter(e => !e.closest('.scroll, .plot')
    && e.getBoundingClientRect().right > window.innerWidth + 1).map(e => e.outerHTML.slice(0, 80))"""


@pytest.fixture(scope="module")
def motion() -> Harmonic:
    return Harmonic(seed=3, duration=4.0)


@pytest.fixture(scope="module")
def page_file(hexapod_case: Case, motion: Harmonic, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with everything that outsiders can name named in HTML."""
    first, *others = motion_blocks(hexapod_case, sample(motion, 200.0))
    named = tuple(replace(series, name=HOSTILE) for series in first.series)
    plots = (replace(first, caption=HOSTILE, series=named), *others)
    wide = tuple(f"a wide column {k}" for k in range(30))
    text = page(
        HOSTILE,
        Head(HOSTILE, False, HOSTILE, ((HOSTILE, HOSTILE),)),
        HOSTILE,
        ((HOSTILE, HOSTILE),),
        (HOSTILE,),
        section(HOSTILE, note(HOSTILE), table(wide, ((HOSTILE, *wide[1:]),)), *plots),
        section("machine", moving_machine(hexapod_case, motion)),
    )
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def result_page(hexapod_case: Case, motion: Harmonic, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of an identification whose recording has HTML for a name."""
    folder = tmp_path_factory.mktemp("result")
    execution = PoseExecution(Hexapod.of(hexapod_case), motion)
    recording = simulate_recording(hexapod_case, execution, np.array([[0.3, 3.7]]), seed=1)
    file = folder / "<img src=x onerror=\"document.title='taken over'\">.csv"
    write_recording(file, recording, hexapod_case)
    assert call("identify", file, "--case", "hexapod", "-o", folder / "result").code == 0
    return folder / "result" / "report.html"


@pytest.fixture(scope="module")
def tab(browser: Browser, page_file: Path) -> Iterator[Opened]:
    """The page on a wide screen by day."""
    with opened(browser, page_file) as tab:
        yield tab


@pytest.fixture(scope="module")
def result_tab(browser: Browser, result_page: Path) -> Iterator[Opened]:
    """The page of the identification."""
    with opened(browser, result_page) as tab:
        yield tab


def test_nothing_overflows_and_nothing_fails_on_a_wide_screen(tab: Opened):
    assert tab.page.evaluate(FITS)
    assert tab.page.evaluate(STICKS_OUT) == []
    assert (tab.errors, tab.requests) == ([], [])


def test_what_looks_like_html_stays_text(tab: Opened):
    assert tab.page.title() == f"hexcite: {HOSTILE}"
    for place in ("h1", ".verdict", "dd", "dt", ".lead", ".warnings li", "h2", "figcaption", "td"):
        assert HOSTILE in tab.page.locator(place).all_inner_texts(), place
    assert tab.page.locator("img:not(.still)").count() == 0
    assert "<b>column</b>" in tab.page.locator(".legendtext").first.text_content()


def scrub(tab: Tab, position: int) -> None:
    tab.evaluate(
        """(k) => { const s = document.getElementById('scrub'); s.value = k; s.dispatchEvent(new Event('input')); }""",
        position,
    )


def settled(tab: Tab, before: bytes = b"") -> bytes:
    """A picture of the machine, other than the one before, that no longer changes: drawing takes its time."""
    last = before
    for _ in range(200):
        tab.wait_for_timeout(300)
        now = tab.locator("#machine").screenshot()
        if now == last != before:
            return now
        last = now
    pytest.fail("the picture of the machine does not change, or not to an end")


def test_the_machine_moves_when_scrubbed(tab: Opened):
    scrub(tab.page, 0)
    first = settled(tab.page)
    scrub(tab.page, 70)
    settled(tab.page, first)
    assert "1.40 of 4.00 s" in tab.page.locator("#instant").inner_text()


def test_the_machine_plays_to_the_end_and_stops(tab: Opened):
    scrub(tab.page, 180)
    tab.page.locator("#play").click()
    tab.page.wait_for_function("document.getElementById('scrub').value === '200'")
    tab.page.wait_for_function("document.getElementById('play').textContent === 'Play'")
    assert "4.00 of 4.00 s" in tab.page.locator("#instant").inner_text()
    assert tab.errors == []


def test_platform_joints_on_the_page_are_where_the_struts_end(tab: Opened, hexapod_case: Case, motion: Harmonic):
    """The page turns the joints with its own code: strut lengths that it draws are those of the kinematics."""
    scrub(tab.page, 70)
    struts = tab.page.evaluate(
        "(({x, y, z}) => [x, y, z])(document.getElementById('machine').data.find(d => d.name === 'struts'))"
    )
    ends = np.array(struts, dtype=float).T.reshape(6, 3, 3)
    drawn = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    true = Hexapod.of(hexapod_case).strut_lengths(motion.at([70 * 4.0 / 200]).coordinates)[0] * 1e3
    np.testing.assert_allclose(drawn, true, atol=1e-2)


def _luminance(colour: str) -> float:
    """Relative luminance of a CSS colour, as WCAG 2 defines it."""
    channels = np.array([float(v) for v in re.findall(r"[\d.]+", colour)[:3]]) / 255
    linear = np.where(channels <= 0.03928, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def _require_readable(tab: Tab, dark: bool) -> None:
    """Contrast of at least 4.5 to 1 (WCAG 2, AA), in figures as in text."""
    paper = _luminance(tab.evaluate("getComputedStyle(document.body).backgroundColor"))
    assert (paper < 0.1) == dark
    for place, colour in (("h1", "color"), (".note", "color"), ("th", "color"), (".xtitle", "fill")):
        ink = _luminance(tab.evaluate(f"getComputedStyle(document.querySelector('{place}')).{colour}"))
        assert (max(ink, paper) + 0.05) / (min(ink, paper) + 0.05) >= 4.5, place


def test_text_is_readable_by_day(tab: Opened):
    _require_readable(tab.page, dark=False)


def test_a_narrow_page_by_night_fits_and_is_readable(browser: Browser, page_file: Path):
    with opened(browser, page_file, 400, "dark") as tab:
        assert tab.page.evaluate(FITS)
        assert tab.page.evaluate(STICKS_OUT) == []
        assert (tab.errors, tab.requests) == ([], [])
        _require_readable(tab.page, dark=True)


def test_an_identification_has_its_page(result_tab: Opened):
    page, errors, requests = result_tab
    names = {"correlation", "forces", "residuals", "spectrum"}
    assert {f"plot-{n}" for n in names} <= set(page.evaluate("[...document.querySelectorAll('.plot')].map(e=>e.id)"))
    assert "onerror" in page.locator(".lead").inner_text()
    assert page.locator("img:not(.still)").count() == 0
    assert (errors, requests) == ([], [])


def test_plotly_accepts_every_attribute_of_a_chart(page_file: Path, result_page: Path):
    """Its Python classes refuse what its JavaScript would overlook."""
    from plotly.graph_objects import Figure

    charts = [c for file in (page_file, result_page) for c in CHART.findall(file.read_text(encoding="utf-8"))]
    assert len(charts) == 6 + FIGURES
    for chart in charts:
        Figure(json.loads(chart))


def test_numbers_of_a_chart_reach_the_page_whatever_they_are():
    values = np.array([[1.0, np.nan], [np.inf, 2.0]])
    heat = Chart("heat", "Numbers.", (Heat(values),), Axis(names=("</script>", "b")), Axis(names=("</script>", "b")))
    line = Chart("line", "Numbers.", (Line(np.arange(2.0), np.array([1.5, 2.5]), "</script>", "#000000"),))
    told = script_json([plotly_figure(heat), plotly_figure(line)])
    assert "<" not in told
    (heatmap,), (trace,) = (each["data"] for each in json.loads(told))
    assert heatmap["x"] == ["</script>", "b"]
    assert (heatmap["z"]["dtype"], heatmap["z"]["shape"]) == ("f4", "2, 2")
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(heatmap["z"]["bdata"]), "<f4"), values.ravel())
    assert trace["name"] == "</script>"
    assert np.frombuffer(base64.b64decode(trace["y"]["bdata"]), "<f4").tolist() == [1.5, 2.5]
    assert json.loads(script_json([1.0, None, float("nan"), float("inf")])) == [1.0, None, None, None]


@pytest.mark.slow
def test_a_pose_set_is_stepped_through(browser: Browser, hexapod_case: Case, motion: Harmonic, tmp_path: Path):
    """Beside a box, with a tool on the platform."""
    box = {"name": "wall", "x_mm": [600.0, 5000.0], "y_mm": [-5000.0, 5000.0], "z_mm": [0.0, 3000.0]}
    tool = {"name": "spindle", "to_mm": [0.0, 0.0, 200.0], "radius_mm": 30.0}
    case = changed(hexapod_case, workspace__keep_out=[box], workspace__tool=[tool])
    poses = motion.at(np.linspace(0.0, 4.0, 7)).coordinates
    file = tmp_path / "report.html"
    text = page("poses", HEAD, "", (), (), section("machine", posing_machine(case, poses)))
    file.write_text(text, encoding="utf-8")
    with opened(browser, file) as tab:
        scrub(tab.page, 4)
        assert tab.page.locator("#instant").inner_text() == "pose 5 of 7"
        names = tab.page.evaluate("document.getElementById('machine').data.map(d => d.name)")
        assert {"kept out", "tools", "sensors", "platform"} <= set(names)
        assert (tab.errors, tab.requests) == ([], [])


def test_twenty_seconds_are_at_most_three_megabytes_beside_plotly(hexapod_case: Case):
    from plotly.offline import get_plotlyjs

    motion = Harmonic(seed=0, duration=20.0)
    drawn = *motion_blocks(hexapod_case, sample(motion, 1000.0)), moving_machine(hexapod_case, motion)
    assert len(page("long", HEAD, "", (), (), section("motion", *drawn))) - len(get_plotlyjs()) < 3e6


def test_a_thinned_line_keeps_its_extremes():
    x = np.linspace(0.0, 1.0, 50_000)
    y = np.random.default_rng(0).normal(size=50_000)
    y[31_234], y[777] = 40.0, -40.0
    kept_x, kept_y = thinned(x, y)
    assert len(kept_x) == len(kept_y) <= 2000
    assert (kept_y.max(), kept_y.min()) == (40.0, -40.0)
    assert np.all(np.diff(kept_x) >= 0.0)


def test_a_page_stays_below_three_megabytes(result_page: Path):
    assert result_page.stat().st_size < 3e6


def test_the_text_stands_before_the_figures_do(browser: Browser, result_page: Path):
    """What is read first does not wait for the script that draws: that comes last in the file."""
    text = result_page.read_text(encoding="utf-8")
    scripts = [(len(found.group()), found.start()) for found in re.finditer(r"(?s)<script.*?</script>", text)]
    assert text.index("<table") < max(scripts)[1]
    tab = browser.new_page()
    try:
        tab.goto(result_page.resolve().as_uri(), wait_until="domcontentloaded")
        assert "mass (m)" in tab.locator("table").first.inner_text()
        tab.wait_for_function(DRAWN, timeout=PATIENCE)
        assert tab.evaluate("typeof Plotly") == "object"
    finally:
        tab.close()


def test_figures_tables_and_words_speak_to_a_screen_reader(result_tab: Opened):
    for figure in result_tab.page.locator("figure .plot").all():
        assert len(figure.get_attribute("aria-label") or "") > 10
    for caption in result_tab.page.locator("figure:has(.plot:not(#machine)) figcaption").all_inner_texts():
        assert caption.strip()
    assert result_tab.page.locator("th:not([scope])").count() == 0
    terms = result_tab.page.locator("abbr").all()
    assert terms
    assert all(len(term.get_attribute("title") or "") > 10 for term in terms)


@pytest.mark.first(1)
@pytest.mark.parametrize("size", ["A4", "Letter"])
def test_what_is_printed_stays_inside_the_paper_and_is_white(browser: Browser, result_page: Path, size: str):
    """Also where the screen is dark: pictures stand in place of figures, and nothing that only a screen can do."""
    width = {"A4": 794, "Letter": 816}[size] - 2 * 45  # less the page's margins of 12 mm
    with opened(browser, result_page, width, "dark") as tab:
        tab.page.emulate_media(media="print", color_scheme="dark")
        assert tab.page.evaluate("getComputedStyle(document.documentElement).backgroundColor") == "rgb(255, 255, 255)"
        right = tab.page.evaluate(
            "Math.max(...[...document.querySelectorAll('body *')].map(e => e.getBoundingClientRect().right))"
        )
        assert right <= width + 1
        shown = tab.page.locator("figure .still")
        assert shown.count() == tab.page.locator("figure").count() == FIGURES
        for place in (".plot", ".player", ".screen", ".modebar"):
            assert not any(each.is_visible() for each in tab.page.locator(place).all()), place


def test_paper_printed_at_once_has_every_figure(result_page: Path, tmp_path: Path):
    """The browser prints as soon as it has read the file: no script has drawn anything by then."""
    assert CHROMIUM is not None
    paper = tmp_path / "report.pdf"
    command = [CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path / 'user'}", "--no-pdf-header-footer"]
    subprocess.run([*command, f"--print-to-pdf={paper}", result_page.as_uri()], check=True, capture_output=True)
    text = "\n".join(leaf.extract_text() for leaf in PdfReader(paper).pages)
    for axis in ("recorded - model [N]", "force [N]", "frequency [Hz]", "mxC"):  # one of each figure
        assert axis in text
    assert "Drag to turn" not in text
    assert "drawn" not in text


def test_pictures_stand_where_no_script_runs(browser: Browser, result_page: Path):
    context = browser.new_context(java_script_enabled=False)
    try:
        tab = context.new_page()
        tab.goto(result_page.resolve().as_uri())
        pictures = tab.locator("figure .still")
        assert pictures.count() == FIGURES
        for picture in pictures.all():
            assert picture.is_visible()
            assert picture.bounding_box()["height"] > 150
            assert len(picture.get_attribute("alt")) > 10
    finally:
        context.close()


def test_a_page_begins_with_verdict_machine_recording_and_date(result_tab: Opened):
    facts = dict(
        zip(
            result_tab.page.locator("dt").all_inner_texts(),
            result_tab.page.locator("dd").all_inner_texts(),
            strict=True,
        )
    )
    assert facts["machine"] == "hexapod"
    assert facts["recording"].endswith(".csv")
    assert re.match(r"\d{4}-\d\d-\d\d \d\d:\d\d", facts["page made"])
    verdict = result_tab.page.locator(".verdict")
    assert "Mass" in verdict.inner_text()
    assert verdict.bounding_box()["y"] < result_tab.page.locator("table").first.bounding_box()["y"]


def test_limits_stand_in_the_order_of_what_a_reader_asks():
    def check(kind: LimitKind, ratio: float, status: Status) -> LimitCheck:
        return LimitCheck(Limit(kind), "x", 10.0 * ratio, 10.0, kind.unit, ratio, 0.0, status, binding=False)

    checks = (
        check(LimitKind.POSITION, 0.9, Status.PROVEN),
        check(LimitKind.VELOCITY, 0.99, Status.ENFORCED),
        check(LimitKind.STRUT_VELOCITY, 0.5, Status.NOT_ENFORCED),
        check(LimitKind.JERK, 1200.0, Status.STEPS),
        check(LimitKind.ANGULAR_JERK, 1200.0, Status.LEFT_OUT),
        check(LimitKind.STRUT_LENGTH, 0.95, Status.PROVEN),
        check(LimitKind.STRUT_ACCELERATION, 0.97, Status.FOLLOWS),
    )
    text = limits_table(LimitReport(checks))
    names = re.findall(r'class="what"[^>]*>([^<]*)<', text)
    assert names == [
        *("jerk (x)", "strut velocity (x)", "angular jerk (x)", "strut length (x)", "position (x)"),
        *("strut acceleration (x)", "velocity (x)"),
    ]
    assert "12 000 m/s³, limit 10;" in re.sub(r"<[^>]*>", "", text)


def test_words_of_the_field_are_explained_and_html_is_not_let_in():
    assert explained("s0 of <b>") == Markup(f'<abbr title="{TERMS["s0"]}" tabindex="0">s0</abbr> of &lt;b&gt;')
    assert explained("ms0") == Markup("ms0")


def test_the_head_of_a_table_repeats_on_paper_and_units_stay_in_a_line():
    html = str(table(("parameter", "unit"), [("k1", "N m/m")]))
    assert html.index("<thead>") < html.index("parameter</th>") < html.index("</thead>") < html.index("<tbody>")
    assert "N\N{NO-BREAK SPACE}m/m</td>" in html


@pytest.mark.parametrize(("last", "marks"), [(5.0, {1.0, 2.0, 5.0}), (5000.0, {1.0, 10.0, 100.0, 1000.0})])
def test_a_logarithmic_axis_on_paper_has_plain_numbers(last: float, marks: set[float]):
    from hexcite.reports.drawing.still import drawn

    values = np.array([1.0, last])
    chart = Chart("line", "Numbers.", (Line(np.arange(2.0), values, "a", "#000000"),), y=Axis(logarithmic=True))
    figure = drawn([chart])
    figure.canvas.draw()
    axis = figure.axes[0].yaxis
    shown = {label.get_text() for label in axis.get_ticklabels() if 1.0 <= label.get_position()[1] <= last}
    assert shown == {f"{mark:g}" for mark in marks}
