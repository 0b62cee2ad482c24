"""Results as ROS messages and as trajectories, read by the usual tools."""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import COSIM, ROOT
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader

AXES = ["x", "y", "z", "roll", "pitch", "yaw"]


def cosim(folder, *arguments, code=0):
    done = subprocess.run([COSIM, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stderr


def columns(file):
    with file.open(newline="") as source:
        rows = list(csv.DictReader(source))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def messages(file, topic):
    """Log times in seconds, and messages."""
    found = [(m.log_time_ns / 1e9, m.ros_msg) for m in read_ros2_messages(str(file), topics=[topic])]
    assert found, f"nothing on {topic}"
    return [time for time, _ in found], [message for _, message in found]


def seconds(stamp):
    return stamp.sec + stamp.nanosec / 1e9


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The whole loop for a while, as CSV and as MCAP of the same values."""
    folder = tmp_path_factory.mktemp("ros")
    arguments = ["run", ROOT / "examples" / "baseline.ssd", "--stop-time", "20", "--output-interval", "0.05"]
    cosim(folder, *arguments, "-q", "-o", "run.mcap")
    cosim(folder, "convert", "-q", "run.mcap", "run.csv")
    return folder


def test_odometry_has_pose_and_covariance_in_the_axes_of_ros(run):
    recorded = columns(run / "run.csv")
    for topic, owner, frame in [("/vehicle/odometry", "vehicle", "base_link"), ("/filter/odometry", "filter", None)]:
        times, found = messages(run / "run.mcap", topic)
        value = {axis: recorded[f"{owner}.pose.{axis}"] for axis in AXES}
        assert times == pytest.approx(recorded["time"])
        assert {m.header.frame_id for m in found} == {"map"}
        assert frame is None or {m.child_frame_id for m in found} == {frame}
        position = np.array([[getattr(m.pose.pose.position, axis) for axis in "xyz"] for m in found])
        assert np.array_equal(position, np.column_stack([value["y"], value["x"], -value["z"]]))
        for message, roll, pitch, yaw in zip(found, value["roll"], value["pitch"], value["yaw"]):
            q = message.pose.pose.orientation
            # The body's forward axis in east, north, up.
            forward = [1 - 2 * (q.y**2 + q.z**2), 2 * (q.x * q.y + q.z * q.w), 2 * (q.x * q.z - q.y * q.w)]
            wanted = [math.cos(pitch) * math.sin(yaw), math.cos(pitch) * math.cos(yaw), math.sin(pitch)]
            assert forward == pytest.approx(wanted, abs=1e-12)
            # And its port side, which shows the roll.
            port_up = 2 * (q.y * q.z + q.x * q.w)
            assert port_up == pytest.approx(math.cos(pitch) * math.sin(roll), abs=1e-12)
        speed = np.array([[getattr(m.twist.twist.linear, axis) for axis in "xyz"] for m in found])
        wanted = np.column_stack([recorded[f"{owner}.velocity.{axis}"] for axis in "uvw"]) * [1, -1, -1]
        assert np.array_equal(speed, wanted)
    covariance = np.array([m.pose.covariance for m in found]).reshape(-1, 6, 6)
    assert np.array_equal(covariance, covariance.transpose(0, 2, 1))
    assert covariance[:, 0, 0] == pytest.approx(recorded["filter.sigma.y"] ** 2)
    assert covariance[:, 5, 5] == pytest.approx(recorded["filter.sigma.yaw"] ** 2)
    assert covariance[:, 0, 1] == pytest.approx(recorded["filter.covariance.x_y"])
    # In ROS only yaw changes its sign, and so does its covariance with north.
    assert covariance[:, 1, 5] == pytest.approx(-recorded["filter.covariance.x_yaw"])
    assert np.all(np.linalg.eigvalsh(covariance[-1]) > 0)


def test_sensors_send_each_sample_once_at_its_own_time(run):
    recorded = columns(run / "run.csv")
    for topic, owner in [("/imu/data", "imu"), ("/dvl/twist", "dvl"), ("/fix/pose", "fix"), ("/pressure/fluid_pressure", "pressure")]:
        stamps = [seconds(m.header.stamp) for m in messages(run / "run.mcap", topic)[1]]
        valid = recorded[f"{owner}.valid"] != 0
        assert stamps == pytest.approx(np.unique(recorded[f"{owner}.stamp"][valid]), abs=2e-9)
    _, inertial = messages(run / "run.mcap", "/imu/data")
    up = np.mean([m.linear_acceleration.z for m in inertial])
    assert up == pytest.approx(9.8, abs=0.3), "gravity is felt upwards"
    times, logged = messages(run / "run.mcap", "/dvl/twist")
    at = np.searchsorted(recorded["time"], np.array(times) - 1e-9)
    lateral = [m.twist.twist.linear.y for m in logged]
    assert lateral == pytest.approx(-recorded["dvl.velocity.v"][at])
    _, fixes = messages(run / "run.mcap", "/fix/pose")
    assert {m.header.frame_id for m in fixes} == {"map"}
    assert fixes[-1].pose.covariance[0] == pytest.approx(recorded["fix.position.sigma"][-1] ** 2)
    _, pressures = messages(run / "run.mcap", "/pressure/fluid_pressure")
    assert pressures[-1].fluid_pressure == pytest.approx(recorded["pressure.pressure"][-1])


def test_transforms_lead_from_the_world_to_each_body(run):
    _, found = messages(run / "run.mcap", "/tf")
    frames = {t.child_frame_id: t for t in found[-1].transforms}
    assert {"base_link", "filter/base_link"} <= set(frames)
    _, odometry = messages(run / "run.mcap", "/filter/odometry")
    position = odometry[-1].pose.pose.position
    moved = frames["filter/base_link"].transform.translation
    assert (moved.x, moved.y, moved.z) == (position.x, position.y, position.z)


def test_rosbags_reads_every_message(run):
    with AnyReader([run / "run.mcap"]) as reader:
        kinds = {connection.msgtype for connection in reader.connections}
        count = 0
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            count += 1
            if connection.topic == "/vehicle/odometry":
                last = message
    assert {
        "nav_msgs/msg/Odometry",
        "sensor_msgs/msg/Imu",
        "sensor_msgs/msg/FluidPressure",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "geometry_msgs/msg/TwistWithCovarianceStamped",
        "tf2_msgs/msg/TFMessage",
    } <= kinds
    with (run / "run.mcap").open("rb") as source:
        assert count == make_reader(source).get_summary().statistics.message_count
    assert last.pose.pose.position.x == columns(run / "run.csv")["vehicle.pose.y"][-1]


def test_units_are_in_the_metadata(run):
    with (run / "run.mcap").open("rb") as source:
        channels = make_reader(source).get_summary().channels.values()
    units = {}
    for channel in channels:
        units |= json.loads(channel.metadata.get("cosim.units", "{}"))
    assert (units["vehicle.pose.x"], units["vehicle.pose.yaw"], units["pressure.pressure"]) == ("m", "rad", "Pa")
    cosim(run, "convert", "-q", "run.mcap", "run.parquet")
    cosim(run, "convert", "-q", "run.parquet", "again.mcap")
    with (run / "again.mcap").open("rb") as source:
        again = {}
        for channel in make_reader(source).get_summary().channels.values():
            again |= json.loads(channel.metadata.get("cosim.units", "{}"))
    assert again == units


def evo(folder, tool, *arguments):
    """The statistics that an evo tool prints."""
    program = Path(sys.executable).with_name(tool)
    done = subprocess.run([program, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    pairs = [line.split() for line in done.stdout.splitlines()]
    return {pair[0]: float(pair[1]) for pair in pairs if len(pair) == 2 and pair[0] in ("rmse", "max", "mean")}


def test_evo_finds_the_errors_that_the_results_have(run):
    recorded = columns(run / "run.csv")
    reported = cosim(run, "convert", "run.csv", "path.tum") + cosim(run, "convert", "run.csv", "path.kitti")
    for name in ["path_vehicle.tum", "path_filter.tum", "path_vehicle.kitti", "path_filter.kitti"]:
        assert name in reported and (run / name).exists()
    apart = np.sqrt(sum((recorded[f"filter.pose.{a}"] - recorded[f"vehicle.pose.{a}"]) ** 2 for a in "xyz"))
    for kind in ["tum", "kitti"]:
        found = evo(run, "evo_ape", kind, f"path_vehicle.{kind}", f"path_filter.{kind}")
        assert found["rmse"] == pytest.approx(math.sqrt(np.mean(apart**2)), abs=2e-6)
        assert found["max"] == pytest.approx(apart.max(), abs=2e-6)
    # The rotation between the headings, whatever the axes are.
    found = evo(run, "evo_ape", "tum", "path_vehicle.tum", "path_filter.tum", "-r", "angle_deg")
    angles = {owner: [recorded[f"{owner}.pose.{axis}"] for axis in AXES[3:]] for owner in ["vehicle", "filter"]}
    turned = [np.degrees(turn(*pair)) for pair in zip(np.array(angles["vehicle"]).T, np.array(angles["filter"]).T)]
    assert found["rmse"] == pytest.approx(math.sqrt(np.mean(np.square(turned))), abs=2e-6)
    moved = evo(run, "evo_rpe", "tum", "path_vehicle.tum", "path_filter.tum", "-d", "1", "-u", "f")
    again = evo(run, "evo_rpe", "kitti", "path_vehicle.kitti", "path_filter.kitti", "-d", "1", "-u", "f")
    assert moved["rmse"] == pytest.approx(again["rmse"], abs=2e-6)


def matrix(angles):
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def turn(one, other):
    """The angle between two attitudes."""
    between = matrix(one).T @ matrix(other)
    skew = between - between.T
    return math.atan2(math.hypot(skew[2, 1], skew[0, 2], skew[1, 0]), np.trace(between) - 1)


OTHERS = """
axes = "enu"

[truth]
pose = { x = "sim.E", y = "sim.N", yaw = "sim.psi_deg" }

[estimates.observer]
pose = { x = "obs.e", y = "obs.n" }
sigma = { x = "obs.se", y = "obs.sn" }

[sensors.log]
velocity = "log"
stamp = "log_stamp"
"""


def test_a_file_names_the_variables_of_other_systems(tmp_path):
    """Other names, other axes, degrees."""
    names = ["time", "sim.E", "sim.N", "sim.psi_deg", "obs.e", "obs.n", "obs.se", "obs.sn", "log.u", "log.v", "log.w", "log_stamp"]
    rows = [[0, 1, 2, 90, 1.5, 2.5, 0.1, 0.2, 1, 0, 0, 0], [1, 2, 2, 180, 2.5, 2.5, 0.1, 0.2, 1.5, 0.5, 0, 0.9], [2, 3, 2, 180, 3, 2.5, 0.1, 0.2, 1.5, 0.5, 0, 0.9]]
    with (tmp_path / "sim.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    (tmp_path / "roles.toml").write_text(OTHERS)
    cosim(tmp_path, "convert", "sim.csv", "sim.mcap", "--roles", "roles.toml")
    _, truth = messages(tmp_path / "sim.mcap", "/truth/odometry")
    assert [truth[1].pose.pose.position.x, truth[1].pose.pose.position.y] == [2, 2]
    assert [truth[0].pose.pose.orientation.z, truth[0].pose.pose.orientation.w] == pytest.approx([math.sqrt(0.5)] * 2)
    _, observer = messages(tmp_path / "sim.mcap", "/observer/odometry")
    assert observer[0].pose.covariance[0] == pytest.approx(0.01) and observer[0].pose.covariance[7] == pytest.approx(0.04)
    times, log = messages(tmp_path / "sim.mcap", "/log/twist")
    assert times == [0, 1] and log[1].twist.twist.linear.y == 0.5, "a held sample is not sent again"

    (tmp_path / "roles.toml").write_text(OTHERS.replace("obs.sn", "obs.ssn").replace("[sensors.log]", "[sensors.log]\nspeed = 1"))
    reported = cosim(tmp_path, "convert", "sim.csv", "sim.mcap", "--roles", "roles.toml", code=3)
    assert "roles.toml:" in reported and "'speed' is unknown" in reported
    (tmp_path / "roles.toml").write_text(OTHERS.replace("obs.sn", "obs.ssn"))
    reported = cosim(tmp_path, "convert", "sim.csv", "sim.mcap", "--roles", "roles.toml", code=3)
    assert "'obs.ssn' is not recorded" in reported and "did you mean 'obs.sn'?" in reported


def test_a_layout_names_topics_that_are_there(run):
    cosim(run, "convert", "-q", "run.mcap", "layout.json")
    layout = json.loads((run / "layout.json").read_text())
    with (run / "run.mcap").open("rb") as source:
        topics = {channel.topic for channel in make_reader(source).get_summary().channels.values()}
    shown = set(layout["configById"]["3D!bodies"]["topics"])
    assert {"/vehicle/odometry", "/filter/odometry"} <= shown <= topics
    plots = [panel for name, panel in layout["configById"].items() if name.startswith("Plot!")]
    assert all(path["value"].split(".")[0] in topics for plot in plots for path in plot["paths"])


def test_results_without_a_path_have_no_trajectory(tmp_path):
    (tmp_path / "a.csv").write_text("time,level\n0,1\n1,2\n")
    reported = cosim(tmp_path, "convert", "a.csv", "a.tum", code=3)
    assert "no path is recorded" in reported and "--roles" in reported
    reported = cosim(tmp_path, "convert", "a.csv", "a.bag", code=2)
    assert ".tum" in reported
