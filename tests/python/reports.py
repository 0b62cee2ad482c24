"""A campaign, its report, and the page on which Chromium opens it: shared by the tests of reports."""

import json
import re
import subprocess

import pytest
from browser import browser, problems
from conftest import COSIM, FMUS, ROOT
from playwright.sync_api import expect

CAMPAIGN = """
description = "Is the dynamic filter good enough, and is <script>alert('it')</script> text?"
seed = 7
seeds = {seeds}
stop-time = 30
output-interval = 0.5

[systems]
paper = "{root}/examples/paper.ssd"

[replacements.dynamic]

[replacements.kinematic]
ekf = "{fmus}/EkfKinematic.fmu"

[scenarios]
nominal = ""
"fix <b>lost</b>" = "lost.toml"

[dispersions]
"vehicle.current.east" = {{ kind = "uniform", min = -0.1, max = 0.1 }}

[figures]
ate = {{ kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose" }}
nees = {{ kind = "nees", truth = "vehicle.pose", estimate = "ekf.pose", sigma = "ekf.sigma", covariance = "ekf.covariance", axes = ["x", "y"], every = 5 }}
north = {{ kind = "error", of = "ekf.pose.x", minus = "vehicle.pose.x", sigma = "ekf.sigma.x", every = 5 }}

[[verdict]]
figure = "ate"
at-most = 20

[[verdict]]
figure = "ate"
at-most = 0.001
cells = "*kinematic*"
"""
LOST = """
[[fault]]
kind = "drop-out"
on = ["gps.position.x", "gps.position.y", "gps.stamp"]
from = 10
for = 10
"""
HEAD_OF_RUN = re.compile(r"Run \d+ of paper/")


def cosim(folder, *arguments, code=0):
    done = subprocess.run([COSIM, *arguments], cwd=folder, capture_output=True, text=True)
    assert code is None or done.returncode == code, done.stderr
    return done


def data(file):
    text = file.read_text()
    return json.loads(text.split('id="data">')[1].split("</script>")[0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a small finished campaign, and its report."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "c.toml").write_text(CAMPAIGN.format(seeds=8, root=ROOT, fmus=FMUS))
    (folder / "lost.toml").write_text(LOST)
    cosim(folder, "campaign", "c.toml", "-q", code=1)
    cosim(folder, "report", "c_campaign")
    return folder


@pytest.fixture(scope="module")
def report(folder):
    return folder / "c_campaign" / "report.html"


@pytest.fixture
def page(browser):
    """A page on which every error, and every request except that of the report itself, fails the test."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    wrong = problems(page)
    page.on("request", lambda request: wrong.append(request.url) if not request.url.startswith("file:") else None)
    yield page
    assert not wrong
    context.close()


def open_cell(page, file, name):
    page.goto("about:blank")
    page.goto(file.as_uri())
    page.evaluate("name => location.hash = `#${encodeURIComponent(name)}`", name)
    expect(page.locator("h1")).to_have_text(name)


def shown_run(report):
    reported = data(report)
    cell = reported["campaign"]["cells"][0]
    run = cell["shown"][0]["run"]
    return reported["runs"][str(run)], run, cell["name"]


def open_run(page, report):
    trace, run, name = shown_run(report)
    page.goto(report.as_uri())
    page.evaluate("([name, run]) => location.hash = `#${encodeURIComponent(name)}/${run}`", [name, run])
    expect(page.locator("h1")).to_have_text(HEAD_OF_RUN)
    return trace
