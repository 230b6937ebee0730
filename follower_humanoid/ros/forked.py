"""A process that begins where this one is: what has been imported need not be imported again.

Nothing of ROS may be running in this process yet: threads do not survive a fork.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

import setproctitle

_POLL = 0.01


class Gate:
    """Holds forked processes back until all is prepared for them."""

    def __init__(self) -> None:
        """Closed."""
        self._reading, self._writing = os.pipe()
        self._arrivals, self._arriving = os.pipe()
        os.set_blocking(self._arrivals, False)
        self._expected = self._missing = 0

    def expect(self) -> None:
        """One more will wait."""
        self._expected += 1
        self._missing += 1

    def approach(self) -> None:
        """In the forked process, on its way: from here on the gate is its parent's alone."""
        os.close(self._writing)
        os.close(self._arrivals)

    def wait(self) -> bool:
        """In the forked process, at the gate: whether it may go on; False where the other one has gone."""
        with suppress(BrokenPipeError):
            os.write(self._arriving, b".")
        os.close(self._arriving)
        may = bool(os.read(self._reading, 1))
        os.close(self._reading)
        return may

    @property
    def missing(self) -> int:
        """How many have not come yet."""
        if self._arrivals >= 0:
            with suppress(BlockingIOError):
                self._missing -= len(os.read(self._arrivals, self._expected))
        return self._missing

    def open(self) -> None:
        """Lets them go on, those too who come later."""
        os.write(self._writing, b"." * self._expected)
        self.close()

    def close(self) -> None:
        """Ends the wait; who has not passed goes home."""
        for end in (self._reading, self._writing, self._arrivals, self._arriving):
            if end >= 0:
                os.close(end)
        self._reading = self._writing = self._arrivals = self._arriving = -1


class Forked:
    """A process as `subprocess.Popen` has it: `pid`, `returncode`, `poll`, `wait`, `kill`, `send_signal`.

    It has a process group of its own, no input, and drops what it prints to stdout.
    """

    def __init__(
        self,
        command: Sequence[str],
        main: Callable[[], int],
        environment: Mapping[str, str],
        gate: Gate,
        prepare: Callable[[], None],
    ) -> None:
        """Forks.

        Args:
            command: What `ps -f` shows.
            main: What it does; returns the exit status.
            environment: Its environment.
            gate: It waits there first.
            prepare: What it does before it waits.
        """
        self.returncode: int | None = None
        gate.expect()
        sys.stdout.flush()
        sys.stderr.flush()
        self.pid = os.fork()
        if self.pid == 0:
            _live(command, main, environment, gate, prepare)

    def poll(self) -> int | None:
        """The exit status, negative for a signal; None while it runs."""
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode

    def wait(self) -> int:
        """Until it is over."""
        while (status := self.poll()) is None:
            time.sleep(_POLL)
        return status

    def send_signal(self, number: int) -> None:
        """To the running process."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """At once."""
        self.send_signal(signal.SIGKILL)


def _live(
    command: Sequence[str],
    main: Callable[[], int],
    environment: Mapping[str, str],
    gate: Gate,
    prepare: Callable[[], None],
) -> None:
    """The forked process's whole life: nothing of its parent's unfinished work is done by it."""
    status = 1
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        # Ctrl-C is bringup's alone. A session would do that too, but the kernel shares the CPU out by
        # sessions: nodes that hand one another the tick would interrupt each other at every message.
        os.setpgid(0, 0)
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1):
            os.dup2(nowhere, stream)
        os.close(nowhere)
        setproctitle.setproctitle(" ".join(command))
        os.environ.update(environment)
        gate.approach()
        prepare()
        status = main() if gate.wait() else 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException:  # whatever it is: the user must see it, and this process must not go on
        traceback.print_exc()
    # All is done, and the interpreter takes our handlers away some time before it ends: whoever is dismissed
    # then has ended well all the same.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    # As at the end of any Python program, and unlike `os._exit`: the middleware gives its shared memory back.
    ctypes.pythonapi.Py_Exit(status)
