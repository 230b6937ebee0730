"""The recorder as a process: what is published lands in the bag, however it ends."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from bag_messages import TICK_NS, imu, joint_positions, joint_state, odometry, point, wrench
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped, WrenchStamped
from graph_bench import PATIENCE, wait_until
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import UInt8MultiArray

from follower_humanoid.bag.reader import read_run
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros.envelope import Envelope, envelope_topic
from follower_humanoid.ros.qos import PEOPLE

MESSAGES: dict[str, tuple[type, Any]] = {
    "joint_states": (JointState, joint_state),
    "odom": (Odometry, odometry),
    "imu": (Imu, imu),
    "left_foot/wrench": (WrenchStamped, lambda tick: wrench(tick, 300.0)),
    "com": (PointStamped, point),
}
# Deep enough for a machine so busy that a reader sleeps for a second: what is measured is the recorder.
DEEP = QoSProfile(depth=2000)


def wait_until_heard(*publishers: Any) -> None:
    """Until the recorder hears them all."""
    assert wait_until(lambda: all(p.get_subscription_count() for p in publishers)), "it was not found"


class Graph:
    """Publishes what a simulator would."""

    def __init__(self, namespace: str = "") -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = Node("simulator", context=self.context, namespace=namespace)
        self.publishers = {
            name: self.node.create_publisher(kind, name, DEEP) for name, (kind, _) in MESSAGES.items()
        }
        self.written = 0
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, 10)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.person = self.node.create_publisher(WrenchStamped, "base/push", PEOPLE)

    def wait_for_recorder(self) -> None:
        wait_until_heard(*self.publishers.values(), self.person)

    def publish(self, ticks: range, pause: float = 0.002) -> None:
        for tick in ticks:
            for name, (_, make) in MESSAGES.items():
                self.publishers[name].publish(make(tick))
            time.sleep(pause)

    def wait_until_written(self, count: int) -> None:
        """Until the recorder says that it has written so many messages."""
        deadline = time.monotonic() + PATIENCE
        while self.written < count:
            assert time.monotonic() < deadline, f"{self.written} of {count} messages were written"
            self.executor.spin_once(timeout_sec=0.1)

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.endswith("/recorder"):
                values = {entry.key: entry.value for entry in status.values}
                self.written = int(values.get("messages", 0))

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def graph() -> Iterator[Graph]:
    made = Graph()
    yield made
    made.close()


def start_recorder(bag: Path, *options: str) -> subprocess.Popen[str]:
    command = [
        sys.executable,
        "-m",
        "follower_humanoid.nodes.recorder",
        "--ros-args",
        "-p",
        f"bag:={bag}",
        *options,
    ]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def end(process: subprocess.Popen[str], number: signal.Signals) -> int:
    process.send_signal(number)
    try:
        return process.wait(PATIENCE)
    finally:
        process.kill()


def test_everything_published_is_in_the_bag(graph: Graph, tmp_path: Path) -> None:
    about = tmp_path / "about.yaml"
    about.write_text("programme: fig4\nparameters: {simulator: {seed: 3}}\n")
    recorder = start_recorder(tmp_path / "run", "-p", f"about:={about}")
    graph.wait_for_recorder()
    graph.publish(range(300))
    graph.wait_until_written(4 * 300 + 60)
    graph.person.publish(wrench(0, 5.0, "torso"))
    graph.wait_until_written(4 * 300 + 60 + 1)
    assert end(recorder, signal.SIGTERM) == 0
    run = read_run(tmp_path / "run")
    assert run.notes == ()
    for name in ("joint_states", "odom", "imu", "left_foot/wrench"):
        assert run[name].ticks.tolist() == list(range(300)), name
    assert run["com"].ticks.tolist() == list(range(0, 300, 5))
    np.testing.assert_array_equal(run["joint_states"].position[123], joint_positions(123))
    assert run["base/push"].texts["frame"] == ("torso",)
    assert run.about["programme"] == "fig4"
    assert "seed: 3" in run.about["parameters"]
    assert "numpy" in run.about["versions.yaml"]
    assert "<robot" in run.urdf
    with AnyReader([tmp_path / "run"]) as reader:
        qos = {c.topic: c.ext.offered_qos_profiles[0].reliability.name for c in reader.connections}
    assert qos["/odom"] == "RELIABLE"
    assert qos["/base/push"] == "BEST_EFFORT"


def test_a_namespace_is_kept(tmp_path: Path) -> None:
    graph = Graph("first")
    try:
        recorder = start_recorder(tmp_path / "named", "-r", "__ns:=/first")
        graph.wait_for_recorder()
        graph.publish(range(20))
        graph.wait_until_written(4 * 20 + 4)
        assert end(recorder, signal.SIGINT) == 0
    finally:
        graph.close()
    assert len(read_run(tmp_path / "named", "first")["odom"]) == 20


def test_the_bag_is_closed_when_the_simulator_dies(tmp_path: Path) -> None:
    graph = Graph()
    recorder = start_recorder(tmp_path / "lost")
    graph.wait_for_recorder()
    graph.publish(range(50))
    graph.wait_until_written(4 * 50 + 10)
    graph.close()
    assert recorder.wait(PATIENCE) == 0
    assert len(read_run(tmp_path / "lost")["joint_states"]) == 50
    assert (tmp_path / "lost" / "metadata.yaml").is_file()


def test_a_killed_recorder_leaves_a_readable_file(graph: Graph, tmp_path: Path) -> None:
    recorder = start_recorder(tmp_path / "killed")
    graph.wait_for_recorder()
    graph.publish(range(1000))
    graph.wait_until_written(4 * 1000)
    recorder.kill()
    recorder.wait()
    run = read_run(tmp_path / "killed")
    assert len(run["joint_states"]) > 200
    assert any("cut off" in note for note in run.notes)


def test_a_taken_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    recorder = start_recorder(tmp_path / "taken")
    _, errors = recorder.communicate(timeout=PATIENCE)
    assert recorder.returncode == 2
    assert "exists already" in errors
    assert "Traceback" not in errors
    assert list((tmp_path / "taken").iterdir()) == []


def test_a_full_disk_ends_the_recording_and_says_so(graph: Graph, tmp_path: Path) -> None:
    recorder = start_recorder(tmp_path / "full")
    graph.wait_for_recorder()
    resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))
    for tick in range(10_000):
        graph.publish(range(tick, tick + 1))
        if recorder.poll() is not None:
            break
    _, errors = recorder.communicate(timeout=PATIENCE)
    assert recorder.returncode == 1
    assert "File too large" in errors
    assert "Traceback" not in errors
    run = read_run(tmp_path / "full")
    assert len(run["joint_states"]) > 200
    assert any("cut off" in note for note in run.notes)


def test_what_comes_in_envelopes_is_in_the_bag_once_and_strangers_are_heard_by_name(tmp_path: Path) -> None:
    """The simulator sends envelopes, and its topics by name to others; the CoM comes from a stranger."""
    graph = Graph()
    envelope = Envelope(NODES["simulator"])
    sealed = graph.node.create_publisher(UInt8MultiArray, envelope_topic("simulator"), DEEP)
    made = {name: MESSAGES[name][1] for name in MESSAGES if name in envelope.topics}
    try:
        recorder = start_recorder(tmp_path / "run")
        wait_until_heard(sealed, graph.publishers["com"])
        for tick in range(200):
            parts = [made[topic](tick) if topic in made else b"" for topic in envelope.topics]
            sealed.publish(envelope.seal(tick * TICK_NS, parts))
            for name, (_, make) in MESSAGES.items():
                graph.publishers[name].publish(make(tick))
            time.sleep(0.002)
        sealed.publish(b"\0\1\0\0 no envelope")
        for stamp in (-TICK_NS, 2**62):  # of no time that a clock could tell
            sealed.publish(envelope.seal(stamp, [b""] * len(envelope.topics)))
        graph.wait_until_written(4 * 200 + 40 + 40)
        assert end(recorder, signal.SIGTERM) == 0
    finally:
        graph.close()
    run = read_run(tmp_path / "run")
    for name in ("joint_states", "odom", "imu", "left_foot/wrench"):
        assert run[name].ticks.tolist() == list(range(200)), name
    np.testing.assert_array_equal(run["joint_states"].position[123], joint_positions(123))
    with AnyReader([tmp_path / "run"]) as reader:
        count = {connection.topic: connection.msgcount for connection in reader.connections}
    assert count["/joint_states"] == count["/odom"] == count["/left_foot/wrench"] == 200
    assert count["/com"] == count["/clock"] == 40


def test_the_leaders_wrenches_are_in_the_bag_once_and_peoples_as_often_as_they_come(tmp_path: Path) -> None:
    """By name half of the leader's messages are lost, as may happen to those sent best effort."""
    graph = Graph()
    topic, count = "leader/left_hand/wrench", 60
    envelope = Envelope(NODES["leader"])
    sealed = graph.node.create_publisher(UInt8MultiArray, envelope_topic("leader"), DEEP)
    named = graph.node.create_publisher(WrenchStamped, topic, DEEP)
    # Each is serialised once: the gaps between the fields hold whatever lay in memory.
    leaders = [wrench(5 * number, 7.0, "world") for number in range(count)]
    person = wrench(0, 1.0, "world")
    try:
        recorder = start_recorder(tmp_path / "run")
        wait_until_heard(sealed, named)
        graph.publish(range(10))
        for number, data in enumerate(leaders):
            parts = [data if name == topic else b"" for name in envelope.topics]
            if number % 4 == 0:
                named.publish(data)
            sealed.publish(envelope.seal(5 * number * TICK_NS, parts))
            if number % 4 == 1:
                named.publish(data)
            named.publish(person)
            time.sleep(0.01)
        graph.wait_until_written(2 * count)
        assert end(recorder, signal.SIGTERM) == 0
    finally:
        graph.close()
    with AnyReader([tmp_path / "run"]) as reader:
        recorded = [raw for c, _, raw in reader.messages() if c.topic == f"/{topic}"]
    assert recorded.count(person) == count
    assert all(recorded.count(data) == 1 for data in leaders)
