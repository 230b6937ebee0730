"""Runs nodes on one executor until a signal comes or one of them has come to its end."""

from __future__ import annotations

import ctypes
import gc
import math
import os
import re
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType
from typing import Any, cast

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import ok, try_shutdown

from follower_humanoid.command_line import Parser, split_ros_args
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError
from follower_humanoid.ros.bus import Bus
from follower_humanoid.ros.claim import Claim
from follower_humanoid.ros.managed_node import REST, ManagedNode
from follower_humanoid.ros.quiet import quiet_stderr
from follower_humanoid.ros.transport import asked_to_be_open, choose_network

PARENT = "FOLLOWER_HUMANOID_PARENT"
_PR_SET_PDEATHSIG = 1
_TURN = 0.02  # wall time for which steps keep the executor waiting where people's messages come to it [s]
_LONG_TURN = 0.05  # the same where only services and timers do: a turn costs as much as half a step [s]
_LAST_WORD = 0.1  # s
_DISMISSAL = 1.5  # s
_LONGEST_WIND_DOWN = 0.5  # s
_NOT_TAKEN = 1.0  # after which who takes nothing is left alone [s]


class StopSignal:
    """Remembers that SIGINT or SIGTERM asked to stop.

    Attributes:
        asked: True from then on.
        asked_at: When it first did so, on the monotonic clock [s].
        over: True from then on, or once `end` has been called.
        also: Called then too.
    """

    def __init__(self) -> None:
        """Takes over both signals."""
        self.asked = False
        self.also: Callable[[], None] = lambda: None
        self.asked_at = math.inf
        self.over = False
        self._awaited: Any = Future()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)

    def end(self) -> None:
        """Wakes whoever waits for `over`."""
        self.over = True
        if not self._awaited.done():
            self._awaited.set_result(None)
        self.also()

    def future(self) -> Any:
        """Completes when it is over. For one wait: an executor leaves a callback in what it waits for."""
        self._awaited = Future()
        if self.over:
            self._awaited.set_result(None)
        return self._awaited

    def _ask(self, number: int, frame: FrameType | None) -> None:
        self.asked = True
        self.asked_at = min(self.asked_at, time.monotonic())
        self.end()


def run(
    makers: Sequence[Callable[[], ManagedNode]], args: list[str] | None = None, bus: Bus | None = None
) -> int:
    """Makes the nodes and runs them.

    Args:
        makers: One per node.
        args: What follows the executable's name.
        bus: What connects the nodes.

    Returns:
        Exit status: 0 after a signal or a regular end, 2 for an unusable parameter or a name that is taken,
        else the status of the node that ended first.
    """
    die_with_parent()
    stop = StopSignal()
    nodes: list[ManagedNode] = []
    try:
        words = sys.argv[1:] if args is None else args
        _no_options(split_ros_args(words)[0])
        start_ros(words)
        for make in makers:
            nodes.append(make())
            nodes[-1].when_over = stop.end
        with _claim(nodes):
            return _spin(nodes, stop, bus)
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION
    finally:
        for node in nodes:
            cast(Any, node).destroy_node()
        try_shutdown()


def _no_options(words: list[str]) -> None:
    """A node has parameters and no options but `--help`.

    Raises:
        ConfigurationError: There are others.
    """
    Parser(
        prog=Path(sys.argv[0]).stem,
        description="A node of the follower's graph, which starts itself unless `autostart` is false.",
        epilog="After --ros-args: -p NAME:=VALUE, --params-file FILE, -r OLD:=NEW. `ros2 param list` names "
        "the parameters while it runs.",
        allow_abbrev=False,
    ).parse_args(words)


def _claim(nodes: list[ManagedNode]) -> Claim:
    """The nodes' names, unless a bringup has claimed them."""
    node = cast(Any, nodes[0])
    mine = [] if PARENT in os.environ else [cast(Any, n).get_name() for n in nodes if n.only_one]
    return Claim(node.context.get_domain_id(), node.get_namespace().strip("/"), mine)


def start_ros(args: list[str] | None) -> None:
    """Starts rclpy and leaves the signals to us.

    Raises:
        ConfigurationError: What follows `--ros-args` cannot be used.
    """
    choose_network(asked_to_be_open())
    try:
        with quiet_stderr():
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has no common type for what it finds wrong here
        given = " ".join(sys.argv[1:] if args is None else args)
        reason = re.sub(r", at \S+", "", " ".join(str(error).split()))
        raise ConfigurationError(f"{given}: {reason}") from None


def _spin(nodes: list[ManagedNode], stop: StopSignal, bus: Bus | None) -> int:
    executor = EventsExecutor()
    for node in nodes:
        executor.add_node(node)
    if bus is not None:
        stop.also = bus.call
    gc.freeze()  # what exists now stays: collections need not look at it again
    ended: ManagedNode | None = None
    try:
        while ended is None and not stop.asked and ok():
            if bus is None:
                _attend(executor, nodes[0], stop)
            else:
                _share_time(executor, bus, stop)
            ended = next((node for node in nodes if node.exit_status is not None), None)
        _wind_down(executor, nodes, bus)
        for node in nodes:
            node.finish()
        _flush(nodes)  # bringup knows by now that it is over, and wakes a recorder that was halted
        _linger(executor, stop, ended is not None and PARENT in os.environ)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
    # What goes wrong at the very end, such as closing a bag, counts too.
    failed = next((node for node in nodes if node.exit_status), None)
    last = ended if ended is not None and ended.exit_status else failed
    if last is None or last.exit_status is None:
        return 0
    if last.exit_status == BAD_CONFIGURATION:
        print(last.exit_reason, file=sys.stderr)
    return last.exit_status


def _attend(executor: Any, node: ManagedNode, stop: StopSignal) -> None:
    """Turns between the messages that the node fetches itself and all else."""
    until = time.monotonic() + (_TURN if node.hears_people else _LONG_TURN)
    attended = False
    while (left := until - time.monotonic()) > 0.0 and not stop.over and node.attend(left):
        attended = True
    if not stop.over:
        executor.spin_until_future_complete(stop.future(), timeout_sec=0.0 if attended else node.rest())


def _share_time(executor: Any, bus: Bus, stop: StopSignal) -> None:
    """Turns between the nodes' steps and what arrives from outside: messages, services, timers."""
    if bus.work(_TURN):
        executor.spin_until_future_complete(Future(), timeout_sec=0.0)
    elif not stop.over:
        executor.spin_until_future_complete(bus.future(), timeout_sec=REST)


def _wind_down(executor: Any, nodes: list[ManagedNode], bus: Bus | None) -> None:
    """Lets everyone finish what has arrived, so that a run ends with the same last messages every time."""
    for node in nodes:
        node.wind_down()
    deadline = time.monotonic() + _LONGEST_WIND_DOWN
    done = -1
    while time.monotonic() < deadline and done != sum(node.steps for node in nodes):
        done = sum(node.steps for node in nodes)
        while bus is not None and bus.work(_TURN):
            pass
        until = time.monotonic() + _LAST_WORD
        while bus is None and (left := until - time.monotonic()) > 0.0 and nodes[0].attend(left):
            pass
        executor.spin_until_future_complete(Future(), timeout_sec=max(0.0, until - time.monotonic()))


def _flush(nodes: list[ManagedNode]) -> None:
    """Sends what others had no room for, as long as they take any of it."""
    left, since = sum(node.flush() for node in nodes), time.monotonic()
    while left and time.monotonic() < since + _NOT_TAKEN:
        time.sleep(0.001)
        before, left = left, sum(node.flush() for node in nodes)
        if left < before:
            since = time.monotonic()


def _linger(executor: Any, stop: StopSignal, await_dismissal: bool) -> None:
    """Stays until the last messages have arrived: a writer that is gone takes them with it.

    `wait_for_all_acked` is no help: readers acknowledge at the next heartbeat, seconds later. A
    bringup that has heard the last word says so by its signal.
    """
    deadline = time.monotonic() + (_DISMISSAL if await_dismissal else _LAST_WORD)
    while time.monotonic() < deadline and not (await_dismissal and stop.asked):
        executor.spin_until_future_complete(Future(), timeout_sec=0.02)


def die_with_parent() -> None:
    """Asks the kernel for SIGTERM when the bringup that started this process is gone."""
    parent = os.environ.get(PARENT)
    if parent is None:
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):  # it went before we could ask
        sys.exit(1)
