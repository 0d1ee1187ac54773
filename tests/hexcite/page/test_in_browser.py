"""The path through all stages in a real Chromium, from the machine to the model in use; no terminal, no errors."""

import csv
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.hexcite.browser import PATIENCE, browser

pytestmark = pytest.mark.slow
__all__ = ["browser"]


@pytest.fixture
def address(root: Path) -> Iterator[str]:
    """The address of a server of its own, ended by Ctrl-C."""
    command = [sys.executable, "-P", "-m", "hexcite.cli.guest", str(os.getpid()), "page", str(root), "--no-browser"]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        line = server.stdout.readline()
        yield line.split()[-1]
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 0


class Seen:
    """A page, and what its console called errors."""

    def __init__(self, browser: Browser, address: str, width: int = 1280, scheme: str = "light") -> None:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, locale="en-GB")
        self.page: Page = context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)
        self.shots = os.environ.get("HEXCITE_SHOTS")

    def shot(self, name: str) -> None:
        """A picture for people, where the environment says where."""
        assert self.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
        if self.shots:
            self.page.screenshot(path=Path(self.shots) / f"{name}.png")


@pytest.fixture(autouse=True)
def patience() -> None:
    expect.set_options(timeout=PATIENCE)


@pytest.mark.parametrize(("case", "width", "scheme"), [("hexapod", 1280, "light"), ("ur10_wrist", 390, "dark")])
def test_from_the_machine_to_its_model(browser: Browser, address: str, root: Path, case: str, width: int, scheme: str):
    seen = Seen(browser, address, width, scheme)
    page = seen.page
    page.locator(f'a[href="/m/{case}/machine"]').click()
    expect(page.locator("#drawing svg")).to_have_count(2)
    seen.shot(f"{case}-1-machine")

    page.get_by_role("link", name="Next: Plan").click()
    page.get_by_label("Kind of motion").select_option("ptp")
    page.get_by_label(re.compile("thorough")).check()
    page.get_by_role("button", name="Search").click()
    expect(page.locator("svg.search .curve")).to_be_visible()
    seen.shot(f"{case}-2-search")
    page.reload()
    page.get_by_role("button", name="Stop and keep the best").click()
    page.get_by_role("link", name="Next: Program").click()

    page.get_by_role("button", name="Write and prove").click()
    expect(page.locator(".good")).to_contain_text("proven")
    seen.shot(f"{case}-3-program")
    with page.expect_download() as download:
        page.get_by_role("link", name=re.compile("Download")).click()
    assert (root / download.value.suggested_filename).read_bytes() == Path(download.value.path()).read_bytes()

    page.get_by_role("link", name="Next: Data").click()
    page.get_by_role("button", name="Rehearse").click()
    page.get_by_role("button", name="Identify the parameters").click()
    expect(page.locator(".verdict")).to_be_visible()
    expect(page.locator(".parameters")).to_contain_text("mass (m)")
    seen.shot(f"{case}-5-result")
    page.get_by_text("The whole report").click()
    report = page.frame_locator("iframe")
    expect(report.locator("html[data-drawn]")).to_have_count(1)
    expect(report.locator(".plot.live").first).to_be_visible()

    page.get_by_role("link", name="Next: Use").click()
    page.get_by_role("button", name="Preview").click()
    expect(page.locator("pre.text").first).to_be_visible()
    seen.shot(f"{case}-6-use")
    assert seen.errors == []
    assert all(url.startswith(("http://127.0.0.1:", "data:", "blob:")) for url in seen.requests)


def test_a_recorded_file_is_read_for_a_machine_of_ones_own(browser: Browser, address: str, root: Path):
    import hexcite as hx

    case = hx.load_case("hexapod")
    plan = hx.plan(case, hx.PointToPoint(moves=24), duration=8.0, starts=1, workers=1)
    program = hx.write(plan, "sinumerik", file=root / "made.mpf")
    program.save(root / "made.mpf")
    hx.run(program, case, on="virtual", seed=1).save(root.parent / "rec")
    with (root.parent / "rec" / "recording.csv").open(newline="") as stream:
        head, *rows = csv.reader(stream)
    a, b = head.index("l1_mm"), head.index("l4_mm")
    head[a], head[b] = head[b], head[a]
    file = root.parent / "trace.csv"
    with file.open("w", newline="") as stream:
        csv.writer(stream).writerows([head, *rows])

    seen = Seen(browser, address)
    page = seen.page
    page.get_by_label(re.compile("^Name")).fill("mill")
    page.get_by_label(re.compile("^Begin from")).select_option("hexapod")
    page.get_by_role("button", name="Make it").click()
    expect(page.get_by_role("heading", name="Machine", exact=True)).to_be_visible()
    page.get_by_role("link", name=re.compile("4 Data")).click()
    page.locator("#f-file").set_input_files(str(file))
    page.get_by_role("button", name="How is it read?").click()
    expect(page.get_by_text("The file is read with these settings.")).to_be_visible()
    seen.shot("mill-4-data")
    assert seen.errors == []


def test_two_windows_and_another_site(browser: Browser, address: str, root: Path):
    first, second = Seen(browser, address), Seen(browser, address)
    for seen in (first, second):
        seen.page.goto(f"{address.split('/?')[0]}/m/hexapod/plan")
    for seen in (first, second):
        seen.page.get_by_label("Kind of motion").select_option("manual")
        seen.page.get_by_role("button", name="Search").click()
    for seen in (first, second):
        expect(seen.page.locator(".cards a", has_text=re.compile("hexapod-manual")).first).to_be_visible()
    stranger = browser.new_context().new_page()
    stranger.set_content(
        f'<form method="post" action="{address.split("/?")[0]}/new"><input name="name" value="evil">'
        '<input name="like" value="hexapod"><button>go</button></form>'
    )
    stranger.get_by_role("button").click()
    stranger.wait_for_load_state()
    assert not (root / "evil").exists()
