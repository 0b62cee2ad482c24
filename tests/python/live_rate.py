"""Frames per second of the live page with 100 signals, and what it costs the run: `python tests/python/live_rate.py`.

It needs what the tests need, and a browser. Both are on this machine, so they share its cores.
"""

import os
import subprocess
import tempfile
from pathlib import Path

from browser import chromium
from conftest import COSIM
from playwright.sync_api import expect
from test_live import SYSTEM, Live, status

SIGNALS = 100
SECONDS = 10
STOP = "600"


def processor(child):
    """Processor time of a running process (s)."""
    fields = Path(f"/proc/{child.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watch(browser, folder, *arguments):
    """A run in real time with a page: its frames per second, and processor time for each second of the run."""
    with Live(folder, "--stop-time", STOP, *arguments) as live:
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto(live.page)
        expect(status(page, "state")).to_have_text("paused")
        page.evaluate(f"livePage.signals.chosen = [...Array({SIGNALS}).keys()]; livePage.want()")
        page.get_by_role("button", name="Go on").click()
        page.wait_for_timeout(2000)
        read = "() => [livePage.frames, livePage.state.time, performance.now() / 1000]"
        before, used = page.evaluate(read), processor(live.process)
        page.wait_for_timeout(1000 * SECONDS)
        after, now = page.evaluate(read), processor(live.process)
        frames, simulated, seconds = (b - a for a, b in zip(before, after))
        page.close()
        return frames / seconds, (now - used) / simulated


def alone(folder, *arguments):
    """Processor time of the same run without a server, for each second of it."""
    stop = "100"
    before = os.times()
    subprocess.run([*map(str, [COSIM, *SYSTEM, "--stop-time", stop, *arguments, "-q", "-o", "alone.csv"])], cwd=folder, check=True)
    after = os.times()
    return (after.children_user + after.children_system - before.children_user - before.children_system) / float(stop)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary, chromium() as browser:
        folder = Path(temporary)
        # Ten output instants in 0.1 s: more than a screen shows.
        frames, watched = watch(browser, folder, "--real-time=10")
        cost = alone(folder, "--real-time=10")
        print(f"{SIGNALS} signals: {frames:.0f} frames per second")
        print(f"processor time for each second of the run: {1e3 * cost:.2f} ms alone, {1e3 * watched:.2f} ms watched")
