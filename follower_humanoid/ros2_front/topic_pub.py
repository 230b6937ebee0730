"""`ros2 topic pub TOPIC TYPE [VALUES]`."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from rclpy.utilities import ok

from follower_humanoid.command_line import UsageError, count, positive
from follower_humanoid.ros2_front.graph import full_name, graph_node
from follower_humanoid.ros2_front.messages import fill, interface, read_values
from follower_humanoid.ros2_front.qos import DEPTH, add_qos_arguments, chosen_profile
from follower_humanoid.ros2_front.verbs import CommandError

_LAST_ACKNOWLEDGEMENT = Duration(seconds=1)
_STEP = 0.02


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `pub`."""
    add = parser.add_argument
    add("topic_name", help="e.g. /leader/left_hand/wrench")
    add("message_type", help="package/msg/Type")
    add("values", nargs="?", default="", help="YAML; a field left out keeps its default")
    add("--stdin", action="store_true", help="values from standard input")
    add("--yaml-file", type=Path, metavar="FILE", help="values from a file")
    add("-r", "--rate", type=positive, default=1.0, metavar="HZ", help="messages a second (default: 1)")
    add("-p", "--print", type=count, default=1, metavar="N", help="print every Nth message only; 0: none")
    group = parser.add_mutually_exclusive_group()
    group.add_argument("-1", "--once", action="store_true", help="one message")
    group.add_argument("-t", "--times", type=count, default=0, metavar="N", help="N messages")
    add("-w", "--wait-matching-subscriptions", type=count, metavar="N",
        help="subscribers to wait for (default: 1 with --once and --times, else 0)")  # fmt: skip
    add("--max-wait-time-secs", type=positive, metavar="S", help="longest wait for them")
    add("--keep-alive", type=float, default=0.1, metavar="S", help="stay that long after the last message")
    add("-n", "--node-name", default="", help="name of the node that publishes")
    add("-s", "--use-sim-time", action="store_true", help="the node follows /clock")
    add("--spin-time", type=float, metavar="S", help=argparse.SUPPRESS)
    add_qos_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Publishes until stopped, or as often as asked."""
    message_class = interface(args.message_type)
    values = read_values(_values(args))
    fill(message_class(), values)  # complains before anything is started
    times = 1 if args.once else args.times
    wanted = args.wait_matching_subscriptions
    wanted = (1 if times else 0) if wanted is None else wanted
    with graph_node(args, args.node_name or "") as node:
        qos = chosen_profile(args, QoSProfile(depth=DEPTH))
        publisher = node.create_publisher(message_class, full_name(args.topic_name), qos)
        _wait(publisher, wanted, args.max_wait_time_secs)
        print("publisher: beginning loop", flush=True)
        due = time.monotonic()
        number = 0
        while ok():
            number += 1
            message = message_class()
            fill(message, values)  # anew: a stamp may be `now`
            publisher.publish(message)
            if args.print and number % args.print == 0:
                print(f"publishing #{number}: {message!r}\n", flush=True)
            if times and number >= times:
                break
            due = max(due + 1.0 / args.rate, time.monotonic() - 1.0)
            time.sleep(max(0.0, due - time.monotonic()))
        if ok():
            publisher.wait_for_all_acked(_LAST_ACKNOWLEDGEMENT)
            time.sleep(max(0.0, args.keep_alive))
    return 0


def _values(args: argparse.Namespace) -> str:
    if args.stdin:
        return sys.stdin.read()
    if args.yaml_file is not None:
        try:
            return str(args.yaml_file.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"--yaml-file {args.yaml_file}: {getattr(error, 'strerror', error)}") from None
    return str(args.values)


def _wait(publisher: Any, wanted: int, longest: float | None) -> None:
    begin = told = time.monotonic()
    while ok() and publisher.get_subscription_count() < wanted:
        now = time.monotonic()
        if longest is not None and now - begin > longest:
            raise CommandError(f"fewer than {wanted} matching subscription(s) after {longest:g} s")
        if now - told >= 1.0:
            told = now
            print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
        time.sleep(_STEP)
