"""Chromium, as the tests of reports and of live runs use it: the one that the variable CHROMIUM names, or the system's.

Without it these tests are skipped, and the summary of the tests says so; where CI is set they fail.
`cargo xtask test` unpacks Debian's where the system has none. As a program, this file prints which one there is.
"""

import contextlib
import os
import shutil

import pytest
from playwright.sync_api import sync_playwright

NAMES = [os.environ.get("CHROMIUM", ""), "chromium", "chromium-browser", "google-chrome"]
CHROMIUM = next(filter(None, map(shutil.which, NAMES)), None)
MISSING = "no Chromium is installed, so no page is opened (Debian: apt-get install chromium)"
needs_chromium = pytest.mark.skipif(CHROMIUM is None and not os.environ.get("CI"), reason=MISSING)


@contextlib.contextmanager
def chromium():
    assert CHROMIUM, MISSING
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


def problems(page):
    """The list of errors of the page's script, as they come."""
    found = []
    page.on("pageerror", lambda error: found.append(str(error)))
    page.on("console", lambda message: found.append(message.text) if message.type == "error" else None)
    return found


def draw_all(page):
    """Scrolls to the end and back, so that every plot is drawn."""
    page.evaluate("""async () => {
        for (let y = 0; y < document.documentElement.scrollHeight; y += 500) {
            window.scrollTo(0, y);
            await new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)));
        }
        window.scrollTo(0, 0);
    }""")


if __name__ == "__main__":
    print(CHROMIUM or "")
