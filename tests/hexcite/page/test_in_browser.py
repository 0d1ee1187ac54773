"""The path through all stages in a real Chromium, from the machine to the model in use; no terminal, no errors."""

import csv
import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.hexcite.page.served import Seen, address, patience, serving

pytestmark = pytest.mark.slow
__all__ = ["address", "patience"]


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
    page.get_by_role("button", name=re.compile("built-in virtual")).click()
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


@pytest.fixture(scope="module")
def run_of_hexapod(tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    """Head and rows of a recording by the virtual controller."""
    import hexcite as hx

    folder = tmp_path_factory.mktemp("run")
    case = hx.load_case("hexapod")
    plan = hx.plan(case, hx.Manual())
    program = hx.write(plan, "sinumerik", file=folder / "made.mpf")
    program.save(folder / "made.mpf")
    hx.run(program, case, on="virtual", seed=1).save(folder / "rec")
    with (folder / "rec" / "recording.csv").open(newline="") as stream:
        return list(csv.reader(stream))


def damaged(table: list[list[str]], file: Path, first: str, second: str) -> Path:
    """The recording as a foreign program exports it: two columns exchanged, semicolons, commas, a row of units."""
    head, *rows = table
    names = list(head)
    a, b = names.index(first), names.index(second)
    names[a], names[b] = names[b], names[a]
    units = [name.rpartition("_")[2] if "_" in name else "" for name in names]
    lines = [[name.rpartition("_")[0] or name for name in names], units]
    lines += [[value.replace(".", ",") for value in row] for row in rows]
    file.write_text("".join(";".join(line) + "\n" for line in lines))
    return file


def begun(browser: Browser, address: str, like: str, width: int = 1280) -> Seen:
    """A machine of one's own, on its stage Data."""
    seen = Seen(browser, address, width)
    page = seen.page
    page.get_by_label(re.compile("^Name")).fill("mill")
    page.locator(f"input[name=like][value={like}]").check()
    page.get_by_role("button", name="Make it").click()
    expect(page.get_by_role("heading", name="Machine", exact=True)).to_be_visible()
    page.get_by_role("link", name=re.compile("4 Data")).click()
    return seen


def mass_of(page: Page) -> float:
    """The mass on the stage Result [kg]."""
    return float(page.locator(".parameters tr", has_text="mass (m)").locator("td").nth(1).inner_text())


def test_exchanged_struts_are_mended_by_menus(
    browser: Browser, address: str, run_of_hexapod: list[list[str]], tmp_path: Path
):
    seen = begun(browser, address, "hexapod")
    page = seen.page
    page.locator("#f-file").set_input_files(str(damaged(run_of_hexapod, tmp_path / "trace.csv", "l1_mm", "l4_mm")))
    expect(page.get_by_text("The file is read with these settings.")).to_be_visible()
    why = page.locator(".channel", has=page.locator('[id="c.t_s"]')).locator(".why")
    expect(why).to_contain_text("its numbers run on with the rows")
    seen.shot("mill-4-data")
    page.locator('[id="c.l1_mm"]').select_option("l4")
    page.locator('[id="c.l4_mm"]').select_option("l1")
    page.get_by_role("button", name=re.compile("Take these menus")).click()
    expect(page.locator('[id="c.l1_mm"]')).to_have_value("l4")
    page.get_by_role("button", name="Identify the parameters").click()
    expect(page.locator(".verdict.good")).to_be_visible()
    assert mass_of(page) == pytest.approx(31.83, abs=0.05)
    assert seen.errors == []


def test_exchanged_struts_are_mended_by_one_button(
    browser: Browser, address: str, root: Path, run_of_hexapod: list[list[str]], tmp_path: Path
):
    seen = begun(browser, address, "hexapod", 390)
    page = seen.page
    before = (root / "mill" / "case.toml").read_bytes()
    page.locator("#f-file").set_input_files(str(damaged(run_of_hexapod, tmp_path / "trace.csv", "l1_mm", "l4_mm")))
    page.get_by_role("button", name="Take the proposal into the case, and identify").click()
    expect(page.locator(".job .error")).to_contain_text("struts 1 and 4 are exchanged")
    expect(page.locator(".remedy pre")).to_contain_text('recording.columns.l1_mm = "l4"')
    seen.shot("mill-5-remedy")
    page.get_by_role("button", name=re.compile("^Accept")).click()
    expect(page.locator(".verdict.good")).to_be_visible()
    expect(page.get_by_role("status").filter(has_text="mill/case-1.toml")).to_be_visible()
    seen.shot("mill-5-mended")
    assert mass_of(page) == pytest.approx(31.83, abs=0.05)
    assert (root / "mill" / "case-1.toml").read_bytes() != before  # with [recording], before the struts were mended
    assert 'l4_mm = "l1"' in (root / "mill" / "case.toml").read_text()
    assert seen.errors == []


def test_files_of_one_run_are_dropped_together(
    browser: Browser, address: str, root: Path, run_of_hexapod: list[list[str]], tmp_path: Path
):
    seen = begun(browser, address, "hexapod")
    page = seen.page
    head, *rows = run_of_hexapod
    for file, letter, sign in (("struts.csv", "l", ","), ("forces.txt", "f", ";")):
        ours = [k for k, name in enumerate(head) if name in ("t_s", "trigger") or name.startswith(letter)]
        lines = [sign.join(row[k].rpartition("_")[0] or row[k] if row is head else row[k] for k in ours)
                 for row in (head, *rows)]  # fmt: skip
        (tmp_path / file).write_text("\n".join(lines))
    page.locator("#f-file").set_input_files([str(tmp_path / "struts.csv"), str(tmp_path / "forces.txt")])
    expect(page.get_by_text("The file is read with these settings.")).to_be_visible()
    expect(page.locator(".reading legend")).to_have_text(["forces.txt", "struts.csv"])
    assert sorted(file.name for file in (root / "run").iterdir()) == ["forces.txt", "struts.csv"]
    assert not [*root.glob("incomplete-*")]
    seen.shot("mill-4-run")
    page.get_by_role("button", name="Take the proposal into the case, and identify").click()
    expect(page.locator(".verdict.good")).to_be_visible()
    assert mass_of(page) == pytest.approx(31.83, abs=0.05)
    assert (root / "mill" / "case.toml").read_text().count("[[recording.files]]") == 2
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


def test_a_window_goes_on_after_its_server_was_killed(browser: Browser, root: Path):
    with serving(root) as (first, address):
        seen = Seen(browser, address)
        page = seen.page
        page.goto(f"{address.split('/?')[0]}/m/hexapod/plan")
        page.get_by_label("Kind of motion").select_option("ptp")
        page.get_by_label(re.compile("thorough")).check()
        page.get_by_role("button", name="Search").click()
        expect(page.locator("svg.search .curve")).to_be_visible()
        first.kill()
        first.wait()
        expect(page.locator("#alive")).to_be_visible()
    with serving(root) as (_, again):
        assert again == address
        expect(page.locator(".job .line strong")).to_contain_text(re.compile("ended from outside|done"))
        assert "job" in page.locator("#jobs > div").first.get_attribute("class")
        for _ in range(60):  # the search writes its best motion when its server has ended
            if page.locator(".cards a", has_text="hexapod-ptp").count():
                break
            page.wait_for_timeout(1000)
            page.reload()
        page.locator(".cards a", has_text="hexapod-ptp").click()
        expect(page.get_by_role("link", name="Next: Program")).to_be_visible()
        page.reload()
        expect(page.get_by_role("link", name="Next: Program")).to_be_visible()
        for _ in range(60):
            if not [*root.glob(".*.hexcite.part")]:
                break
            page.wait_for_timeout(1000)
        assert not [*root.glob(".*.hexcite.part")]
