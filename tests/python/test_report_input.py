"""Reports of results that are incomplete, damaged or hostile: the page says what is missing and shows the rest."""

import re
import shutil

from browser import browser, draw_all, needs_chromium
from conftest import ROOT
from playwright.sync_api import expect
from reports import cosim, data, folder, page, report

pytestmark = needs_chromium

PAPER = str(ROOT / "examples" / "paper.ssd")


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


def test_results_without_their_end_are_shown_as_far_as_they_go(page, tmp_path):
    """A run that was killed: MCAP is cut within a chunk, CSV within a row, Parquet before its footer."""
    for ending in ["mcap", "csv", "parquet"]:
        cosim(tmp_path, "run", PAPER, "--stop-time", "20", "--output-interval", "0.05", "-q", "-o", f"run.{ending}")
        file = tmp_path / f"run.{ending}"
        file.write_bytes(file.read_bytes()[: file.stat().st_size * 2 // 3])
    for ending, sign in [("mcap", "it has no footer"), ("csv", "its last line has no end")]:
        reported = cosim(tmp_path, "report", f"run.{ending}", "-o", f"{ending}.html").stderr
        last = data(tmp_path / f"{ending}.html")["runs"][""]["stop"]
        assert 10 < last < 15
        said = f"the file ends early, as after a run that was killed ({sign}): there is nothing after t = {last} s"
        assert said in reported
        page.goto((tmp_path / f"{ending}.html").as_uri())
        expect(page.locator(".notes")).to_contain_text(said)
        expect(page.locator("#map canvas")).to_have_count(1)
    refused = cosim(tmp_path, "report", "run.parquet", code=None)
    assert refused.returncode != 0
    for part in ["run.parquet", "its end is missing", "repeat the run; CSV and MCAP can be read as far as they were written"]:
        assert part in refused.stderr
    (tmp_path / "head.csv").write_text("time,vehicle.pose.x,vehic")
    assert "end within their first line" in cosim(tmp_path, "report", "head.csv", code=None).stderr
