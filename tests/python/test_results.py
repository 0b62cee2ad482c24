"""Results in Python: read to the last bit, as data frames, in notebooks and as pictures."""

import sys

import matplotlib
import numpy as np
import pytest
import rexrov
from rexrov import system_path, tables

matplotlib.use("Agg")


@pytest.fixture(scope="module")
def loop():
    return rexrov.run(system_path("paper"), stop_time=5, output_interval=0.5)


@pytest.mark.parametrize("pandas", [True, False])
def test_numbers_are_read_to_the_last_bit(tmp_path, monkeypatch, pandas):
    if not pandas:
        monkeypatch.setitem(sys.modules, "pandas", None)
        # Lines do not end where pieces do.
        monkeypatch.setattr(tables, "_PIECE", 1000)
    values = np.frombuffer(np.random.default_rng(1).bytes(8 * 3 * 999), "f8").reshape(-1, 3).copy()
    values[:, 0] = np.arange(999) / 7
    values[5] = [1e-310, np.inf, -0.0]
    table = values.view([("time", "f8"), ("a", "f8"), ("b.c", "f8")]).reshape(-1)
    tables.write(tmp_path / "x.csv", table)
    found = tables.read(tmp_path / "x.csv")
    assert found.dtype == table.dtype
    same = np.asarray(found).view("u8") == values.view("u8").ravel()
    assert (same | np.isnan(values.ravel())).all()
    (tmp_path / "empty.csv").write_text("time,a\n")
    assert tables.read(tmp_path / "empty.csv").shape == (0,)


def test_results_become_data_frames(loop):
    frame = loop.to_pandas()
    assert frame.index.name == "time" and list(frame.columns) == list(loop.dtype.names[1:])
    np.testing.assert_array_equal(frame["vehicle.pose.x"], loop["vehicle.pose.x"])
    dataset = loop.to_xarray()
    assert dataset["vehicle.pose.x"].dims == ("time",) and dataset["time"].attrs["units"] == "s"


def test_a_notebook_shows_what_there_is(loop):
    page = loop._repr_html_()
    assert "11 instants from 0 s to 5 s" in page and "vehicle.pose.x" in page
    assert loop[:0]._repr_html_() is None and type(loop["time"]) is np.ndarray


def test_a_path_is_drawn_north_up(loop):
    axes = rexrov.plot.path(loop)
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert set(lines) == {"vehicle.pose", "ekf.pose", "start"}
    np.testing.assert_array_equal(lines["ekf.pose"].get_xdata(), loop["ekf.pose.y"])
    assert axes.get_aspect() == 1.0 and axes.get_ylabel() == "north (m)"
    with pytest.raises(ValueError, match="'efk.pose.x' and 'efk.pose.y' were not recorded"):
        rexrov.plot.path(loop, estimates=["efk.pose"])
