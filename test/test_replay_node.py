"""The executable `replay` in the graph: right bytes in their order, not too early, pauses, plain words."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from bag_messages import START, TICK_NS, write_bag
from graph_bench import PATIENCE, free_domain, wait_until
from nav_msgs.msg import Odometry
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from follower_humanoid.nodes.replay import main
from follower_humanoid.replay.events import events
from follower_humanoid.replay.index import index_bag

DOMAIN = free_domain()
COMMAND = [sys.executable, "-m", "follower_humanoid.nodes.replay"]
ENVIRONMENT = {**os.environ, "ROS_DOMAIN_ID": str(DOMAIN)}


class Listener:
    """Takes what arrives from the queues, with the times at which it came."""

    def __init__(self) -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=DOMAIN)
        self.node = Node("listener", context=self._context)
        # It asks by another node: an executor would take what arrives at this one.
        self._asker = Node("asker", context=self._context)
        self._subscriptions: dict[str, Any] = {
            name: self.node.create_subscription(kind, name, lambda _: None, QoSProfile(depth=5000), raw=True)
            for name, kind in (("/odom", Odometry), ("/clock", Clock))
        }
        self.heard: dict[str, list[tuple[int, bytes]]] = {name: [] for name in self._subscriptions}
        self.asked = 0  # when a service was last asked [ns]

    def listen(self) -> None:
        for name, subscription in self._subscriptions.items():
            with subscription.handle:
                while (taken := subscription.handle.take_message(subscription.msg_type, True)) is not None:
                    self.heard[name].append((taken[1]["received_timestamp"], bytes(taken[0])))

    def listen_for(self, seconds: float) -> int:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.listen()
            time.sleep(0.01)
        return len(self.heard["/odom"])

    def wait_for(self, count: int) -> None:
        """Until so many messages have come."""
        assert wait_until(lambda: self.listen_for(0.05) >= count), "nothing arrives"

    def wait_for_silence(self) -> int:
        """Until nothing has come for a second; how much came before."""

        def silent() -> bool:
            return self.listen_for(0.0) == self.listen_for(1.0)

        assert wait_until(silent), "it does not end"
        return len(self.heard["/odom"])

    def begin(self) -> None:
        """Lets a paused replay go on once it will be heard from its first message on."""
        assert wait_until(self._subscriptions["/odom"].get_publisher_count)
        assert self.ask("is_paused") == "paused"
        assert self.ask("resume") == "playing"

    def ask(self, service: str) -> str:
        client = self._asker.create_client(Trigger, f"/replay/{service}")
        executor = EventsExecutor(context=self._context)
        executor.add_node(self._asker)
        assert client.wait_for_service(PATIENCE)
        self.asked = time.time_ns()
        future = client.call_async(Trigger.Request())
        deadline = time.monotonic() + PATIENCE
        while not future.done() and time.monotonic() < deadline:
            executor.spin_until_future_complete(future, timeout_sec=0.1)
        executor.remove_node(self._asker)
        executor.shutdown()
        self._asker.destroy_client(client)
        return str(future.result().message)

    def close(self) -> None:
        self.node.destroy_node()
        self._asker.destroy_node()
        rclpy.shutdown(context=self._context)


@pytest.fixture
def listener() -> Iterator[Listener]:
    made = Listener()
    yield made
    made.close()


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("replay") / "bag", 2000)


def start(*words: str) -> subprocess.Popen[str]:
    return subprocess.Popen([*COMMAND, *words], env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)


def end(process: subprocess.Popen[str], number: signal.Signals) -> None:
    process.send_signal(number)
    try:
        _, errors = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 0, errors
    assert "Traceback" not in errors


@pytest.mark.parametrize("rate", [1.0, 2.0])
def test_every_byte_comes_and_none_before_its_time(listener, bag, rate):
    """When exactly messages are sent is a matter of `Pace`, which has tests with a clock of their own."""
    recorded = list(events(index_bag(bag), frozenset({"/odom"})))
    replay = start(str(bag), "--rate", str(rate), "--topics", "odom", "--paused")
    assert replay.stderr is not None
    # Said when it no longer waits for listeners: from now on nothing but the pause holds it up.
    assert replay.stderr.readline().endswith(f"rate {rate:g}\n")
    listener.begin()
    while replay.poll() is None:
        listener.listen_for(0.05)
    listener.wait_for_silence()
    assert replay.returncode == 0
    heard = listener.heard["/odom"]
    assert [data for _, data in heard] == [event.data for event in recorded]
    for (received, _), event in zip(heard, recorded, strict=True):
        assert received - listener.asked >= (event.time - START) / rate


def test_a_clock_goes_with_it(listener, bag):
    replay = start(str(bag), "--start", "3.5", "--paused")
    listener.begin()
    while replay.poll() is None:
        listener.listen_for(0.05)
    listener.wait_for_silence()
    assert len(listener.heard["/odom"]) == pytest.approx(250, abs=2)
    assert len(listener.heard["/clock"]) == pytest.approx(50, abs=2)
    seconds = [int.from_bytes(data[4:8], "little") for _, data in listener.heard["/clock"]]
    assert seconds[0] == (START + 1750 * TICK_NS) // 10**9


def test_services_pause_and_resume(listener, bag):
    replay = start(str(bag), "--paused", "--loop")
    assert listener.ask("is_paused") == "paused"
    assert listener.listen_for(1.0) == 0
    assert listener.ask("resume") == "playing"
    listener.wait_for(1)
    assert listener.ask("toggle_paused") == "paused"
    count = listener.wait_for_silence()
    assert listener.ask("resume") == "playing"
    listener.wait_for(count + 100)
    end(replay, signal.SIGINT)


def test_names_are_remapped_and_sigterm_ends_it(listener, bag):
    replay = start(str(bag), "--loop", "--topics", "com", "--ros-args", "-r", "/com:=/elsewhere")
    assert wait_until(lambda: listener.node.count_publishers("/elsewhere") == 1)
    assert listener.node.count_publishers("/com") == 0
    end(replay, signal.SIGTERM)


def test_it_plays_nothing_that_somebody_publishes_already(listener, bag):
    other = start(str(bag), "--topics", "com", "--paused")
    assert other.stderr.readline().startswith("paused: ")  # it has looked for others itself
    replay = start(str(bag))
    _, errors = replay.communicate(timeout=PATIENCE)
    assert replay.returncode == 2
    assert "/com is published by replay already" in errors
    assert listener.listen_for(0.0) == 0
    replay = start(str(bag), "--topics", "odom", "--loop")
    listener.wait_for(10)
    end(replay, signal.SIGTERM)
    assert listener.heard["/clock"] == []  # left to who keeps it
    end(other, signal.SIGTERM)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["/no/such/bag"], "bag /no/such/bag does not exist"),
        (["BAG", "--rate", "fast"], "--rate: 'fast': needs a number"),
        (["BAG", "--rate", "-1"], "--rate: '-1': needs a number greater than 0"),
        (["BAG", "--rate", "0"], "--rate: '0': needs a number greater than 0"),
        (["BAG", "--start", "-1"], "--start: '-1': needs a number from 0 on"),
        (["BAG", "--loop=yes"], "argument --loop: takes no value (given: 'yes')"),
        (["BAG", "--start", "1000"], "--start 1000: bag {bag} ends after"),
        (["BAG", "--topics", "/nothing"], "bag {bag}: no topic '/nothing'; valid: "),
        (["BAG", "--wrong"], "no such argument: --wrong"),
        (["BAG", "--simulate"], "carries no parameters.yaml"),
        (["BAG", "--simulate", "--rate", "3"], "--rate has no use with --simulate"),
        (["BAG", "--verify", "--loop"], "--loop has no use with --simulate"),
        (["BAG", "--verify", "--topics", "odom"], "--topics has no use with --simulate"),
        (["BAG", "--simulate", "--verify", "--start", "1"], "--start has no use with --simulate"),
        (["BAG", "--simulate", "--paused"], "--paused has no use with --simulate"),
        (["BAG", "--namespace", "one"], "--namespace needs --simulate"),
        ([], "required: BAG"),
    ],
)
def test_what_cannot_be_played_is_told_in_one_line(bag, words, told):
    replay = start(*(str(bag) if word == "BAG" else word for word in words))
    _, errors = replay.communicate(timeout=PATIENCE)
    assert replay.returncode == 2
    assert told.replace("{bag}", str(bag)) in errors
    assert errors.strip().splitlines()[-1].find("Traceback") < 0
    assert "Traceback" not in errors


def test_help_tells_which_times_are_meant(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "recorded seconds a second, by the recording's wall clock (default: 1)" in told
    assert "leave out the first seconds, by the recording's wall clock" in told
