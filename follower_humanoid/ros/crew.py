"""The processes that bringup starts: none is left behind, whatever happens."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from follower_humanoid.resources import node_command
from follower_humanoid.ros.courtesy import give_way
from follower_humanoid.ros.forked import Forked, Gate
from follower_humanoid.ros.lines import BORN_WITH
from follower_humanoid.ros.spin import PARENT, die_with_parent
from follower_humanoid.ros.type_support import load_type_support

_LONGEST_WRITING = 20.0  # wall time that a busy writer of a bag gets beyond the end [s]
_LONGEST_ASIDE = 1.0  # wall time that who only looks on gets when all others have ended [s]
_BUSY = 0.5  # wall time in which it must get anything done [s]


@dataclass(frozen=True)
class Member:
    """One process.

    Attributes:
        name: Executable.
        nodes: Nodes in it.
        process: The running process.
        vital: False where the run goes on without it.
    """

    name: str
    nodes: tuple[str, ...]
    process: subprocess.Popen[bytes] | Forked
    vital: bool = True


class Crew:
    """Starts, watches and ends processes."""

    def __init__(self) -> None:
        """Nobody yet."""
        # Who starts bringup may have it ignored: then nobody could say how a process ended.
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        self.members: list[Member] = []
        self._environment = {PARENT: str(os.getpid())}
        self._gate = Gate()

    def fork(
        self,
        name: str,
        args: Sequence[str],
        nodes: tuple[str, ...],
        aside: bool = False,
        prepare: Callable[[], object] = lambda: None,
    ) -> None:
        """Starts one executable of the package with all that is imported already; it waits for `begin`.

        Args:
            name: Of the executable.
            args: Its arguments.
            nodes: Nodes in it.
            aside: It only looks on: the run goes on without it, and whoever works goes first.
            prepare: What it does before it waits.
        """
        main = importlib.import_module(f"follower_humanoid.nodes.{name}").main
        load_type_support()
        gc.freeze()  # pages that no collection touches stay shared
        command = [*node_command(name), *args]

        def live() -> int:
            BORN_WITH.keep(nodes)
            give_way(nodes, aside)
            return int(main(list(args)))

        def get_ready() -> None:
            die_with_parent()  # before a compilation, which may take a minute
            prepare()

        process = Forked(command, live, self._environment, self._gate, get_ready)
        self.members.append(Member(name, nodes, process, vital=not aside))

    @property
    def prepared(self) -> bool:
        """Whether all wait for `begin`, but for onlookers that will not come."""
        gone = sum(m.process.poll() is not None for m in self.members if not m.vital)
        return self._gate.missing <= gone

    def begin(self) -> None:
        """Lets the forked ones go on."""
        self._gate.open()

    def ended(self) -> Member | None:
        """The first member whose process is over, of those that the run needs."""
        return next((m for m in self.members if m.vital and m.process.poll() is not None), None)

    def stop(self, deadline: Callable[[], float], idle: Callable[[float], None], last: str = "") -> None:
        """Ends everyone: politely, then for good.

        Args:
            deadline: On the monotonic clock [s]; asked again and again, since a signal may shorten it.
            idle: Passes the given time [s] while waiting.
            last: Ends after all others, so that it hears their last words.
        """
        begin = time.monotonic()
        for member in self.members:  # one that was halted keeps the last words of all others waiting
            member.process.send_signal(signal.SIGCONT)
        # Who only looks on gets less of a processor to end on: it is asked like all, but not waited for long.
        vital = [m for m in self.members if m.vital]
        self._ask([m for m in self.members if m.name != last])
        self._wait([m for m in vital if m.name != last], lambda: 0.5 * (begin + deadline()), idle)
        self._ask([m for m in vital if m.name == last])
        self._wait(vital, deadline, idle)
        # Where the machine is so busy that a bag is not written by then, it is waited for: as long as its
        # writer gets anything done at all.
        for member in self.members:
            if member.name == last:
                self._wait_while_busy(member, idle)
        ended = time.monotonic()
        self._wait(self.members, lambda: min(deadline(), ended + _LONGEST_ASIDE), idle)
        self.kill()

    def kill(self) -> None:
        """Ends whoever is left, at once."""
        self._gate.close()
        for member in self.members:
            if member.process.poll() is None:
                member.process.kill()
                member.process.wait()

    @staticmethod
    def _wait_while_busy(member: Member, idle: Callable[[float], None]) -> None:
        begin = time.monotonic()
        done: tuple[str, ...] | None = None
        while member.process.poll() is None and time.monotonic() < begin + _LONGEST_WRITING:
            before, done = done, _work_of(member.process.pid)
            if done is not None and done == before:
                return
            until = time.monotonic() + _BUSY
            while time.monotonic() < until and member.process.poll() is None:
                idle(0.02)

    @staticmethod
    def _ask(members: Sequence[Member]) -> None:
        for member in members:
            if member.process.poll() is None:
                member.process.send_signal(signal.SIGTERM)
                # One that was halted could not obey.
                member.process.send_signal(signal.SIGCONT)

    @staticmethod
    def _wait(
        members: Sequence[Member], deadline: Callable[[], float], idle: Callable[[float], None]
    ) -> None:
        while time.monotonic() < deadline() and any(m.process.poll() is None for m in members):
            idle(0.02)


def _work_of(pid: int) -> tuple[str, ...] | None:
    """Grows while a process gets anything done; None while it waits for a processor or for a disk.

    Its CPU time, and how often its main thread has gone to sleep or was sent there: on a crowded machine it
    gets less than a clock tick of CPU time in a while.
    """
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    except OSError:  # gone
        return ()
    switches = [line for line in lines if "ctxt_switches" in line]
    return None if fields[0] in "RD" else (fields[11], fields[12], *switches)


def how_it_ended(status: int) -> str:
    """A process's end in words."""
    if status >= 0:
        return f"ended with status {status}"
    try:
        return f"killed by {signal.Signals(-status).name}"
    except ValueError:
        return f"killed by signal {-status}"
