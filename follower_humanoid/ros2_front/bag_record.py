"""`ros2 bag record`: any topics of the graph into an MCAP bag."""

from __future__ import annotations

import argparse
import re
import sys
import time
from datetime import datetime
from pathlib import Path
from typing import Any

from rclpy.node import Node

from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.writer import About, BagWriter
from follower_humanoid.command_line import UsageError, positive
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.ros2_front.graph import full_name, graph_node
from follower_humanoid.ros2_front.listening import Ear, pause
from follower_humanoid.ros2_front.messages import interface
from follower_humanoid.ros2_front.qos import matching_profile
from follower_humanoid.ros2_front.verbs import CommandError

_DEPTH = 2000
_LOOK_EVERY = 0.2


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `record`."""
    add = parser.add_argument
    add("topic_names", nargs="*", metavar="TOPIC", help="topics to record")
    add("--topics", nargs="+", default=[], metavar="TOPIC", help="the same")
    add("-a", "--all", "--all-topics", action="store_true", help="all topics, also those that come later")
    add("-e", "--regex", default="", help="topics whose names match")
    add("--exclude-topics", nargs="+", default=[], metavar="TOPIC", help="all but these")
    add("--exclude-regex", default="", metavar="REGEX", help="all but those that match")
    add("--include-hidden-topics", action="store_true", help="those with _ too")
    add("-o", "--output", type=Path, metavar="DIR", help="folder (default: rosbag2_<date-time>)")
    add("-s", "--storage", choices=["mcap"], default="mcap", help="only MCAP is written")
    add("-d", "--max-recording-duration", type=positive, metavar="S", help="end after that time")
    add("--use-sim-time", action="store_true", help=argparse.SUPPRESS)


def run(args: argparse.Namespace) -> int:
    """Records until stopped."""
    wanted = {full_name(name) for name in (*args.topic_names, *args.topics)}
    if not (wanted or args.all or args.regex):
        raise UsageError("ros2 bag record: which topics? Name some, or use --all or --regex")
    try:
        choice = _Choice(frozenset(wanted), args)
    except re.error as error:
        raise UsageError(f"ros2 bag record: no regular expression: {error}") from None
    folder = args.output or Path(datetime.now().strftime("rosbag2_%Y_%m_%d-%H_%M_%S"))
    try:
        messages, topics = _record(folder, choice, args.max_recording_duration)
    except OSError as error:  # of closing, too
        raise CommandError(f"bag {folder}: {error.strerror}; what was written before can be read") from None
    print(f"{messages} messages of {topics} topics", file=sys.stderr)
    return 0


def _record(folder: Path, choice: _Choice, longest: float | None) -> tuple[int, int]:
    """Records until stopped, or for a time [s]; returns how many messages of how many topics."""
    with graph_node(name="rosbag2_recorder") as node, BagWriter(folder, About(), time.time_ns()) as writer:
        print(f"recording into {folder}; Ctrl-C ends it", file=sys.stderr, flush=True)
        recorder = _Recorder(node, writer, choice)
        end = None if longest is None else time.monotonic() + longest
        try:
            while pause() and (end is None or time.monotonic() < end):
                recorder.visit()
        except KeyboardInterrupt:
            recorder.visit()
    return writer.message_count, len(recorder.ears)


class _Choice:
    """Which topics are recorded."""

    def __init__(self, wanted: frozenset[str], args: argparse.Namespace) -> None:
        self._wanted, self._all = wanted, args.all
        self._excluded = {full_name(name) for name in args.exclude_topics}
        self._pattern = re.compile(args.regex) if args.regex else None
        self._not = re.compile(args.exclude_regex) if args.exclude_regex else None
        self._hidden = args.include_hidden_topics

    def takes(self, name: str) -> bool:
        """Whether a topic is recorded."""
        if name in self._excluded or (self._not is not None and self._not.search(name)):
            return False
        if name in self._wanted:
            return True
        if not self._hidden and any(part.startswith("_") for part in name.split("/")):
            return False
        return bool(self._all or (self._pattern is not None and self._pattern.search(name)))


class _Recorder:
    """Subscribes to what comes up and writes what arrives."""

    def __init__(self, node: Node, writer: BagWriter, choice: _Choice) -> None:
        self._node, self._writer, self._choice = node, writer, choice
        self.ears: dict[str, tuple[Ear, int]] = {}
        self._unusable: set[str] = set()
        self._looked = -_LOOK_EVERY

    def visit(self) -> None:
        """Looks for new topics now and then; writes in the order of arrival."""
        if time.monotonic() - self._looked > _LOOK_EVERY:
            self._looked = time.monotonic()
            self._look()
        arrived: list[tuple[int, int, int, bytes]] = []
        for ear, channel in self.ears.values():
            for data, info in ear.arrived():
                arrived.append((info["received_timestamp"], info["source_timestamp"], channel, data))
        arrived.sort(key=lambda entry: entry[0])
        for received, published, channel, data in arrived:
            self._writer.write(channel, data, received, published)

    def _look(self) -> None:
        for name, types in self._node.get_topic_names_and_types():
            if name in self.ears or name in self._unusable or not self._choice.takes(name):
                continue
            publishers = self._node.get_publishers_info_by_topic(name)
            if not publishers:  # only then is it known how it is published
                continue
            try:
                self.ears[name] = self._listen(name, types[0], publishers)
            except (CommandError, ConfigurationError) as error:
                self._unusable.add(name)
                print(f"note: {name} is left out: {error}", file=sys.stderr)

    def _listen(self, name: str, type_name: str, publishers: list[Any]) -> tuple[Ear, int]:
        message_class = interface(type_name)
        profiles = [info.qos_profile for info in publishers]
        offered = [offered_qos(p.reliability.name.lower(), p.durability.name.lower()) for p in profiles]
        channel = self._writer.add_topic(name, type_name, offered)
        return Ear(self._node, message_class, name, matching_profile(publishers, _DEPTH), raw=True), channel
