"""Plays a bag into the graph: stored bytes go out as they are; services and the space bar pause it."""

from __future__ import annotations

import gc
import importlib
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from types import FrameType
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from rclpy.utilities import try_shutdown
from std_srvs.srv import Trigger

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.replay.index import BagIndex, index_bag
from follower_humanoid.replay.offered import Offered
from follower_humanoid.replay.pace import Pace
from follower_humanoid.replay.player import Player, PlayOptions
from follower_humanoid.ros.keyboard import on_space
from follower_humanoid.ros.spin import start_ros

_LAST_ACKNOWLEDGEMENT = Duration(seconds=1)
_MATCHING = 3.0  # wall time in which subscribers are found before the first message, at the longest [s]
_QUIET = 0.5  # once there are some, the others are there too after that long
_LEAST = 1.2  # graphs of this package announce themselves every half second
_STEP = 0.02
# Topics that any number of nodes may publish.
_EVERYBODYS = frozenset({"diagnostics", "rosout", "parameter_events", "tf", "tf_static"})
REPLAY = "replay"


def play(options: PlayOptions, ros_args: list[str], name: str = REPLAY) -> int:
    """Plays a bag; returns the exit status.

    Beside a running graph, whose nodes it would contradict, `replay` plays nothing; under any other name it
    says so and plays. The clock alone is left to whoever keeps it already.

    Raises:
        ConfigurationError: The bag or an option cannot be used, or somebody publishes the same already.
    """
    index = index_bag(options.bag)
    types = {topic: message_class(entry.type_name) for topic, entry in index.topics.items()}
    player = Player(index, options, {topic for topic, found in types.items() if found is not None})
    told = len(index.notes)
    for note in [*index.notes, *_not_installed(index, types)]:
        print(f"note: {note}", file=sys.stderr)

    def stop(number: int, frame: FrameType | None) -> None:
        player.pace.stop()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    start_ros(["--ros-args", *ros_args])
    try:
        with on_space(player.pace.toggle):
            _play(player, index, types, name)
        for note in index.notes[told:]:
            print(f"note: {note}", file=sys.stderr)
    finally:
        try_shutdown()
    return 0


def message_class(type_name: str) -> Any | None:
    """The class of `package/msg/Type`; None where it is not installed."""
    package, _, name = type_name.partition("/msg/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name, None)
    except ImportError:
        return None


def _not_installed(index: BagIndex, types: dict[str, Any]) -> list[str]:
    missing = [topic for topic, found in types.items() if found is None]
    return [f"{topic} is left out: {index.topics[topic].type_name} is not installed" for topic in missing]


def _play(player: Player, index: BagIndex, types: dict[str, Any], name: str) -> None:
    node = rclpy.create_node(name)
    _offer_services(node, player.pace)
    publishers: dict[str, Any] = {}
    for topic in sorted(player.topics):
        publishers[topic] = node.create_publisher(types[topic], topic, _qos(index.topics[topic].offered))
    for topic, type_name in player.made_topics().items():
        publishers[topic] = node.create_publisher(message_class(type_name), topic, 10)
    over = threading.Event()
    spinning = threading.Thread(target=_spin, args=(node, over))
    spinning.start()
    try:
        _wait_for_subscribers(publishers, player.pace)
        taken = _taken(node, publishers)
        clocks = taken.keys() & {*player.clocks, *player.made_topics()}
        rivals = [f"{topic} is published by {taken[topic]} already" for topic in sorted({*taken} - clocks)]
        if rivals and name == REPLAY:
            raise ConfigurationError(f"{rivals[0]}; valid: another ROS_DOMAIN_ID, or --topics with others")
        notes = [*rivals[:1], *(f"{topic} is left to {taken[topic]}" for topic in sorted(clocks))]
        print(*(f"note: {note}\n" for note in notes), sep="", end="", file=sys.stderr)
        print(_announcement(player, index), file=sys.stderr, flush=True)
        gc.collect()
        gc.disable()  # a collection would delay messages; nothing here makes cycles
        sends: dict[str, Callable[[bytes], None]] = {
            topic: _keep_silent if topic in clocks else publisher.publish
            for topic, publisher in publishers.items()
        }
        player.run(lambda topic, data: sends[topic](data))
        if not player.pace.stopped:
            for publisher in publishers.values():
                publisher.wait_for_all_acked(_LAST_ACKNOWLEDGEMENT)
    finally:
        gc.enable()
        over.set()
        spinning.join()
        node.destroy_node()


def _taken(node: Node, publishers: dict[str, Any]) -> dict[str, str]:
    """Which of these topics others publish already, and who."""
    taken = {}
    for topic, publisher in publishers.items():
        if topic.rpartition("/")[2] not in _EVERYBODYS:
            infos = node.get_publishers_info_by_topic(publisher.topic_name)
            others = Counter(info.node_name for info in infos) - Counter([node.get_name()])
            if others:
                taken[topic] = ", ".join(sorted(others))
    return taken


def _keep_silent(data: bytes) -> None:
    """In place of a clock where somebody else keeps the time."""


def _announcement(player: Player, index: BagIndex) -> str:
    state = "paused" if player.pace.paused else "playing"
    what = f"{index.path}, {index.duration:.3f} s, {len(player.topics)} topics"
    return f"{state}: {what}, rate {player.pace.rate:g}"


def _qos(offered: Offered) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=offered.depth,
        reliability=ReliabilityPolicy.RELIABLE if offered.reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if offered.latched else DurabilityPolicy.VOLATILE,
    )


def _offer_services(node: Node, pace: Pace) -> None:
    """`~/pause`, `~/resume`, `~/toggle_paused`, `~/is_paused`: named as `ros2 bag play` names them."""

    def offer(name: str, action: Callable[[], None]) -> None:
        def answer(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            action()
            response.success = True
            response.message = "paused" if pace.paused else "playing"
            return response

        node.create_service(Trigger, f"~/{name}", answer)

    offer("pause", pace.pause)
    offer("resume", pace.resume)
    offer("toggle_paused", pace.toggle)
    offer("is_paused", lambda: None)


def _spin(node: Node, over: threading.Event) -> None:
    executor = EventsExecutor()
    executor.add_node(node)
    while not over.is_set():
        # In short waits: the executor's wait without a limit never returns.
        executor.spin_until_future_complete(Future(), timeout_sec=0.1)
    executor.shutdown()


def _wait_for_subscribers(publishers: dict[str, Any], pace: Pace) -> None:
    """Gives subscribers that are there already the time to be found."""
    begin = changed = time.monotonic()
    seen = -1
    while not pace.stopped and (now := time.monotonic()) - begin < _MATCHING:
        matched = sum(publisher.get_subscription_count() for publisher in publishers.values())
        if matched != seen:
            seen, changed = matched, now
        if matched and now - changed > _QUIET and now - begin > _LEAST:
            return
        time.sleep(_STEP)
