"""Filters, guidance and controller, each alone in FMPy."""

import numpy as np
import pytest
from fmpy import simulate_fmu

# Enumerations are set by number.
REPAIRED = 3


def run(fmu, name, start_values=None, stop_time=10.0, **options):
    return simulate_fmu(
        fmu(name),
        start_values=start_values or {},
        stop_time=stop_time,
        step_size=0.1,
        output_interval=0.1,
        **options,
    )


FILTERS = [
    "EkfDynamic",
    "EkfKinematic",
    "NavConstantAcceleration",
    "NavDynamic",
    "NavInertial",
    "NavModelAided",
]


def sail(seconds, heading, speed, fix):
    """Sensor readings of a vehicle on a straight course at constant speed, 20 m deep. A fix each second, if at all.

    A little noise everywhere: a value that repeats bit for bit would indicate a stuck instrument.
    """
    times = np.arange(0.0, seconds + 0.05, 0.1)
    noise = iter(np.random.default_rng(1).normal(0.0, 1e-3, (20, len(times))))
    all_of = lambda value: np.full(len(times), float(value))
    columns = {
        "imu.specific_force.z": next(noise) - 9.81,
        "imu.rate.r": 1e-2 * next(noise),
        "ahrs.attitude.yaw": heading + next(noise),
        "dvl.velocity.u": speed + next(noise),
        "pressure.depth": 19.15 + next(noise),
        # The thrust that holds 0.3 m/s, for the filters with a model.
        **{f"thruster[{i}].thrust": all_of(31.7 if i < 6 else -31.7) for i in range(4, 8)},
    }
    sensors = ["imu", "ahrs", "dvl", "pressure", "propulsion"]
    if fix:
        sensors.append("fix")
        columns["fix.position.x"] = speed * np.cos(heading) * times + next(noise)
        columns["fix.position.y"] = speed * np.sin(heading) * times + next(noise)
    for sensor in sensors:
        columns[f"{sensor}.valid"] = all_of(1.0)
        columns[f"{sensor}.stamp"] = np.floor(times + 1e-9) if sensor == "fix" else times
    signal = np.zeros(len(times), dtype=[("time", float), *((name, float) for name in columns)])
    signal["time"] = times
    for name, values in columns.items():
        signal[name] = values
    return signal


@pytest.mark.parametrize("name", FILTERS)
def test_filter_moves_with_the_measured_velocity(fmu, name):
    """No fix: dead reckoning along the heading, with growing uncertainty."""
    heading = np.pi / 2
    result = run(fmu, name, {"initial.pose.yaw": heading}, 60.0, input=sail(60.0, heading, 0.3, fix=False))
    assert result["pose.y"][-1] == pytest.approx(18.0, abs=0.3)
    assert result["pose.x"][-1] == pytest.approx(0.0, abs=0.3)
    assert result["sigma.x"][-1] > result["sigma.x"][100]
    assert result["count.dvl.used"][-1] > 500
    assert result["count.fix.used"][-1] == 0
    assert np.isfinite(result.view((float, len(result.dtype)))).all()


@pytest.mark.parametrize("name", FILTERS)
def test_fixes_narrow_the_estimate(fmu, name):
    start = {"initial.sigma.x": 5.0, "initial.pose.x": 2.0}
    if name.startswith("Ekf"):
        start["transition"] = REPAIRED
    result = run(fmu, name, start, 60.0, input=sail(60.0, 0.0, 0.3, fix=True))
    assert 0.0 < result["sigma.x"][-1] < 0.5
    assert result["pose.x"][-1] == pytest.approx(18.0, abs=0.3)
    assert result["health"][-1] == 0


@pytest.mark.parametrize("name", FILTERS)
def test_a_filter_with_nothing_connected_says_that_it_knows_nothing(fmu, name):
    result = run(fmu, name, {}, 20.0)
    assert result["health"][-1] == 1
    assert result["pose.x"][-1] == pytest.approx(0.0, abs=1e-9)
    for channel in ("tilt", "heading", "depth", "dvl", "fix"):
        assert result[f"count.{channel}.used"][-1] == 0


def test_guidance_steers_back_to_the_course(fmu):
    ahead = run(fmu, "PurePursuit", {"pose.z": 20.0}, stop_time=1.0)
    assert ahead["command.u"][-1] == pytest.approx(0.3)
    assert ahead["command.r"][-1] == pytest.approx(0.0, abs=1e-12)
    starboard = run(fmu, "PurePursuit", {"pose.y": 0.5, "pose.z": 20.0}, stop_time=1.0)
    assert starboard["cross_track"][-1] == pytest.approx(0.5)
    assert starboard["command.r"][-1] < -0.1


def test_guidance_follows_a_file_of_waypoints(fmu, tmp_path):
    course = tmp_path / "east.csv"
    course.write_text("x,y,radius\n0,0,0\n0,30,0\n")
    result = run(fmu, "PurePursuit", {"course": str(course), "pose.y": 10.0}, stop_time=3.0)
    assert result["target.x"][-1] == pytest.approx(0.0)
    assert result["target.y"][-1] > 1.0


@pytest.mark.parametrize(
    "text, reason",
    [("0,0\n", "two"), ("0,0\n1,abc\n", "line 2"), (None, "BE1")],
    ids=["one point", "not a number", "no such file"],
)
def test_a_bad_course_is_refused_with_the_reason(fmu, tmp_path, text, reason):
    course = tmp_path / "course.csv"
    if text is not None:
        course.write_text(text)
    messages = []

    def logger(environment, instance, status, category, message):
        messages.append(message.decode())

    with pytest.raises(Exception):
        run(fmu, "PurePursuit", {"course": str(course)}, logger=logger)
    assert any("course" in m and reason in m for m in messages), messages


def test_controller_allocates_a_surge_demand(fmu):
    result = run(fmu, "VelocityController", {"command.u": 0.3}, stop_time=1.0)
    force = [result[f"thruster[{i}].force"][0] for i in range(8)]
    assert result["wrench.X"][0] == pytest.approx(10 * 0.3 * 1862.87, rel=0.05)
    assert min(force[4], force[5]) > 0 > max(force[6], force[7])
