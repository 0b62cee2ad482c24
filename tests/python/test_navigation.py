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


@pytest.mark.parametrize("name", ["EkfDynamic", "EkfKinematic"])
def test_filter_moves_with_the_measured_velocity(fmu, name):
    """No fix: dead reckoning along the heading."""
    heading = np.pi / 2
    start = {
        "dvl.velocity.u": 0.3,
        "imu.attitude.yaw": heading,
        "initial.pose.yaw": heading,
        "imu.specific_force.z": -9.81,
        "fix.valid": 0.0,
        "pressure.valid": 0.0,
        # The thrust that holds 0.3 m/s and the buoyancy down, for the dynamic filter.
        "thruster[4].thrust": 31.7, "thruster[5].thrust": 31.7,
        "thruster[6].thrust": -31.7, "thruster[7].thrust": -31.7,
    }
    result = run(fmu, name, start, stop_time=20.0)
    assert result["pose.y"][-1] == pytest.approx(6.0, abs=0.1)
    assert result["pose.x"][-1] == pytest.approx(0.0, abs=0.1)
    assert np.isfinite(result.view((float, len(result.dtype)))).all()


@pytest.mark.parametrize("name", ["EkfDynamic", "EkfKinematic"])
def test_fixes_narrow_the_estimate(fmu, name):
    start = {"initial.sigma.x": 5.0, "fix.position.x": 2.0, "transition": REPAIRED}
    result = run(fmu, name, start)
    assert result["sigma.x"][0] > 3.0 * result["sigma.x"][-1]
    assert result["pose.x"][-1] == pytest.approx(2.0, abs=0.1)


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
