"""What is written as a bag is read back: by readers of others and by our own."""

from __future__ import annotations

import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import yaml
from bag_messages import (
    GAIT,
    JOINTS,
    START,
    TICK_NS,
    TOPICS,
    arrivals,
    joint_positions,
    joint_state,
    named_values,
    odometry,
    wrench,
    write_bag,
)
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from follower_humanoid.bag.definitions import definition
from follower_humanoid.bag.mcap_writer import McapWriter
from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.recorder import Arrival
from follower_humanoid.bag.writer import About, BagWriter
from follower_humanoid.errors import ConfigurationError

COUNT = 500
EVERY_TICK = ("joint_states", "odom", "imu", "left_foot/wrench")
THINNED = ("gait", "primitives", "support_polygon", "com")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("bags") / "run", COUNT)


def test_rosbags_reads_the_folder(bag: Path) -> None:
    with AnyReader([bag]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        assert all(counts[f"/{name}"] == COUNT for name in EVERY_TICK)
        assert all(counts[f"/{name}"] == COUNT // 5 for name in THINNED)
        connections = [c for c in reader.connections if c.topic == "/joint_states"]
        for tick, (_, received, data) in enumerate(reader.messages(connections)):
            message = reader.deserialize(data, "sensor_msgs/msg/JointState")
            assert received == START + tick * TICK_NS
            np.testing.assert_array_equal(message.position, joint_positions(tick))


def test_mcap_ros2_decodes_every_message(bag: Path) -> None:
    with (bag / "run_0.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        decoded = list(reader.iter_decoded_messages())
        statistics = reader.get_summary().statistics
    assert len(decoded) == statistics.message_count == len(EVERY_TICK) * COUNT + len(THINNED) * COUNT // 5
    gait = next(message for _, channel, _, message in decoded if channel.topic == "/gait")
    assert dict(zip(gait.name, gait.position, strict=True)) == GAIT


def test_channels_carry_qos_and_type_hash(bag: Path) -> None:
    with (bag / "run_0.mcap").open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
    for channel in channels:
        assert channel.message_encoding == "cdr"
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        assert yaml.safe_load(channel.metadata["offered_qos_profiles"])[0]["reliability"] == "reliable"


def test_metadata_is_that_of_jazzy(bag: Path) -> None:
    text = (bag / "metadata.yaml").read_text()
    assert "&" not in text and "*" not in text, "rosbag2 reads no YAML anchors"
    information = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["ros_distro"] == "jazzy"
    assert information["relative_file_paths"] == ["run_0.mcap"]
    assert information["starting_time"] == {"nanoseconds_since_epoch": START}
    counts = {
        t["topic_metadata"]["name"]: t["message_count"] for t in information["topics_with_message_count"]
    }
    assert sum(counts.values()) == information["message_count"] == information["files"][0]["message_count"]


def test_definitions_hold_each_dependency_once() -> None:
    text = definition("visualization_msgs/msg/MarkerArray").text
    packages = [line for line in text.splitlines() if line.startswith("MSG: ")]
    assert len(packages) == len(set(packages)) == 12
    assert text.count("=" * 80) == 12


def test_our_reader_gives_what_was_published(bag: Path) -> None:
    run = read_run(bag)
    assert run.tick == 0.002
    assert run.joint_names == JOINTS
    assert run.urdf == "<robot/>"
    assert run.about == {"parameters": "a: 1\n", "programme": "fig4", "tick": "0.002", "seed": "7"}
    assert run.notes == ()
    states = run["joint_states"]
    np.testing.assert_array_equal(states.ticks, np.arange(COUNT))
    for tick in (0, 1, COUNT - 1):
        np.testing.assert_array_equal(states.position[tick], joint_positions(tick))
    np.testing.assert_allclose(run["odom"].position[:, 0], 0.001 * np.arange(COUNT))
    np.testing.assert_array_equal(run["odom"].angular_velocity[:, 2], -0.5)
    np.testing.assert_array_equal(run["imu"].linear_acceleration, [[0.0, 0.0, 9.81]] * COUNT)
    np.testing.assert_array_equal(run["left_foot/wrench"].force[:, 2], 358.0)
    np.testing.assert_array_equal(run["left_foot/wrench"].torque[:, 1], 0.25 * np.arange(COUNT))
    assert set(run["left_foot/wrench"].texts["frame"]) == {"l_sole"}


def test_our_reader_gives_thinned_topics_at_their_ticks(bag: Path) -> None:
    run = read_run(bag)
    for name in THINNED:
        np.testing.assert_array_equal(run[name].ticks, np.arange(0, COUNT, 5))
    for name, value in GAIT.items():
        np.testing.assert_array_equal(run["gait"].fields[name], value)
    assert [len(p.vertices) for p in run["support_polygon"].samples[:4]] == [4, 6, 5, 4]
    np.testing.assert_array_equal(run["support_polygon"].samples[0].vertices[2], [1.0, -0.5, 0.0])
    assert run["primitives"].samples[3].names == ("lean", "bend")
    assert run["primitives"].samples[3].completion == (0.5, 0.25)


def test_a_namespace_is_found_or_asked_for(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "named", 20, "/first/")
    assert len(read_run(bag)["joint_states"]) == 20
    assert len(read_run(bag, "first")["joint_states"]) == 20
    with pytest.raises(ConfigurationError, match="holds no joint_states"):
        read_run(bag, "second")


def test_two_robots_need_a_choice(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "two", About(), START) as writer:
        for namespace in ("/a/", "/b/"):
            for name, data in (("joint_states", joint_state(0)), ("odom", odometry(0))):
                channel = writer.add_topic(namespace + name, TOPICS[name].type_name, [])
                writer.write(channel, data, START, START)
    with pytest.raises(ConfigurationError, match="choose a namespace: a, b"):
        read_run(tmp_path / "two")


def test_joints_in_another_order_are_put_right(tmp_path: Path) -> None:
    made = [a for a in arrivals(4) if a.topic.name != "joint_states"]
    backwards = JOINTS[::-1]
    for tick in range(4):
        names = JOINTS if tick < 2 else backwards
        made.append(Arrival(TOPICS["joint_states"], joint_state(tick, names), START + tick * TICK_NS, START))
    position = read_run(write_bag(tmp_path / "order", made=made))["joint_states"].position
    np.testing.assert_array_equal(position[1], joint_positions(1))
    np.testing.assert_array_equal(position[2], joint_positions(2)[::-1])


def test_a_person_without_a_clock_pulls_when_the_message_came(tmp_path: Path) -> None:
    push = Arrival(TOPICS["base/push"], wrench(0, 5.0, ""), START + 1500 * TICK_NS, START)
    run = read_run(write_bag(tmp_path / "person", made=[*arrivals(2000), push]))
    assert run["base/push"].ticks.tolist() == [1500]


def test_lost_ticks_are_told(tmp_path: Path) -> None:
    made = [a for a in arrivals(30) if not START + 9 * TICK_NS < a.received < START + 12 * TICK_NS]
    notes = read_run(write_bag(tmp_path / "gap", made=made)).notes
    assert notes == ("joint_states: 2 of 30 ticks are missing",)


def test_gait_without_heading_heads_where_it_walks(tmp_path: Path) -> None:
    values = {name: value for name, value in GAIT.items() if name != "heading"}
    made = [a for a in arrivals(3) if a.topic.name != "gait"]
    made.append(Arrival(TOPICS["gait"], named_values(0, values), START, START))
    assert read_run(write_bag(tmp_path / "gait", made=made))["gait"].heading.tolist() == [0.2]


def test_of_a_written_chunk_only_its_entry_in_the_index_is_kept_in_memory() -> None:
    channels, chunks = 40, 200
    with open(os.devnull, "wb") as stream:
        writer = McapWriter(stream, "ros2", "test")
        schema = writer.add_schema("s", "")
        numbers = [writer.add_channel(f"/{number}", schema, {}) for number in range(channels)]

        def write(first: int) -> None:
            for chunk in range(first, first + chunks):
                for number in numbers:
                    writer.add_message(number, 1000 * chunk, 1000 * chunk, b"")
                writer.flush()

        write(0)
        tracemalloc.start()
        try:
            write(chunks)
            kept, _ = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    entry = 10 * channels + 100  # where each channel's messages are, and the rest of the record
    assert kept < 2.0 * entry * chunks


def test_nothing_is_overwritten(bag: Path) -> None:
    before = (bag / "run_0.mcap").read_bytes()
    with pytest.raises(ConfigurationError, match="exists already"):
        BagWriter(bag, About(), START)
    assert (bag / "run_0.mcap").read_bytes() == before


def test_equal_runs_have_equal_hashes(bag: Path, tmp_path: Path) -> None:
    again = write_bag(tmp_path / "again", COUNT)
    assert read_run(again).joint_hash() == read_run(bag).joint_hash()
