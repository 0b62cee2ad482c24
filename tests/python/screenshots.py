"""The screenshots in the documents: `python tests/python/screenshots.py` writes docs/screenshots anew.

It needs what the tests need, and a browser.
"""

import re
import subprocess
import tempfile
from pathlib import Path

from browser import chromium, draw_all
from conftest import COSIM, ROOT
from playwright.sync_api import expect
from test_live import Live

FOLDER = ROOT / "docs" / "screenshots"
SIZE = {"width": 1100, "height": 900}


def report(browser, folder):
    """A campaign: its first screen, a cell, and its worst run."""
    subprocess.run([COSIM, "campaign", ROOT / "examples/campaign/filters.toml", "-q", "--output-dir", folder], check=False)
    subprocess.run([COSIM, "report", folder], check=True)
    page = browser.new_page(viewport=SIZE)
    page.goto((folder / "report.html").as_uri())
    page.screenshot(path=FOLDER / "campaign.png")
    page.locator("#matrix td a").last.click()
    draw_all(page)
    page.get_by_role("heading", name="Over time").evaluate("heading => heading.scrollIntoView()")
    page.screenshot(path=FOLDER / "cell.png")
    page.locator("table:has(caption:text('Runs:')) a").first.click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Run")
    draw_all(page)
    page.screenshot(path=FOLDER / "run.png")


def live(browser, folder):
    """A run after a minute and a fault."""
    with Live(folder, "--stop-time", "120", "--real-time=10") as run:
        page = browser.new_page(viewport={**SIZE, "height": 1300})
        page.goto(run.page)
        page.get_by_label("on variables").fill("fix.position.x")
        page.get_by_label("Fault").select_option(label="bias")
        page.get_by_label("value", exact=True).fill("3")
        page.get_by_role("button", name="Inject").click()
        expect(page.get_by_role("log")).to_contain_text("bias")
        page.get_by_role("button", name="Go on").click()
        expect(page.locator("#status")).to_contain_text(re.compile(r"[6-9]\d(\.\d)? s of"))
        page.get_by_role("button", name="Pause").click()
        expect(page.get_by_role("button", name="Go on")).to_be_visible()
        page.screenshot(path=FOLDER / "live.png")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary, chromium() as browser:
        report(browser, Path(temporary) / "campaign")
        live(browser, Path(temporary))
