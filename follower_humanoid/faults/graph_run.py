"""A graph that is started to be disturbed, and what is left of it afterwards."""

from __future__ import annotations

import math
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from follower_humanoid.bag.mcap_file import McapFile, Message, bag_files
from follower_humanoid.bag.reader import read_run
from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.resources import node_command
from follower_humanoid.ros.director import reports_in

PATIENCE = 600.0  # wall time for anything that takes seconds on a free machine [s]
_HELD = ("legs_held_ticks", "arms_held_ticks")
_LAST_WORDS = 600  # characters
_TIME = re.compile(r"^t = ([0-9.]+) s", re.MULTILINE)


def own_domain() -> int:
    """A ROS domain that nobody else uses: the one of the environment, or a random one."""
    return int(os.environ.get("ROS_DOMAIN_ID") or random.randint(1, 100))


def wait_until(condition: Callable[[], bool], patience: float = PATIENCE) -> bool:
    """Whether the condition came true in time."""
    end = time.monotonic() + patience
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


@dataclass
class GraphRun:
    """A running bringup.

    Attributes:
        process: Its process.
        folder: Where it writes.
        environment: Of everything that shall talk to it.
    """

    process: subprocess.Popen[bytes]
    folder: Path
    environment: Mapping[str, str]

    @property
    def bag(self) -> Path:
        """Folder of the bag."""
        return self.folder / "bag"

    @property
    def said(self) -> str:
        """What it has printed, to stdout and to stderr."""
        return (self.folder / "out.txt").read_text(encoding="utf-8", errors="replace")

    @property
    def last_words(self) -> str:
        """The end of what it has printed, on one line."""
        return " | ".join(self.said.split("\n"))[-_LAST_WORDS:].strip(" |")

    @property
    def time(self) -> float:
        """Simulated time as the status line tells [s]; −1 before there is one."""
        times = _TIME.findall(self.said)
        return float(times[-1]) if times else -1.0

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self.process.poll() is not None

    def reaches(self, simulated: float) -> bool:
        """Waits until simulated time has come to a point [s]; false where it ended or stands still."""
        return wait_until(lambda: self.over or self.time >= simulated) and not self.over

    def children(self) -> dict[int, str]:
        """Process id → command line of all that it has started, and that is still there."""
        mark = f"follower_humanoid_{self.process.pid}_"  # the folder with their parameters
        found = {}
        for entry in Path("/proc").iterdir():
            try:
                words = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            except (OSError, UnicodeDecodeError):  # no process, or gone meanwhile
                continue
            if entry.name.isdigit() and mark in words:
                found[int(entry.name)] = words
        return found

    def child(self, node: str) -> int | None:
        """Process id of a node; None where it is not there."""
        return next((pid for pid, words in self.children().items() if f"/{node} " in f"{words} "), None)

    def send(self, node: str, number: int) -> bool:
        """Sends a node a signal; returns whether it was there."""
        pid = self.child(node)
        if pid is not None:
            os.kill(pid, number)
        return pid is not None

    def halt(self, node: str, seconds: float) -> bool:
        """Halts a node for a while [s]; returns whether it was there."""
        there = self.send(node, signal.SIGSTOP)
        time.sleep(seconds)
        return there and self.send(node, signal.SIGCONT)

    def end(self, number: int = signal.SIGTERM) -> float:
        """Sends a signal; returns how long the end took [s]."""
        begin = time.monotonic()
        self.process.send_signal(number)
        self.status()
        return time.monotonic() - begin

    def status(self) -> int:
        """Exit status, once it has ended."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            return -1

    def orphans(self) -> int:
        """Processes that outlive it."""
        wait_until(lambda: not self.children(), 5.0)
        return len(self.children())

    def recorded(self) -> Run | None:
        """The bag; None where it cannot be read."""
        try:
            return read_run(self.bag)
        except ConfigurationError:
            return None

    def operate(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Has an operator do something, see `faults.operator`."""
        command = [sys.executable, "-m", "follower_humanoid.faults.operator", *words]
        return subprocess.run(
            command, env=self.environment, capture_output=True, text=True, timeout=PATIENCE, check=False
        )

    def recorded_messages(self, topic: str) -> Iterator[Message]:
        """The messages of a topic in the bag; none where it cannot be read."""
        try:
            for path in bag_files(self.bag):
                file = McapFile(path)
                for messages in file.chunks():
                    yield from (m for m in messages if file.channels[m.channel].topic == topic)
        except ConfigurationError:
            return

    def longest_pause(self) -> float:
        """Longest wall time between two states, as recorded [s]."""
        times = [message.received for message in self.recorded_messages("/joint_states")]
        return max((after - before for before, after in pairwise(times)), default=math.inf) / NANOSECONDS

    def held_ticks(self) -> int:
        """For how many ticks the motor drives held, as the simulator said on `/diagnostics`."""
        reports = [reports_in(message.data, "/") for message in self.recorded_messages("/diagnostics")]
        held = [report[SIMULATOR] for report in reports if SIMULATOR in report]
        return sum(int(held[-1][key]) for key in _HELD) if held else 0


@contextmanager
def graph_run(*options: str, domain: int | None = None, prefix: Sequence[str] = ()) -> Iterator[GraphRun]:
    """Starts a bringup with these options and a bag; at the end nothing of it is left.

    Args:
        options: Of bringup.
        domain: ROS domain; an own one by default.
        prefix: Command that runs it, such as `ip netns exec HOST`.
    """
    environment = {**os.environ, "ROS_DOMAIN_ID": str(own_domain() if domain is None else domain)}
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        with (folder / "out.txt").open("wb") as out:
            words = [*prefix, *node_command("bringup"), "--bag", str(folder / "bag"), *options]
            process = subprocess.Popen(
                words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out
            )
        run = GraphRun(process, folder, environment)
        try:
            yield run
        finally:
            if not run.over:
                process.kill()
                process.wait()
            for pid in run.children():
                with_luck(pid)


def with_luck(pid: int) -> None:
    """Ends a process that may be gone already."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return
