"""Smoothing of recorded missions: closer to the truth than the filter, from results and from real logs."""

import numpy as np
import pytest
import rexrov
from rexrov import SmoothingError, system_path


@pytest.fixture(scope="module")
def mission():
    """The inputs of the filter in the paper's loop, sampled often enough for its inertial unit, and the truth."""
    columns = ["vehicle.pose.?", "ekf.*"]
    return rexrov.run(system_path("paper"), stop_time=120, output=columns, output_interval=0.02)


def error(path, truth, start=30.0):
    """Horizontal error (m) from `start` on."""
    path = path[path["time"] >= start]
    off = [
        path[f"pose.{axis}"] - np.interp(path["time"], truth["time"], truth[f"vehicle.pose.{axis}"])
        for axis in "xy"
    ]
    return np.sqrt(np.mean(np.square(off).sum(axis=0)))


@pytest.mark.parametrize("fmu", ["NavConstantAcceleration", "NavDynamic", "NavInertial", "NavModelAided"])
def test_each_filter_smooths_a_recorded_mission(mission, fmu):
    path = rexrov.smooth(mission, "ekf", fmu=fmu)
    assert path.dtype.names[:2] == ("time", "pose.x") and "covariance.x_y" in path.dtype.names
    np.testing.assert_allclose(path["time"], np.arange(len(path)) * 0.1, atol=1e-9)
    assert path["time"][-1] == pytest.approx(120) and all(np.isfinite(path[n]).all() for n in path.dtype.names)
    assert error(path, mission) < 0.5


def test_what_comes_later_halves_the_uncertainty(mission):
    path = rexrov.smooth(mission, "ekf")
    middle, end = (path[np.searchsorted(path["time"], t)] for t in (60, 119.9))
    assert middle["sigma.x"] < 0.8 * end["sigma.x"]


def test_a_log_by_names_is_the_same_mission(mission):
    """Without the columns of unused inputs, and with samples omitted by NaN."""
    names = [n for n in mission.dtype.names if n.startswith(("ekf.imu.", "ekf.ahrs.", "ekf.dvl.", "ekf.fix."))]
    log = {"time": mission["time"]} | {name.removeprefix("ekf."): mission[name].copy() for name in names}
    held = np.flatnonzero(np.diff(log["dvl.stamp"], prepend=-1) == 0)
    for name in ("dvl.velocity.u", "dvl.velocity.v", "dvl.velocity.w"):
        log[name][held] = np.nan
    wanted = {name: mission[name] for name in ["time", *names]}
    wanted = rexrov.smooth(wanted, "ekf", fmu="NavInertial", parameters={"fix_sigma": np.float64(0.4)})
    found = rexrov.smooth(log, fmu="NavInertial", parameters={"fix_sigma": 0.4})
    assert found.dtype == wanted.dtype
    np.testing.assert_array_equal(found["pose.x"], wanted["pose.x"])


def test_what_is_wrong_is_said_by_name(mission):
    with pytest.raises(SmoothingError, match="did you mean 'fix_sigma'"):
        rexrov.smooth(mission, "ekf", parameters={"fix_sigmo": 1.0})
    with pytest.raises(SmoothingError, match="no column with an input of 'filter'"):
        rexrov.smooth(mission, "filter")
    with pytest.raises(SmoothingError, match="did you mean 'NavDynamic'"):
        rexrov.smooth(mission, "ekf", fmu="NavDinamic")
    log = {"time": [0.0, 0.1], "dlv.velocity.u": [0.1, 0.2]}
    with pytest.raises(SmoothingError, match="log.csv:1: column 'dlv.velocity.u' is not an input"):
        rexrov.smooth(log)
    with pytest.raises(ValueError, match="no column 'time'"):
        rexrov.smooth({"dvl.velocity.u": [0.1]})
