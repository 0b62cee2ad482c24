"""Reports as users use them: Chromium opens them from disk, clicks, and reads.

A browser is needed (Debian: `apt-get install chromium`); without one these tests are skipped.
"""

import csv
import json
import math
import re
import shutil
import subprocess
import time

import pandas
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
    for title in ["nees: mean over the runs", "north: errors of the runs (m)"]:
        expect(page.locator("figcaption", has_text=title)).to_be_visible()
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


def test_errors_of_all_runs_beside_the_claimed_ones(page, folder, report):
    """The values under the cursor are the quantiles of the table's columns."""
    rows = pandas.read_parquet(folder / "c_campaign" / "runs.parquet")
    name = "paper/kinematic/nominal"
    rows = rows[rows["cell"] == name]
    open_cell(page, report, name)
    figure = page.locator("figure.plot", has_text="north: errors of the runs")
    figure.scroll_into_view_if_needed()
    # The instants are 5 s to 30 s; a key moves the cursor by a thousandth of that.
    page.locator("#time").focus()
    page.keyboard.press("End")
    expect(figure.locator(".u-legend .u-value").first).to_have_text("30 s")
    page.locator("#time").fill("400")
    shown = [float(text.removesuffix(" m").removesuffix(" s").replace("−", "-")) for text in figure.locator(".u-legend .u-value").all_inner_texts()]
    errors = rows["north@15"]
    wanted = [15, *(errors.quantile(p) for p in [0.05, 0.25, 0.5, 0.75, 0.95]), 3 * rows["north.sigma@15"].median()]
    assert shown[:7] == pytest.approx(wanted, rel=1e-3)


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


def open_cell(page, file, name):
    page.goto("about:blank")
    page.goto(file.as_uri())
    page.evaluate("name => location.hash = `#${encodeURIComponent(name)}`", name)
    expect(page.locator("h1")).to_have_text(name)


@pytest.mark.parametrize("count", [32, 1000, 100_000, 1_000_000])
def test_as_many_runs_as_there_are(page, folder, tmp_path, count):
    """Artificial rows: a page stays small, opens fast, and leads to the runs that it shows."""
    shutil.copytree(folder / "c_campaign", tmp_path / "c_campaign")
    manifest = tmp_path / "c_campaign" / "campaign.json"
    manifest.write_text(manifest.read_text().replace(str(folder / "c.toml"), str(tmp_path / "c.toml")))
    (tmp_path / "c.toml").write_text(CAMPAIGN.format(seeds=count // 4, root=ROOT, fmus=FMUS))
    (tmp_path / "lost.toml").write_text(LOST)
    log = tmp_path / "c_campaign" / "runs.jsonl"
    pattern = ('{{"run":{run},"status":"ok","reason":"","inputs":["{input}"],"simulated":"30","figures":["{ate}","{nees}"{more}],'
               '"digest":"%s","cpu_ms":"1"}}\n' % ("0" * 64))
    with log.open("a") as rows:
        for run in range(32, count):
            value = (run * 0.6180339887) % 1
            # The error, then NEES, errors and claims at each instant.
            more = f',"{value}"' * 19
            rows.write(pattern.format(run=run, input=value * 0.2 - 0.1, ate=1 + value, nees=2 * value, more=more))
    started = time.monotonic()
    cosim(tmp_path, "report", "c_campaign", "--runs-per-cell", "3")
    written = time.monotonic() - started
    log.unlink()
    file = tmp_path / "c_campaign" / "report.html"
    page.goto("about:blank")
    page.goto(file.as_uri())
    expect(page.locator("#matrix")).to_be_visible()
    loaded = page.evaluate("performance.getEntriesByType('navigation')[0].domComplete")
    print(f"{count} rows: {file.stat().st_size / 1e6:.2f} MB, written in {written:.1f} s, loaded in {loaded:.0f} ms")
    assert file.stat().st_size <= 5_000_000
    reported = data(file)["campaign"]
    assert reported["runs"] == count
    cell = reported["cells"][0]
    assert [shown["why"] for shown in cell["shown"]] == ["worst", "median", "between"]
    for shown in cell["shown"]:
        open_cell(page, file, cell["name"])
        row = page.locator("table:has(caption:text('Runs:')) tbody tr").filter(has_text=f"{shown['why']}")
        expect(row.locator("td").first).not_to_have_text("–")
        row.get_by_role("link", name=f"run {shown['run']}", exact=True).click()
        expect(page.locator("h1")).to_have_text(f"Run {shown['run']} of {cell['name']}")


def test_what_is_missing_is_not_zero(page, tmp_path):
    """The truth has a gap, and a heading of its own gap."""
    names = ["time", "t.pose.x", "t.pose.y", "t.pose.yaw", "e.pose.x", "e.pose.y", "e.sigma.x", "e.sigma.y"]
    rows = []
    for time in range(101):
        known = not 40 <= time < 60
        truth = [100 + time, 50] if known else ["NaN", 50 if time < 50 else "NaN"]
        rows.append([time, *truth, 1.5 if time < 80 else "NaN", 100 + time, 51, 0.5, 0.5])
    with (tmp_path / "gap.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    cosim(tmp_path, "report", "gap.csv")
    page.goto((tmp_path / "gap.html").as_uri())
    apart = page.locator("#instant tbody tr", has_text="e.pose").locator("td").nth(3)
    arrow = page.locator("#map .vehicle").first
    for time, distance, round_mark in [(20, "1", False), (45, "–", None), (55, "–", None), (90, "1", True)]:
        page.evaluate("time => { const slider = document.getElementById('time'); slider.value = time * 10; slider.dispatchEvent(new Event('input')); }", time)
        expect(apart).to_have_text(distance)
        shown = None if arrow.get_attribute("hidden") is not None else "round" in arrow.get_attribute("class")
        assert shown == round_mark
    # No point of the map is at the instant of a gap.
    over = page.locator("#map .u-over")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    for part in range(0, 101, 2):
        page.mouse.move(box["x"] + box["width"] * part / 100, box["y"] + box["height"] / 2)
    assert "NaN" not in page.locator("output").inner_text()


@pytest.fixture(scope="module")
def varied(tmp_path_factory):
    """A campaign with a factor and a run that failed; the second cell of three has no finished run."""
    folder = tmp_path_factory.mktemp("varied")
    text = CAMPAIGN.format(seeds=6, root=ROOT, fmus=FMUS).replace("stop-time = 30", "stop-time = 5")
    text = re.sub(r"\[replacements.dynamic\].*\[dispersions\]", '[factors]\n"gps.sigma" = [0.5, 1, 1.5]\n\n[dispersions]', text, flags=re.DOTALL)
    (folder / "v.toml").write_text(text)
    cosim(folder, "campaign", "v.toml", "-q", code=None)
    log = folder / "v_campaign" / "runs.jsonl"
    rows = [json.loads(line) for line in log.read_text().splitlines()]
    failed = next(row for row in rows if row["run"] == 3)
    failed.update(status="failed", reason="it <b>ran</b> away", figures=[], digest="")
    log.write_text("".join(json.dumps(row) + "\n" for row in rows if row["run"] % 3 != 1))
    cosim(folder, "report", "v_campaign")
    return folder / "v_campaign" / "report.html"


def test_factors_failures_and_cells_without_runs(page, varied):
    page.goto(varied.as_uri())
    expect(page.locator("#matrix tbody tr")).to_have_count(3)
    page.locator("summary", has_text="Figures of all cells").click()
    empty = page.locator("details table tbody tr").filter(has=page.get_by_role("link", name=re.compile(r"gps\.sigma=1$"))).first
    assert empty.locator("td").all_inner_texts()[1:] == ["0", "–", "–"]
    failures = page.locator("table:has(caption:text('Failures by their reason')) tbody tr")
    expect(failures).to_contain_text("it <b>ran</b> away")
    failures.get_by_role("link").click()
    expect(page.get_by_role("heading", name="Failed runs")).to_be_visible()
    expect(page.locator("pre.command").first).to_contain_text(" 3 --output-file run3.csv")
    # What the figure depends on.
    expect(page.locator("caption", has_text="Rank correlation with dispersed parameters")).to_be_visible()
    expect(page.locator("figcaption", has_text="ate against vehicle.current.east")).to_be_visible()
    expect(page.locator("figcaption", has_text="ate along gps.sigma")).to_be_visible()
    page.get_by_role("link", name="3", exact=True).click()
    expect(page.locator("h1")).to_have_text("Run 3 of paper/gps.sigma=0.5")
    expect(page.locator(".notes")).to_have_text("It failed: it <b>ran</b> away")


def test_a_point_of_a_box_plot_is_its_run(page, varied):
    name = "paper/gps.sigma=0.5"
    open_cell(page, varied, name)
    figure = page.locator("figure.plot", has_text="box plot")
    figure.scroll_into_view_if_needed()
    box = figure.locator(".u-over").bounding_box()
    for across, down in [(x, y) for x in range(5, 95, 4) for y in range(4, 100, 5)]:
        page.mouse.click(box["x"] + box["width"] * across / 100, box["y"] + box["height"] * down / 100)
        if figure.count() == 0:
            break
    expect(page.locator("h1")).to_have_text(re.compile(rf"Run \d+ of {re.escape(name)}"))


def test_addresses_that_were_decoded_or_are_wrong(page, report):
    cell = data(report)["campaign"]["cells"][1]
    run = cell["shown"][0]["run"]
    page.goto(report.as_uri())
    for address in [f"#{cell['name']}/{run}", "#" + cell["name"].replace("/", "%2F") + f"/{run}"]:
        page.evaluate("address => location.hash = address", address)
        expect(page.locator("h1")).to_have_text(f"Run {run} of {cell['name']}")
    page.evaluate("address => location.hash = address", f"#{cell['name']}")
    expect(page.locator("h1")).to_have_text(cell["name"])
    for wrong, said in [(999_999, "There is no run 999999: the runs are 0 to 31."), (run + 1, f"Run {run + 1} belongs to another cell")]:
        page.evaluate("address => location.hash = address", f"#{cell['name']}/{wrong}")
        expect(page.locator("#view")).to_contain_text(said)
        assert page.locator("#view pre").count() == 0
    page.evaluate("location.hash = '#nothing/7'")
    expect(page.locator("#view")).to_contain_text("no cell 'nothing/7'")


def test_a_campaign_without_figures_leads_to_its_runs(page, tmp_path):
    text = CAMPAIGN.format(seeds=2, root=ROOT, fmus=FMUS).replace("stop-time = 30", "stop-time = 5")
    text = text.split("[figures]")[0].replace('"fix <b>lost</b>" = "lost.toml"\n', "")
    (tmp_path / "n.toml").write_text(text)
    cosim(tmp_path, "campaign", "n.toml", "-q")
    cosim(tmp_path, "report", "n_campaign")
    page.goto((tmp_path / "n_campaign" / "report.html").as_uri())
    page.locator("#matrix td a").first.click()
    page.locator("table:has(caption:text('Runs')) a").first.click()
    expect(page.locator("h1")).to_have_text(HEAD_OF_RUN)
    expect(page.locator("#map canvas")).to_be_visible()


def test_it_is_printed_with_everything_for_an_audit(page, report, tmp_path):
    page.goto(report.as_uri())
    page.pdf(path=tmp_path / "page.pdf")
    text = subprocess.run(["pdftotext", "-layout", tmp_path / "page.pdf", "-"], capture_output=True, text=True, check=True).stdout
    for part in ["Is the dynamic filter good enough", "fail", "Thresholds of all cells", "Sensitivity", "Clopper", "system paper is"]:
        assert part in text, part
    assert re.search(r"\b[0-9a-f]{64}\b", text)
    # It is closed again.
    assert page.locator("#end details[open]").count() == 0


def picture(page, canvas):
    """The pixels of a canvas after it was drawn."""
    page.evaluate("() => new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)))")
    return canvas.evaluate("canvas => canvas.toDataURL()")


def test_a_dive_is_seen_from_all_sides(page, tmp_path):
    names = ["time", *[f"{of}.pose.{axis}" for of in "te" for axis in "xyz"], "e.sigma.x", "e.sigma.y", "t.thruster[0].thrust", "t.thruster[1].thrust", "t.health", "t.mass"]
    turn = [(i / 10, math.cos(i / 30), math.sin(i / 30)) for i in range(200)]
    rows = [[t, 20 * x, 20 * y, t, 20 * x + 0.3, 20 * y, t + 0.1, 0.4, 0.4, 10 * x, 10 * y, int(t > 12), 1863] for t, x, y in turn]
    with (tmp_path / "dive.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    cosim(tmp_path, "report", "dive.csv")
    page.goto((tmp_path / "dive.html").as_uri())
    draw_all(page)
    for heading in ["Thrust", "Health"]:
        expect(page.get_by_role("heading", name=heading)).to_be_visible()
    space = page.locator("figure.plot", has_text="Path in space")
    space.scroll_into_view_if_needed()
    before = picture(page, space.locator("canvas"))
    space.get_by_label("seen from").fill("120")
    assert picture(page, space.locator("canvas")) != before
    canvas = page.locator("#map canvas")
    canvas.scroll_into_view_if_needed()
    whole = picture(page, canvas)
    page.get_by_role("button", name="zoom in: map").click()
    assert picture(page, canvas) != whole
    page.get_by_role("button", name="show all: map").click()
    assert picture(page, canvas) == whole
    # What is not plotted is found all the same.
    page.locator("summary", has_text="All signals").click()
    for word, said in [("mass", "there is no room: 1 with this word"), ("nothing", "No variable has this word")]:
        page.get_by_label("Search").fill(word)
        expect(page.locator("details[open]").first).to_contain_text(said)


def test_recordings_that_lack_things_are_opened(page, tmp_path):
    (tmp_path / "nan.csv").write_text("time,a.pose.x,a.pose.y,b\n0,NaN,NaN,NaN\n1,NaN,NaN,NaN\n")
    (tmp_path / "bare.csv").write_text("time,a,b\n0,1,2\n1,2,3\n")
    (tmp_path / "none.csv").write_text("time,a.pose.x,a.pose.y\n")
    columns = [f"c{i // 100}.value[{i}]" for i in range(10_000)]
    rows = [",".join([str(row), *(str(row * i % 97) for i in range(10_000))]) for row in range(50)]
    (tmp_path / "wide.csv").write_text("\n".join([",".join(["time", *columns]), *rows]) + "\n")
    for name, said in [("nan", "no finite position"), ("bare", "no truth is recorded"), ("none", "no instant is recorded"), ("wide", "2000 of")]:
        cosim(tmp_path, "report", f"{name}.csv")
        page.goto((tmp_path / f"{name}.html").as_uri())
        expect(page.locator("#view")).to_contain_text(said)
        draw_all(page)


def test_an_empty_folder_says_so_and_nothing_else(page, tmp_path):
    (tmp_path / "empty").mkdir()
    cosim(tmp_path, "report", "empty")
    page.goto((tmp_path / "empty" / "report.html").as_uri())
    expect(page.locator(".notes")).to_contain_text("the folder is empty")
    expect(page.locator("#end")).to_have_text(re.compile(r"^Method and provenanceReported bycosim [\d.]+$"))


def test_a_folder_that_was_half_written_is_opened(page, folder, tmp_path):
    shutil.copytree(folder / "c_campaign", tmp_path / "c_campaign")
    log = tmp_path / "c_campaign" / "runs.jsonl"
    log.write_bytes(log.read_bytes()[: log.stat().st_size // 3])
    cosim(tmp_path, "report", "c_campaign")
    page.goto((tmp_path / "c_campaign" / "report.html").as_uri())
    expect(page.locator(".notes")).to_contain_text("runs have not been made yet")
    for cell in range(4):
        page.evaluate("location.hash = ''")
        page.locator("#matrix td a").nth(cell).click()
        draw_all(page)
    manifest = tmp_path / "c_campaign" / "campaign.json"
    manifest.write_bytes(manifest.read_bytes()[:100])
    cosim(tmp_path, "report", "c_campaign")
    page.goto((tmp_path / "c_campaign" / "report.html").as_uri())
    expect(page.locator(".notes")).to_contain_text("only the states of runs are shown")
    expect(page.locator("table:has(caption:text('Runs by how they ended'))")).to_contain_text("ok")


PAPER = ROOT / "target" / "reproduce" / "report.html"


@pytest.mark.skipif(not PAPER.exists(), reason=f"{PAPER} is missing: `cargo xtask reproduce` writes it")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_paper_s_page_is_a_campaign_with_the_paper_s_tables(page, scheme):
    assert PAPER.stat().st_size <= 5_000_000
    page.emulate_media(color_scheme=scheme)
    page.goto(PAPER.as_uri())
    expect(page.locator(".summary").first).to_contain_text("of 21 goals")
    for number, course in [(7, "BE1"), (8, "BE2"), (9, "BE3")]:
        expect(page.locator("caption", has_text=f"Table {number}: {course}")).to_be_visible()
    pictures = page.locator("figure img")
    assert pictures.count() >= 7
    widths = pictures.evaluate_all("async list => { await Promise.all(list.map((one) => one.decode())); return list.map((one) => one.naturalWidth); }")
    assert all(width > 0 for width in widths)
    page.get_by_role("navigation", name="Sections").get_by_role("button", name="Goals", exact=True).click()
    expect(page.locator("h2:focus")).to_have_text("Goals")
    found = Axe().run(page).response["violations"]
    assert not [v for v in found if v["impact"] in ("serious", "critical")], found
    page.set_viewport_size({"width": 400, "height": 800})
    draw_all(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    page.locator("#matrix td a").first.click()
    page.locator("table:has(caption:text('Runs:')) a").first.click()
    expect(page.locator("h1")).to_have_text(HEAD_OF_RUN)
    expect(page.locator("#map canvas")).to_be_visible()
