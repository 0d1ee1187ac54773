"""Pictures of the guided page for its documentation: wide in light colours, of a phone in dark ones; needs a Chromium.

python .ci/page_shots.py docs/howto/page
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

LOOKS = ((1280, "light"), (390, "dark"))
COLOURS = 128
SOLID = ("machine", "plan")  # stages with a machine in 3-D
PATIENCE = 120_000.0  # [ms] a busy computer without graphics draws slowly


def main(folder: Path) -> None:
    """Plans, writes and rehearses a short motion of a built-in machine, then takes each stage that has a picture."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        root = Path(place) / "calibration"
        root.mkdir()
        for command in (
            ["case", "new", "mill", "--like", "hexapod"],
            ["case", "set", "mill", 'title="hexapod mill, hall 2"'],
            ["plan", "mill", "--family", "ptp", "--duration", "8", "--seconds", "10", "-o", "first"],
            ["plan", "mill", "--family", "manual", "-o", "by-hand"],
            ["post", "first", "--dialect", "sinumerik", "-o", "first.mpf"],
            ["run", "first.mpf", "--case", "mill", "-o", "rehearsed"],
            ["identify", "rehearsed", "--case", "mill", "-o", "result"],
        ):
            subprocess.run(
                [Path(sys.executable).with_name("hexcite"), *command], cwd=root, check=True, capture_output=True
            )
        served = [sys.executable, "-P", "-m", "hexcite.cli.guest", str(os.getpid()), "page", str(root), "--no-browser"]
        with subprocess.Popen(served, cwd=root, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout is not None
            address = server.stdout.readline().split()[-1]
            try:
                _take(address, folder)
            finally:
                server.terminate()


def _draw(page: Page, width: int, stage: str) -> None:
    """Waits for the machine in 3-D; that of a plan half through its motion, where it can be seen."""
    if stage == "machine" and width < 760:
        return  # below the first screen, and not drawn until it is seen
    page.locator(".space").scroll_into_view_if_needed()
    frame = page.frame_locator(".space iframe")
    frame.locator("html[data-scenes]").wait_for()
    if stage == "plan":
        scrub = frame.locator("#scrub")
        scrub.fill(str(int(scrub.get_attribute("max") or 0) // 2))
        page.evaluate("document.querySelector('.space').previousElementSibling.previousElementSibling.scrollIntoView()")
    page.wait_for_timeout(3000)


def _take(address: str, folder: Path) -> None:
    base = address.partition("/?")[0]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--enable-unsafe-swiftshader"]
        )
        for width, scheme in LOOKS:
            context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, locale="en-GB")
            page = context.new_page()
            page.set_default_timeout(PATIENCE)
            page.goto(address)
            for stage in ("machine", "plan", "program", "result"):
                page.goto(f"{base}/m/+mill/{stage}")
                if stage in SOLID:
                    _draw(page, width, stage)
                file = folder / f"{stage}-{width}-{scheme}.png"
                page.screenshot(path=file)
                Image.open(file).convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE).save(file, optimize=True)
                if page.evaluate("document.documentElement.scrollWidth > innerWidth"):
                    raise SystemExit(f"{file.name}: wider than the window")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
