"""Frames per second of the live page with 100 signals, and what it costs the run: `python tests/python/live_rate.py`.

It needs what the tests need, and a browser. Both are on this machine, so they share its cores.
"""

import os
import subprocess
import tempfile
import time
from pathlib import Path

from browser import chromium
from conftest import COSIM
from playwright.sync_api import expect
from test_live import SYSTEM, Live, status

SIGNALS = 100
SECONDS = 10
STOP = "600"
# 100 output instants in a second: more than a screen shows.
FACTOR = 10
PACE = [f"--real-time={FACTOR}"]


def processor(child):
    """Processor time of a running process (s)."""
    fields = Path(f"/proc/{child.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watch(browser, folder):
    """A run in real time with a page: its frames per second, and processor time for each second of the run."""
    with Live(folder, "--stop-time", STOP, *PACE) as live:
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


def alone(folder):
    """Processor time of the same run without a server, for each second of it."""
    command = [COSIM, *SYSTEM, "--stop-time", STOP, *PACE, "-q", "-o", "alone.csv"]
    process = subprocess.Popen([*map(str, command)], cwd=folder)
    time.sleep(2)
    before = processor(process)
    time.sleep(SECONDS)
    used = processor(process) - before
    process.kill()
    process.wait()
    return used / (SECONDS * FACTOR)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary, chromium() as browser:
        folder = Path(temporary)
        frames, watched = watch(browser, folder)
        cost = alone(folder)
        print(f"{SIGNALS} signals: {frames:.0f} frames per second")
        print(f"processor time for each second of the run: {1e3 * cost:.2f} ms alone, {1e3 * watched:.2f} ms watched")
