"""MCAP results in the reader of the format's authors: the same numbers as in the CSV file, under names ROS allows."""

import cosim
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages


def test_every_number_is_that_of_the_csv(fmu, tmp_path):
    files = [tmp_path / "vehicle.csv", tmp_path / "vehicle.mcap"]
    for file in files:
        cosim.run("simulate", fmu("RexROV"), "--stop-time", "1", "-q", "-o", file)
    columns = cosim.read(files[0])
    with files[1].open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
    names = {}
    for channel in channels:
        # Standard ROS messages are made from the same columns.
        if "cosim.derived" in channel.metadata:
            continue
        lines = channel.metadata["cosim.columns"].splitlines()
        names[channel.topic] = [line.split(" ", 2)[2] for line in lines]
    assert "pose.x" in names["/pose"]
    samples = 0
    for message in read_ros2_messages(str(files[1]), topics=list(names)):
        row = list(columns["time"]).index(message.log_time_ns / 1e9)
        values = [getattr(message.ros_msg, slot) for slot in message.ros_msg.__slots__]
        expected = [columns[name][row] for name in names[message.channel.topic]]
        assert values == expected
        samples += 1
    assert samples == len(names) * len(columns["time"])
