"""The command `ros2` against a running node: every verb as a person types it, in a process of its own."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import rclpy
import yaml
from geometry_msgs.msg import WrenchStamped
from graph_bench import PATIENCE, beside, free_domain, wait_until
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import SetBool

DOMAIN = free_domain()
MAIN = [sys.executable, "-m", "follower_humanoid.ros2_front.main"]
ENVIRONMENT = {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN), "PATH": "/usr/bin:/bin"}
RATE = 50.0
TRIES = 5  # on a busy machine a command may not find the robot in the time that it looks for it


class Robot(LifecycleNode):
    """Publishes, listens, has parameters and a service."""

    def __init__(self, context: rclpy.Context) -> None:
        super().__init__("robot", context=context, namespace="lab")
        self.heard: list[WrenchStamped] = []
        self.sent = 0
        self.declare_parameter("gain", 2.5)
        self.declare_parameter("pid.p", 1)
        self.declare_parameter("names", ["a", "b"])
        self.add_on_set_parameters_callback(self._allow)
        best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        latched = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.fast = self.create_publisher(WrenchStamped, "force", best_effort)
        self.once = self.create_publisher(String, "about", latched)
        self.once.publish(String(data="a robot"))
        self.create_subscription(WrenchStamped, "pull", self.heard.append, best_effort)
        self.create_service(SetBool, "light", self._light)
        self.create_timer(1.0 / RATE, self._send)

    def _send(self) -> None:
        message = WrenchStamped()
        message.wrench.force.x = 4.0
        self.fast.publish(message)
        self.sent += 1

    def _allow(self, changed: list[rclpy.Parameter]) -> SetParametersResult:
        bad = any(p.name == "gain" and p.value < 0 for p in changed)
        return SetParametersResult(successful=not bad, reason="gain: valid: 0 to 10" if bad else "")

    def _light(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success, response.message = True, f"light {request.data}"
        return response


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = Robot(context)
    executor = EventsExecutor(context=context)
    executor.add_node(node)
    over = threading.Event()

    def spin() -> None:
        while not over.is_set():
            executor.spin_until_future_complete(Future(), timeout_sec=0.1)

    thread = threading.Thread(target=spin)
    thread.start()
    yield node
    over.set()
    thread.join()
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def ros2(*words: str, status: int = 0, shows: str = "") -> str:
    """What a command says; it is tried again where it has not found the robot."""
    for _ in range(TRIES):
        done = subprocess.run(
            [*MAIN, *words], env=ENVIRONMENT, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        said = done.stdout + done.stderr
        assert "Traceback" not in said
        if done.returncode == status and shows in said:
            return said
    raise AssertionError(f"status {done.returncode}: {said}")


@contextmanager
def running(*words: str, by: int = signal.SIGINT, shows: str = "") -> Iterator[subprocess.Popen[str]]:
    """A command that runs until a signal stops it, and then ends well."""
    process = subprocess.Popen(
        [*MAIN, *words], env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    with beside(process):
        yield process
        process.send_signal(by)
        said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said
    assert shows in said


def test_topics_are_listed_and_described(robot):
    assert "/lab/force" in ros2("topic", "list", shows="/lab/force").splitlines()
    about = "/lab/about [std_msgs/msg/String]"
    assert about in ros2("topic", "list", "-t", shows=about).splitlines()
    told = ros2("topic", "info", "/lab/pull", "-v", shows="Subscription count: 1")
    assert "Type: geometry_msgs/msg/WrenchStamped" in told
    assert "Publisher count: 0" in told
    assert "Reliability: BEST_EFFORT" in told
    assert "Unknown topic '/nothing'" in ros2("topic", "info", "/nothing", status=1)


def test_echo_hears_best_effort_and_latched_publishers(robot):
    text = ros2("topic", "echo", "/lab/force", "--once")
    assert next(yaml.safe_load_all(text))["wrench"]["force"]["x"] == 4.0
    assert ros2("topic", "echo", "/lab/force", "--once", "--field", "wrench.force.x") == "4.0\n---\n"
    assert ros2("topic", "echo", "/lab/about", "--once", "--field", "data") == "a robot\n---\n"
    words = ("topic", "echo", "/lab/about", "std_msgs/msg/String", "--qos-durability", "volatile")
    assert ros2(*words, "--timeout", "1", status=1) == ""


def test_hz_tells_the_rate(robot):
    before = robot.sent
    with running("topic", "hz", "/lab/force") as process:
        assert process.stdout is not None
        rates, counts = [], []
        while len(counts) < 3:
            line = process.stdout.readline()
            assert line, "ended early"
            if line.startswith("average rate:"):
                rates.append(float(line.split()[-1]))
            if "window:" in line:
                counts.append(int(line.split()[-1]))
        sent = robot.sent - before
    # How fast the robot is, and how soon it is heard, is the machine's affair; how much it has sent is not.
    assert min(rates) > 0.0
    assert 1 < counts[0] < counts[1] < counts[2] <= sent


def test_pub_once_waits_for_the_subscriber(robot):
    robot.heard.clear()
    what = ("/lab/pull", "geometry_msgs/msg/WrenchStamped", "{wrench: {force: {x: 5}}}")
    # It stays until the message has come: a best-effort one may be lost with its writer.
    with running("topic", "pub", "--once", "--keep-alive", "3600", *what) as process:
        assert process.stdout is not None
        assert any(line.startswith("publishing #1: geometry_msgs.msg.Wrench") for line in process.stdout)
        assert wait_until(lambda: robot.heard)
    assert [m.wrench.force.x for m in robot.heard] == [5.0]
    text = ros2("topic", "pub", "--times", "2", "-r", "50", *what)
    assert "publishing #2" in text
    assert "publishing #3" not in text


def test_pub_goes_on_until_stopped(robot):
    robot.heard.clear()
    what = ("/lab/pull", "geometry_msgs/msg/WrenchStamped")
    with running("topic", "pub", "-r", "20", "-w", "1", "-p", "0", *what, by=signal.SIGTERM):
        assert wait_until(lambda: len(robot.heard) > 20)


def test_pub_gives_up_waiting_when_told_to(robot):
    words = ("topic", "pub", "-t", "2", "-w", "3", "--max-wait-time-secs", "0.5")
    told = ros2(*words, "/lab/pull", "geometry_msgs/msg/WrenchStamped", status=1)
    assert "fewer than 3 matching subscription(s) after 0.5 s" in told


def test_nodes_are_listed_and_described(robot):
    assert ros2("node", "list", shows="/lab/robot").splitlines() == ["/lab/robot"]
    told = ros2("node", "info", "/lab/robot", shows="    /lab/light: std_srvs/srv/SetBool")
    assert "    /lab/force: geometry_msgs/msg/WrenchStamped" in told
    assert "no node '/nobody'" in ros2("node", "info", "/nobody", status=1)


def test_parameters_are_read_and_set(robot):
    assert "  pid.p" in ros2("param", "list", "/lab/robot").splitlines()
    assert ros2("param", "get", "/lab/robot", "gain") == "Double value is: 2.5\n"
    assert ros2("param", "set", "/lab/robot", "gain", "3") == "Set parameter successful\n"
    assert ros2("param", "get", "/lab/robot", "gain", "--hide-type") == "3.0\n"
    ros2("param", "set", "/lab/robot", "gain", "-1.0", status=1, shows="gain: valid: 0 to 10")
    ros2("param", "get", "/lab/robot", "gane", status=1, shows="has no parameter 'gane'; valid: ")
    dumped = yaml.safe_load(ros2("param", "dump", "/lab/robot"))["/lab/robot"]["ros__parameters"]
    assert dumped["pid"] == {"p": 1}
    assert dumped["names"] == ["a", "b"]


def test_a_node_without_parameter_services_is_passed_over(robot):
    mute = rclpy.create_node("mute", context=robot.context, start_parameter_services=False)
    try:
        assert "/mute" in ros2("node", "list", shows="/mute").splitlines()
        told = ros2("param", "list", shows="/lab/robot:\n  gain\n")
    finally:
        mute.destroy_node()
    assert "mute" not in told


def test_where_nobody_is_nothing_is_listed():
    alone = {**ENVIRONMENT, "ROS_DOMAIN_ID": str(DOMAIN + 100)}
    for words in (("node", "list"), ("lifecycle", "nodes"), ("param", "list")):
        done = subprocess.run([*MAIN, *words], env=alone, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_services_are_listed_and_called(robot):
    light = "/lab/light [std_srvs/srv/SetBool]"
    assert light in ros2("service", "list", "-t", shows=light).splitlines()
    told = ros2("service", "call", "/lab/light", "std_srvs/srv/SetBool", "{data: true}")
    assert "std_srvs.srv.SetBool_Response(success=True, message='light True')" in told
    wrong = "service /lab/light is of type std_srvs/srv/SetBool, not std_srvs/srv/Trigger"
    ros2("service", "call", "/lab/light", "std_srvs/srv/Trigger", status=1, shows=wrong)


def test_lifecycle_is_read_and_changed(robot):
    assert ros2("lifecycle", "nodes", shows="/lab/robot").splitlines() == ["/lab/robot"]
    assert ros2("lifecycle", "get", "/lab/robot") == "unconfigured [1]\n"
    assert "- configure [1]\n\tStart: unconfigured" in ros2("lifecycle", "list", "/lab/robot")
    words = ("lifecycle", "set", "/lab/robot", "activate")
    ros2(*words, status=1, shows="no transition 'activate' from its state")
    assert ros2("lifecycle", "set", "/lab/robot", "configure") == "Transitioning successful\n"
    assert ros2("lifecycle", "get", shows="/lab") == "/lab/robot: inactive [2]\n"
    ros2("lifecycle", "set", "/lab/robot", "cleanup")


def test_bags_are_recorded_described_and_played(robot, tmp_path: Path):
    bag = tmp_path / "bag"
    words = ("bag", "record", "/lab/force", "/lab/about", "-o", str(bag))
    with running(*words, shows="messages of 2 topics"):
        assert wait_until(lambda: all(p.get_subscription_count() for p in (robot.fast, robot.once)))
        assert robot.once.wait_for_all_acked(Duration(seconds=PATIENCE))
        enough = robot.sent + RATE
        assert wait_until(lambda: robot.sent > enough)
    told = ros2("bag", "info", str(bag))
    assert "Topic: /lab/about | Type: std_msgs/msg/String | Count: 1 | Serialization Format: cdr" in told
    robot.heard.clear()
    words = ("bag", "play", str(bag), "--topics", "/lab/force", "--rate", "4", "-m", "/lab/force:=/lab/pull")
    with running(*words, "--loop"):  # until it is heard
        assert wait_until(lambda: len(robot.heard) > RATE / 2)
    assert {message.wrench.force.x for message in robot.heard} == {4.0}
    ros2(*words)  # once, and then it ends
    late = ("--start-offset", "1e6")
    ros2("bag", "play", str(bag), *late, status=2, shows=f"--start-offset 1e+06: bag {bag} ends")
    ros2("bag", "record", "-a", "-o", str(bag), status=2, shows="exists already")
    ros2("bag", "record", "-a", "-o", str(tmp_path / "short"), "-d", "0.1", shows="messages of")


@pytest.mark.parametrize("topic", ["/lab/force", "/lab/about"])  # nothing more comes: refused when it ends
def test_a_full_disk_ends_a_recording_with_one_line(robot, tmp_path: Path, topic: str):
    bag = tmp_path / "bag"
    words = [*MAIN, "bag", "record", topic, "-o", str(bag)]
    recorder = subprocess.Popen(words, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    with beside(recorder):
        assert wait_until(lambda: any(file.stat().st_size > 500 for file in bag.glob("*.mcap")))
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (1, 1))
        if topic == "/lab/about":
            recorder.send_signal(signal.SIGINT)
        _, said = recorder.communicate(timeout=PATIENCE)
    assert recorder.returncode == 1, said
    assert said.splitlines()[1:] == [f"bag {bag}: File too large; what was written before can be read"]
    assert f"Topic: {topic} | " in ros2("bag", "info", str(bag))
