"""The command `ros2` against a running node: every verb as a person types it, in a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
import yaml
from geometry_msgs.msg import WrenchStamped
from graph_bench import free_domain
from rcl_interfaces.msg import SetParametersResult
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


class Robot(LifecycleNode):
    """Publishes, listens, has parameters and a service."""

    def __init__(self, context: rclpy.Context) -> None:
        super().__init__("robot", context=context, namespace="lab")
        self.heard: list[WrenchStamped] = []
        self.declare_parameter("gain", 2.5)
        self.declare_parameter("pid.p", 1)
        self.declare_parameter("names", ["a", "b"])
        self.add_on_set_parameters_callback(self._allow)
        best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        latched = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._fast = self.create_publisher(WrenchStamped, "force", best_effort)
        self._once = self.create_publisher(String, "about", latched)
        self._once.publish(String(data="a robot"))
        self.create_subscription(WrenchStamped, "pull", self.heard.append, best_effort)
        self.create_service(SetBool, "light", self._light)
        self.create_timer(1.0 / RATE, self._send)

    def _send(self) -> None:
        message = WrenchStamped()
        message.wrench.force.x = 4.0
        self._fast.publish(message)

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


def ros2(*words: str, status: int = 0) -> str:
    done = subprocess.run(
        [*MAIN, *words], env=ENVIRONMENT, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == status, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout + done.stderr


def test_topics_are_listed_and_described(robot):
    assert "/lab/force" in ros2("topic", "list").splitlines()
    assert "/lab/about [std_msgs/msg/String]" in ros2("topic", "list", "-t").splitlines()
    told = ros2("topic", "info", "/lab/pull", "-v")
    assert "Type: geometry_msgs/msg/WrenchStamped" in told
    assert "Publisher count: 0" in told
    assert "Subscription count: 1" in told
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
    words = ["topic", "hz", "/lab/force"]
    process = subprocess.Popen([*MAIN, *words], env=ENVIRONMENT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    rates = []
    while len(rates) < 3:
        line = process.stdout.readline()
        assert line, "ended early"
        if line.startswith("average rate:"):
            rates.append(float(line.split()[-1]))
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=10)
    assert process.returncode == 0
    assert 0.3 * RATE < rates[-1] < 1.5 * RATE  # a busy machine may be slow


def test_pub_once_waits_for_the_subscriber(robot):
    robot.heard.clear()
    text = ros2(
        "topic", "pub", "--once", "/lab/pull", "geometry_msgs/msg/WrenchStamped", "{wrench: {force: {x: 5}}}"
    )
    assert "publishing #1: geometry_msgs.msg.WrenchStamped(" in text
    deadline = time.monotonic() + 5.0
    while not robot.heard and time.monotonic() < deadline:
        time.sleep(0.02)
    assert [m.wrench.force.x for m in robot.heard] == [5.0]


def test_pub_keeps_its_rate_until_interrupted(robot):
    robot.heard.clear()
    words = ["topic", "pub", "-r", "20", "-w", "1", "-p", "0", "/lab/pull", "geometry_msgs/msg/WrenchStamped"]
    process = subprocess.Popen([*MAIN, *words], env=ENVIRONMENT, stdout=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 30.0
    while not robot.heard and time.monotonic() < deadline:
        time.sleep(0.01)
    begin, count = time.monotonic(), len(robot.heard)
    time.sleep(2.0)
    rate = (len(robot.heard) - count) / (time.monotonic() - begin)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=10)
    assert process.returncode == 0
    assert rate == pytest.approx(20.0, rel=0.2)


def test_pub_gives_up_waiting_when_told_to(robot):
    words = ("topic", "pub", "-t", "2", "-w", "3", "--max-wait-time-secs", "0.5")
    told = ros2(*words, "/lab/pull", "geometry_msgs/msg/WrenchStamped", status=1)
    assert "fewer than 3 matching subscription(s) after 0.5 s" in told


def test_nodes_are_listed_and_described(robot):
    assert ros2("node", "list").splitlines() == ["/lab/robot"]
    told = ros2("node", "info", "/lab/robot")
    assert "    /lab/force: geometry_msgs/msg/WrenchStamped" in told
    assert "    /lab/light: std_srvs/srv/SetBool" in told
    assert "no node '/nobody'" in ros2("node", "info", "/nobody", status=1)


def test_parameters_are_read_and_set(robot):
    assert "  pid.p" in ros2("param", "list", "/lab/robot").splitlines()
    assert ros2("param", "get", "/lab/robot", "gain") == "Double value is: 2.5\n"
    assert ros2("param", "set", "/lab/robot", "gain", "3") == "Set parameter successful\n"
    assert ros2("param", "get", "/lab/robot", "gain", "--hide-type") == "3.0\n"
    assert "gain: valid: 0 to 10" in ros2("param", "set", "/lab/robot", "gain", "-1.0", status=1)
    assert "has no parameter 'gane'; valid: " in ros2("param", "get", "/lab/robot", "gane", status=1)
    dumped = yaml.safe_load(ros2("param", "dump", "/lab/robot"))["/lab/robot"]["ros__parameters"]
    assert dumped["pid"] == {"p": 1}
    assert dumped["names"] == ["a", "b"]


def test_a_node_without_parameter_services_is_passed_over(robot):
    mute = rclpy.create_node("mute", context=robot.context, start_parameter_services=False)
    try:
        assert "/mute" in ros2("node", "list").splitlines()
        told = ros2("param", "list")
    finally:
        mute.destroy_node()
    assert "/lab/robot:\n  gain\n" in told
    assert "mute" not in told


def test_where_nobody_is_nothing_is_listed():
    alone = {**ENVIRONMENT, "ROS_DOMAIN_ID": str(DOMAIN + 100)}
    for words in (("node", "list"), ("lifecycle", "nodes"), ("param", "list")):
        done = subprocess.run([*MAIN, *words], env=alone, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_services_are_listed_and_called(robot):
    assert "/lab/light [std_srvs/srv/SetBool]" in ros2("service", "list", "-t").splitlines()
    told = ros2("service", "call", "/lab/light", "std_srvs/srv/SetBool", "{data: true}")
    assert "std_srvs.srv.SetBool_Response(success=True, message='light True')" in told
    wrong = ros2("service", "call", "/lab/light", "std_srvs/srv/Trigger", status=1)
    assert "service /lab/light is of type std_srvs/srv/SetBool, not std_srvs/srv/Trigger" in wrong


def test_lifecycle_is_read_and_changed(robot):
    assert ros2("lifecycle", "nodes").splitlines() == ["/lab/robot"]
    assert ros2("lifecycle", "get", "/lab/robot") == "unconfigured [1]\n"
    assert "- configure [1]\n\tStart: unconfigured" in ros2("lifecycle", "list", "/lab/robot")
    told = ros2("lifecycle", "set", "/lab/robot", "activate", status=1)
    assert "no transition 'activate' from its state" in told
    assert ros2("lifecycle", "set", "/lab/robot", "configure") == "Transitioning successful\n"
    assert ros2("lifecycle", "get") == "/lab/robot: inactive [2]\n"
    ros2("lifecycle", "set", "/lab/robot", "cleanup")


def test_bags_are_recorded_described_and_played(robot, tmp_path: Path):
    bag = tmp_path / "bag"
    told = ros2("bag", "record", "/lab/force", "/lab/about", "-o", str(bag), "-d", "4")
    assert "messages of 2 topics" in told
    told = ros2("bag", "info", str(bag))
    assert "Topic: /lab/about | Type: std_msgs/msg/String | Count: 1 | Serialization Format: cdr" in told
    robot.heard.clear()
    words = ("bag", "play", str(bag), "--topics", "/lab/force", "--rate", "4", "-m", "/lab/force:=/lab/pull")
    ros2(*words)
    assert len(robot.heard) > RATE / 2
    assert "exists already" in ros2("bag", "record", "-a", "-o", str(bag), status=2)
