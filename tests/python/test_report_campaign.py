"""Reports of campaigns as users use them: Chromium opens them from disk, clicks, and reads.

A browser is needed (`cargo xtask test` unpacks Debian's); without one these tests are skipped.
"""

import json
import re
import shutil
import time
import unicodedata

import pandas
import pytest
from axe_playwright_python.sync_playwright import Axe
from browser import browser, draw_all, needs_chromium
from conftest import FMUS, ROOT
from playwright.sync_api import expect
from pypdf import PdfReader
from reports import CAMPAIGN, HEAD_OF_RUN, LOST, cosim, data, folder, open_cell, open_run, page, report

pytestmark = needs_chromium


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


def test_errors_are_shown_along_the_length_of_the_outage(page, tmp_path):
    """One scenario in which it is drawn for each run, and two that differ only in it."""
    text = CAMPAIGN.format(seeds=8, root=ROOT, fmus=FMUS)
    scenarios = 'nominal = ""\n' + "".join(f'{name} = "{name}.toml"\n' for name in ["any", "short", "long"])
    text = re.sub(r"nominal = .*?\[figures\]", lambda _: scenarios + "\n[figures]", text, flags=re.DOTALL)
    (tmp_path / "o.toml").write_text(text)
    for name, length in [("any", [2, 18]), ("short", 5), ("long", 15)]:
        (tmp_path / f"{name}.toml").write_text(LOST.replace("for = 10", f"for = {length}"))
    cosim(tmp_path, "campaign", "o.toml", "-q", code=1)
    cosim(tmp_path, "report", "o_campaign")
    file = tmp_path / "o_campaign" / "report.html"
    reported = data(file)
    assert reported["campaign"]["inputs"] == [{"name": "outage length", "unit": "s"}]
    cells = {cell["name"]: cell for cell in reported["campaign"]["cells"]}
    sample = cells["paper/kinematic/any"]["sample"]
    lengths = dict(zip(sample["run"], sample["inputs"][0]))
    assert len(set(lengths.values())) == 8 and all(2 < length < 18 for length in lengths.values())
    for run, trace in reported["runs"].items():
        if int(run) in lengths:
            [fault] = trace["faults"]
            assert fault["until"] - fault["from"] == pytest.approx(lengths[int(run)], rel=1e-4)
    open_cell(page, file, "paper/kinematic/any")
    correlation = page.locator("table:has(caption:text('Rank correlation')) tbody tr")
    expect(correlation).to_have_count(1)
    expect(correlation).to_contain_text("outage length")
    expect(page.locator("figcaption", has_text="ate against outage length")).to_be_visible()
    # Of the two scenarios with one length each, and the one without an outage.
    open_cell(page, file, "paper/kinematic/long")
    expect(page.locator("figcaption", has_text="ate along outage length")).to_be_visible()
    assert [cells[f"paper/kinematic/{name}"]["outage"]["length"] for name in ["nominal", "short", "long"]] == [0, 5, 15]
    open_cell(page, file, "paper/kinematic/nominal")
    assert page.locator("figcaption", has_text="outage length").count() == 0


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
    text = "\n".join(sheet.extract_text() for sheet in PdfReader(tmp_path / "page.pdf").pages)
    # Fonts have ligatures.
    text = unicodedata.normalize("NFKC", text)
    for part in ["Is the dynamic filter good enough", "fail", "Thresholds of all cells", "Sensitivity", "Clopper", "system paper is"]:
        assert part in text, part
    assert re.search(r"\b[0-9a-f]{64}\b", text)
    # It is closed again.
    assert page.locator("#end details[open]").count() == 0


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
