"""`ros2 topic echo TOPIC [TYPE]`."""

from __future__ import annotations

import argparse
import time
from typing import Any

from rclpy.node import Node

from follower_humanoid.command_line import count, positive
from follower_humanoid.ros2_front.graph import add_discovery_arguments, full_name, graph_node, wait_for
from follower_humanoid.ros2_front.listening import Ear, pause, publishers_of, topic_type
from follower_humanoid.ros2_front.messages import field_of, interface, plain, yaml_text
from follower_humanoid.ros2_front.qos import add_qos_arguments, chosen_profile, matching_profile
from follower_humanoid.ros2_front.verbs import CommandError

_DEPTH = 100
_LONGEST = 128


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `echo`."""
    add = parser.add_argument
    add("topic_name", help="e.g. /zmp")
    add("message_type", nargs="?", help="package/msg/Type (default: that of the publisher)")
    add_discovery_arguments(parser)
    add_qos_arguments(parser)
    add("--once", action="store_true", help="end after the first message")
    add("--timeout", type=positive, metavar="S", help="end after that time")
    add("--field", metavar="PATH", help="only a part of the message, e.g. wrench.force.x or position[3]")
    add("--csv", action="store_true", help="one line of numbers for each message")
    add("--flow-style", action="store_true", help="lists and mappings on one line")
    add("-f", "--full-length", action="store_true", help="long lists and texts in full")
    add("-l", "--truncate-length", type=count, default=_LONGEST, metavar="N", help=f"default: {_LONGEST}")
    add("--no-arr", action="store_true", help="without the content of lists")
    add("--no-str", action="store_true", help="without the content of texts")
    add("--raw", action="store_true", help="the serialized bytes")


def run(args: argparse.Namespace) -> int:
    """Prints messages until stopped."""
    name = full_name(args.topic_name)
    with graph_node(args) as node:
        message_class = interface(args.message_type or _type(node, name))
        qos = chosen_profile(args, matching_profile(publishers_of(node, name), _DEPTH))
        ear = Ear(node, message_class, name, qos, raw=args.raw)
        begin = time.monotonic()
        heard = False
        while pause():
            for message, _ in ear.arrived():
                heard = True
                print(_text(message, args), flush=True)
                if args.once:
                    return 0
            if args.timeout is not None and time.monotonic() - begin > args.timeout:
                return 0 if heard else 1
    return 0


def _type(node: Node, name: str) -> str:
    found = wait_for(lambda: topic_type(node, name))
    if found is None:
        text = f"topic [{name}] does not appear to be published yet; give its type to wait for it"
        raise CommandError(text)
    return found


def _text(message: Any, args: argparse.Namespace) -> str:
    if args.raw:
        return f"{message!r}\n---"
    part = field_of(message, args.field) if args.field else message
    longest = None if args.full_length else args.truncate_length
    shown = plain(part, longest, not args.no_arr, not args.no_str)
    if args.csv:
        return ",".join(str(value) for value in _leaves(shown))
    return f"{yaml_text(shown, bool(args.flow_style))}---"


def _leaves(value: Any) -> list[Any]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [leaf for entry in value for leaf in _leaves(entry)]
    return [value]
