"""Reports as users use them: Chromium opens them from disk, clicks, and reads.

A browser is needed (Debian: `apt-get install chromium`); without one these tests are skipped.
"""

import json
import os
import re
import shutil
import subprocess

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser import browser, draw_all, needs_chromium, problems
from conftest import COSIM, FMUS, ROOT
from playwright.sync_api import expect

pytestmark = needs_chromium

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
    assert done.returncode == code, done.stderr
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


def test_from_the_matrix_to_a_run_and_back(page, report):
    page.goto(report.as_uri())
    expect(page.locator("#verdict")).to_contain_text("fail")
    assert "<script>alert('it')</script> text?" in page.locator(".question").inner_text()
    expect(page.locator("#matrix tbody th").nth(0)).to_have_text("fix <b>lost</b>")
    cells = page.locator("#matrix td a")
    assert cells.count() == 4
    reported = {cell["name"]: cell for cell in data(report)["campaign"]["cells"]}
    name = "paper/kinematic/fix <b>lost</b>"
    page.select_option("label:has-text('Statistic') select", label="95th percentile")
    cell = page.locator("#matrix tbody tr").filter(has_text="lost").locator("td a").nth(1)
    shown = float(cell.locator("span").nth(0).inner_text())
    assert shown == pytest.approx(reported[name]["figures"][0]["percentile_95"]["value"], rel=0.01)
    cell.click()
    expect(page.locator("h1")).to_have_text(name)
    expect(page.locator("text=Consistency: means over the runs")).to_be_visible()
    expect(page.get_by_role("heading", name="Consistency over time")).to_be_visible()
    page.locator("table:has(caption:text('Runs:')) a").first.click()
    expect(page.locator("h1")).to_have_text(HEAD_OF_RUN)
    expect(page.locator("#map canvas")).to_have_count(1)
    expect(page.locator("text=drop-out of gps.position.x").first).to_be_visible()
    address = page.url
    page.go_back()
    expect(page.locator("h1")).to_have_text(name)
    page.go_back()
    expect(page.locator("#matrix")).to_be_visible()
    # The address can be sent.
    page.goto("about:blank")
    page.goto(address)
    expect(page.locator("h1")).to_have_text(HEAD_OF_RUN)


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


def test_one_cursor_for_all_plots_and_the_map(page, report):
    trace = open_run(page, report)
    draw_all(page)
    plot = next(plot for plot in trace["plots"] if plot["title"] == "ekf.pose.x: error")
    figure = page.locator("figure.plot").filter(has_text="ekf.pose.x: error")
    figure.scroll_into_view_if_needed()
    box = figure.locator(".u-over").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    legend = figure.locator(".u-legend .u-value")
    time = float(legend.nth(0).inner_text().removesuffix(" s"))
    assert time == pytest.approx(15, abs=0.6)
    place = min(range(len(plot["t"])), key=lambda i: abs(plot["t"][i] - time))
    shown = float(legend.nth(1).inner_text().removesuffix(" m").replace("−", "-"))
    assert shown == pytest.approx(plot["lines"][0]["v"][place], rel=1e-3)
    # The other plots and the map are at the same instant.
    other = page.locator("figure.plot").filter(has_text="ekf.pose.y: error").locator(".u-legend .u-value").nth(0)
    assert float(other.inner_text().removesuffix(" s")) == pytest.approx(time, abs=0.6)
    assert float(page.locator("output").inner_text()[4:-2]) == pytest.approx(time, abs=0.6)
    # The slider moves the vehicle.
    arrow = page.locator("#map .vehicle").first
    before = arrow.get_attribute("style")
    page.locator("#time").focus()
    page.keyboard.press("End")
    assert arrow.get_attribute("style") != before
    north = float(page.locator("#instant tbody tr").nth(0).locator("td").nth(0).inner_text().replace("−", "-"))
    assert north == pytest.approx(trace["map"]["paths"][0]["x"][-1], rel=1e-3)
    # Zooming one plot zooms all; double-click resets the zoom.
    figure.scroll_into_view_if_needed()
    box = figure.locator(".u-over").bounding_box()
    page.mouse.move(box["x"] + 50, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 150, box["y"] + 40, steps=4)
    page.mouse.up()
    other = page.locator("figure.plot").filter(has_text="ekf.pose.y: error").locator(".u-over")
    other.hover(position={"x": 1, "y": 20})
    first = page.locator("figure.plot").filter(has_text="ekf.pose.y: error").locator(".u-legend .u-value").nth(0)
    assert float(first.inner_text().removesuffix(" s")) > 1
    other.dblclick()
    other.hover(position={"x": 1, "y": 20})
    assert float(first.inner_text().removesuffix(" s")) < 1


@pytest.mark.parametrize("view", ["matrix", "cell", "run"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everybody_can_read_it(page, report, view, scheme):
    page.emulate_media(color_scheme=scheme)
    if view == "run":
        open_run(page, report)
    else:
        page.goto(report.as_uri())
        if view == "cell":
            page.locator("#matrix td a").first.click()
    draw_all(page)
    found = Axe().run(page).response["violations"]
    serious = [f"{v['id']}: {v['nodes'][0]['html'][:200]}" for v in found if v["impact"] in ("serious", "critical")]
    print(f"axe-core, {view}, {scheme}: {len(found)} findings, {len(serious)} of them serious")
    assert not serious
    page.set_viewport_size({"width": 400, "height": 800})
    draw_all(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 400


def test_colours_are_chosen(page, report):
    page.emulate_media(color_scheme="light")
    page.goto(report.as_uri())
    paper = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(paper)
    page.click("#theme")
    assert page.evaluate(paper) != light
    page.click("#theme")
    assert page.evaluate(paper) == light


def test_nothing_of_the_data_is_markup(page, folder, tmp_path):
    name = "<img src=x onerror=document.title='bad'>.pose.x"
    (tmp_path / "odd.csv").write_text(f'time,"{name}","a.</script><b>"\n0,1,2\n1,2,3\n')
    cosim(tmp_path, "report", "odd.csv", "--title", "<i>odd</i> & \"so\"")
    page.goto((tmp_path / "odd.html").as_uri())
    expect(page.locator("h1")).to_have_text('<i>odd</i> & "so"')
    page.locator("summary", has_text="All variables").click()
    expect(page.get_by_role("rowheader", name=name)).to_be_visible()
    assert page.locator("img, i:not([class]), b").count() == 0
    assert page.title() == '<i>odd</i> & "so"'


def test_a_run_of_its_own(page, folder):
    options = ["--stop-time", "20", "--output-interval", "0.1", "-q", "-o", "run.csv"]
    cosim(folder, "run", str(ROOT / "examples" / "paper.ssd"), *options)
    cosim(folder, "report", "run.csv", "--system", str(ROOT / "examples" / "paper.ssd"))
    page.goto((folder / "run.html").as_uri())
    draw_all(page)
    expect(page.locator("#map canvas")).to_be_visible()
    page.locator("summary", has_text="All signals").click()
    expect(page.locator("details figure.plot").first).to_be_visible()
    page.get_by_label("Search").fill("pressure")
    expect(page.locator("details figure.plot").first).to_contain_text("pressure")
    # Every axis has one unit, and it is known.
    reported = data(folder / "run.html")["runs"][""]
    unknown = {plot["title"] for plot in reported["plots"] + reported["signals"] if not plot["unit"]}
    assert not unknown


def test_as_many_runs_as_there_are(page, folder, tmp_path):
    """Artificial rows: a page stays small and opens fast."""
    count = int(os.environ.get("REPORT_ROWS", "100000"))
    shutil.copytree(folder / "c_campaign", tmp_path / "c_campaign")
    manifest = tmp_path / "c_campaign" / "campaign.json"
    manifest.write_text(manifest.read_text().replace(str(folder / "c.toml"), str(tmp_path / "c.toml")))
    (tmp_path / "c.toml").write_text(CAMPAIGN.format(seeds=count // 4, root=ROOT, fmus=FMUS))
    (tmp_path / "lost.toml").write_text(LOST)
    log = tmp_path / "c_campaign" / "runs.jsonl"
    with log.open("a") as rows:
        for run in range(32, count):
            value = (run * 0.6180339887) % 1
            row = {"run": run, "status": "ok", "reason": "", "inputs": [str(value * 0.2 - 0.1)], "simulated": "30",
                   "figures": [str(1 + value), str(2 * value)], "digest": "0" * 64, "cpu_ms": "1"}
            rows.write(json.dumps(row) + "\n")
    cosim(tmp_path, "report", "c_campaign", "--runs-per-cell", "3")
    file = tmp_path / "c_campaign" / "report.html"
    page.goto("about:blank")
    page.goto(file.as_uri())
    expect(page.locator("#matrix")).to_be_visible()
    loaded = page.evaluate("performance.getEntriesByType('navigation')[0].domComplete")
    print(f"{count} rows: {file.stat().st_size / 1e6:.2f} MB, loaded in {loaded:.0f} ms")
    assert file.stat().st_size <= 5_000_000
    assert data(file)["campaign"]["runs"] == count
