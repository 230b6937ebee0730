"""A short-lived node that looks at the graph, without a daemon."""

from __future__ import annotations

import argparse
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, TypeVar

import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import ok, try_shutdown

from follower_humanoid.command_line import UsageError
from follower_humanoid.ros2_front.verbs import CommandError

Found = TypeVar("Found")
_LEAST = 1.5  # wall time until a graph on this machine has usually been found [s]
_QUIET = 0.7  # without a change for that long it counts as found [s]
_LONE = 3.0  # for that long it may be that nobody else has been found yet [s]
_LONGEST = 6.0
_STEP = 0.02
HIDDEN = "_"


def add_discovery_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ros2cli that every verb has; there is no daemon to ask."""
    parser.add_argument("--spin-time", type=float, metavar="S", help="how long to look at the graph at least")
    parser.add_argument("-s", "--use-sim-time", action="store_true", help="the node follows /clock")
    parser.add_argument("--no-daemon", action="store_true", help="no daemon is used anyway")


def stay_on_this_machine() -> None:
    """Looks at this machine's graph only, as bringup does, unless the user has said otherwise.

    Then its nodes are found in one second rather than three.
    """
    if not any(name in os.environ for name in ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS")):
        os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


@contextmanager
def graph_node(args: argparse.Namespace | None = None, name: str = "") -> Iterator[Node]:
    """A node for as long as the verb runs; hidden unless it has a name of its own."""
    stay_on_this_machine()
    remaps = ["--ros-args", "-p", "use_sim_time:=true"] if getattr(args, "use_sim_time", False) else []
    signal.signal(signal.SIGTERM, _interrupt)
    signal.signal(signal.SIGINT, _interrupt)  # also where a shell in the background ignores it
    # Were a signal to end the context, the next look at the graph would fail rather than the verb end.
    rclpy.init(args=remaps, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node(
            name or f"{HIDDEN}ros2_front_{os.getpid()}",
            start_parameter_services=False,
            enable_rosout=False,
        )
        yield node
    except rclpy.exceptions.InvalidNodeNameException as error:
        raise UsageError(str(error)) from None
    finally:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, signal.SIG_IGN)  # a second one changes nothing any more
        try_shutdown()


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def discover(node: Node, args: argparse.Namespace | None = None) -> None:
    """Waits until the graph no longer changes."""
    spin_time = getattr(args, "spin_time", None)
    least = _LEAST if spin_time is None else float(spin_time)
    begin = changed = time.monotonic()
    seen: object = None
    while True:
        now = time.monotonic()
        nodes = node.get_node_names_and_namespaces()
        names = nodes, node.get_topic_names_and_types(), node.get_service_names_and_types()
        if names != seen:
            seen, changed = names, now
        quiet = now - changed >= _QUIET and (len(nodes) > 1 or now - begin >= _LONE)
        if now - begin >= max(least, _LONGEST) or (now - begin >= least and (quiet or spin_time is not None)):
            return
        time.sleep(_STEP)


def wait_for(look: Callable[[], Found | None], longest: float = _LONGEST) -> Found | None:
    """The first thing that `look` finds within a time [s]."""
    deadline = time.monotonic() + longest
    while (found := look()) is None and time.monotonic() < deadline and ok():
        time.sleep(_STEP)
    return found


def full_name(name: str) -> str:
    """A name as people type it, with its leading slash."""
    return name if name.startswith("/") else f"/{name}"


def node_names(node: Node, hidden: bool = False) -> list[str]:
    """Full names of all nodes but this one."""
    own = node.get_fully_qualified_name()
    names = [f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces()]
    return sorted(n for n in names if n != own and (hidden or not n.rpartition("/")[2].startswith(HIDDEN)))


def find_node(node: Node, name: str) -> tuple[str, str]:
    """Waits for a node; its name and namespace.

    Raises:
        CommandError: No node of that name.
    """
    wanted = full_name(name)
    if wait_for(lambda: wanted if wanted in node_names(node, hidden=True) else None) is None:
        known = ", ".join(node_names(node)) or "none"
        raise CommandError(f"no node '{wanted}'; there are: {known}")
    space, _, own = wanted.rpartition("/")
    return own, space or "/"


def call(node: Node, service_class: Any, name: str, request: Any, longest: float = 5.0) -> Any:
    """Calls a service and returns its response.

    Raises:
        CommandError: It is not there, or it does not answer in time [s].
    """
    client = node.create_client(service_class, name)
    executor = EventsExecutor()
    executor.add_node(node)
    try:
        if not client.wait_for_service(timeout_sec=longest):
            raise CommandError(f"service {name} is not available")
        future: Future = client.call_async(request)
        # In short waits: the executor's wait hears no signal.
        deadline = time.monotonic() + longest
        while not future.done() and time.monotonic() < deadline and ok():
            executor.spin_until_future_complete(future, timeout_sec=0.1)
        if not future.done():
            raise CommandError(f"service {name} does not answer")
        return future.result()
    finally:
        executor.remove_node(node)
        executor.shutdown()
        node.destroy_client(client)
