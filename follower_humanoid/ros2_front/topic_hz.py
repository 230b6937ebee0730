"""`ros2 topic hz TOPIC`: rate from the times at which messages arrived."""

from __future__ import annotations

import argparse
import math
import time
from collections import deque
from collections.abc import Sequence
from itertools import pairwise

from follower_humanoid.command_line import count
from follower_humanoid.ros2_front.graph import add_discovery_arguments, full_name, graph_node, wait_for
from follower_humanoid.ros2_front.listening import Ear, pause, publishers_of, topic_type
from follower_humanoid.ros2_front.messages import interface
from follower_humanoid.ros2_front.qos import add_qos_arguments, chosen_profile, matching_profile

_DEPTH = 5000
_WINDOW = 10000
_NANO = 1e-9


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of `hz`."""
    add = parser.add_argument
    add("topic_name", help="e.g. /joint_states")
    add("-w", "--window", type=count, default=_WINDOW, metavar="N", help=f"messages (default: {_WINDOW})")
    add("--wall-time", action="store_true", help="wall time is what is measured anyway")
    add_discovery_arguments(parser)
    add_qos_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Prints the rate once a second until stopped."""
    name = full_name(args.topic_name)
    with graph_node(args) as node:
        found = wait_for(lambda: topic_type(node, name))
        if found is None:
            print(f"WARNING: topic [{name}] does not appear to be published yet", flush=True)
            while found is None and pause():
                found = topic_type(node, name)
            if found is None:
                return 0
        qos = chosen_profile(args, matching_profile(publishers_of(node, name), _DEPTH))
        ear = Ear(node, interface(found), name, qos, raw=True)
        times: deque[int] = deque(maxlen=max(args.window, 2))
        told = (time.monotonic(), 0)
        heard = 0
        while pause():
            arrived = [int(info["received_timestamp"]) for _, info in ear.arrived()]
            times.extend(arrived)
            heard += len(arrived)
            if time.monotonic() - told[0] < 1.0:
                continue
            if heard == told[1]:
                print("no new messages", flush=True)
            elif len(times) > 1:
                print(statistics(times), flush=True)
            told = (time.monotonic(), heard)
    return 0


def statistics(times: Sequence[int]) -> str:
    """Rate and spread of the distances between times [ns], in ros2cli's words."""
    listed = list(times)
    distances = [(b - a) * _NANO for a, b in pairwise(listed)]
    mean = sum(distances) / len(distances)
    spread = math.sqrt(sum((d - mean) ** 2 for d in distances) / len(distances))
    rate = 1.0 / mean if mean > 0.0 else math.inf
    return (
        f"average rate: {rate:.3f}\n\tmin: {min(distances):.3f}s max: {max(distances):.3f}s "
        f"std dev: {spread:.5f}s window: {len(listed)}"
    )
