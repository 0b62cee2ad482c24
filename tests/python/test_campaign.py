"""The table of a campaign's runs and the results of a single run, as data tools read them."""

import os
import subprocess
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow.parquet
import pytest

from conftest import ROOT

CAMPAIGN = """
seed = 1
seeds = 3
stop-time = 2
output-interval = 0.5
[systems]
paper = "{root}/examples/paper.ssd"
[scenarios]
nominal = ""
outage = "{root}/examples/campaign/faults/fix_outage.toml"
wrong = {{ start-values = {{ "dvl.seed" = 3 }} }}
[dispersions]
"vehicle.current.east" = {{ kind = "normal", mean = 0, sigma = 0.05 }}
"pursuit.course" = {{ kind = "choice", of = ["BE1", "BE3"] }}
[figures]
ate = {{ kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose" }}
during = {{ kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose", window = "during" }}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A finished campaign, and one of its runs repeated as CSV and Parquet."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "c.toml").write_text(CAMPAIGN.format(root=ROOT).replace("stop-time = 2", "stop-time = 62"))
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))

    def run(*arguments):
        subprocess.run([target / "release" / "cosim", *arguments], cwd=folder, check=True, capture_output=True)

    run("campaign", "c.toml", "--csv")
    run("replay", "c_campaign", "1", "-o", "run.parquet")
    run("replay", "c_campaign", "1", "-o", "run.csv")
    return folder


def test_three_readers_see_the_same_rows(folder):
    file = folder / "c_campaign" / "runs.parquet"
    rows = pandas.read_parquet(file)
    assert list(rows["run"]) == list(range(9)) and set(rows["status"]) == {"ok"}
    assert list(rows["scenario"][:3]) == ["nominal", "outage", "wrong"]
    assert rows["vehicle.current.east"].dtype == float and set(rows["pursuit.course"]) <= {"BE1", "BE3"}
    # Only runs with a fault have values during it.
    assert list(rows["during"].isna()) == [True, False, True] * 3
    text = pandas.read_csv(folder / "c_campaign" / "runs.csv")
    assert (text["ate"] == rows["ate"]).all() and (text["digest"] == rows["digest"]).all()
    assert polars.read_parquet(file)["ate"].to_list() == rows["ate"].to_list()
    query = f"SELECT scenario, count(*), median(ate) FROM '{file}' GROUP BY scenario ORDER BY scenario"
    by_scenario = rows.groupby("scenario")["ate"].median()
    assert duckdb.sql(query).fetchall() == [(name, 3, by_scenario[name]) for name in by_scenario.index]


def test_the_table_says_what_it_is_of(folder):
    metadata = pyarrow.parquet.read_metadata(folder / "c_campaign" / "runs.parquet").metadata
    identity = metadata[b"cosim.identity"].decode()
    assert metadata[b"cosim.seed"] == b"1" and "system paper is " in identity and "scenario outage is " in identity


def test_results_of_a_run_are_the_same_as_parquet_and_as_csv(folder):
    binary = pandas.read_parquet(folder / "run.parquet")
    text = pandas.read_csv(folder / "run.csv", float_precision="round_trip")
    assert list(binary.columns) == list(text.columns)
    pandas.testing.assert_frame_equal(binary, text, check_dtype=False, check_exact=True)
