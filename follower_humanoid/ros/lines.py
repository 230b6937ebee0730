"""Direct lines between the processes that one bringup forks: pairs of sockets that they are born with.

What a node publishes in a tick reaches the nodes of its own graph this way (see `envelope`) without threads
of the middleware on either side, which would cost more than most nodes' work. Nobody else can reach
these sockets, they need no name, and nothing is left of them when a process dies. Who is not born in
the same bringup hears the same bytes from the topics.
"""

from __future__ import annotations

import select
import socket
from collections import deque
from collections.abc import Collection, Iterable

from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.lockstep import hears_clock
from follower_humanoid.graph.wiring import PRODUCER, SIMULATOR, nodes_with

_DEPTH = 1000  # as deep as the queues of the topics
_LARGEST = 1 << 17  # bytes of one message
_HANGS_UP = select.POLLHUP | select.POLLERR | select.POLLNVAL


class Mouth:
    """Where one process sends to another; never waits for it.

    Attributes:
        open: False once the other one is gone.
    """

    def __init__(self, end: socket.socket) -> None:
        """Args: its end of the pair."""
        end.setblocking(False)
        self._end = end
        self._late: deque[bytes] = deque(maxlen=_DEPTH)
        self.open = True

    def send(self, data: bytes) -> None:
        """Sends a message, or keeps it for later where the other one does not listen now."""
        if self._late:
            self._late.append(data)
            self.flush()
        elif self.open and not self._push(data):
            self._late.append(data)

    def flush(self) -> bool:
        """Sends what was kept, as far as it goes; returns whether any of it is left."""
        while self._late and self._push(self._late[0]):
            if self._late:  # unless the other one is gone
                self._late.popleft()
        return bool(self._late)

    def _push(self, data: bytes) -> bool:
        try:
            self._end.send(data)
        except BlockingIOError:
            return False
        except OSError:  # the process is gone: bringup looks after that
            self.close()
        return True

    def close(self) -> None:
        """Sends no more."""
        self.open = False
        self._late.clear()
        self._end.close()


class Ear:
    """Where one process hears another.

    Attributes:
        open: False once the other one is gone.
    """

    def __init__(self, end: socket.socket) -> None:
        """Args: its end of the pair."""
        end.setblocking(False)
        self._end = end
        self._poll = select.poll()
        self._poll.register(end, select.POLLIN)
        self.open = True

    def wait(self, seconds: float) -> None:
        """Sleeps until there is a message, or the other one is gone."""
        self._poll.poll(1e3 * seconds)

    def take(self) -> bytes | None:
        """The next message; None where there is none now."""
        try:
            data = self._end.recv(_LARGEST)
        except BlockingIOError:
            return None
        except OSError:
            data = b""
        if not data:
            self.close()
            return None
        return data

    def close(self) -> None:
        """Hears no more."""
        if self.open:
            self.open = False
            self._poll.unregister(self._end)
            self._end.close()


class Lines:
    """The lines of one graph, as one process has them.

    Attributes:
        mouths, ears: By the nodes at both ends: who sends, who hears.
    """

    def __init__(self, pairs: Iterable[tuple[str, str]] = ()) -> None:
        """Lays them. Args: who sends to whom, by names of nodes."""
        self.mouths: dict[tuple[str, str], Mouth] = {}
        self.ears: dict[tuple[str, str], Ear] = {}
        for pair in pairs:
            sending, hearing = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            self.mouths[pair], self.ears[pair] = Mouth(sending), Ear(hearing)

    def keep(self, names: Collection[str]) -> None:
        """Lets go of all ends but those of the given nodes: only so does a hearer learn of an end."""
        for pair in [pair for pair in self.mouths if pair[0] not in names]:
            self.mouths.pop(pair).close()
        for pair in [pair for pair in self.ears if pair[1] not in names]:
            self.ears.pop(pair).close()

    def hearers_of(self, name: str) -> dict[str, Mouth]:
        """Whom a node can reach, and where."""
        return {hearer: mouth for (sender, hearer), mouth in self.mouths.items() if sender == name}


def line_pairs(nodes: Collection[str], composed: bool, recorded: bool) -> list[tuple[str, str]]:
    """Who sends to whom from process to process.

    Args:
        nodes: That run; who makes what is used at the same tick is served first.
        composed: Whether they share one process.
        recorded: Whether there is a recorder, which hears everyone.
    """
    table, pairs = nodes_with(nodes), []
    for hearer in sorted(nodes, key=lambda name: not table[name].same_tick):
        senders = {PRODUCER[topic].name for topic in table[hearer].inputs.values()}
        if hears_clock(table[hearer], nodes):
            senders.add(SIMULATOR)
        pairs += [(sender, hearer) for sender in nodes if sender in senders and not composed]
    return pairs + [(sender, RECORDER) for sender in nodes if recorded]


class _Birth:
    lines = Lines()


def lay(pairs: Iterable[tuple[str, str]]) -> Lines:
    """Lays the lines that every process forked from now on is born with."""
    _Birth.lines = Lines(pairs)
    return _Birth.lines


def born_with() -> Lines:
    """The lines of this process: none where bringup did not fork it."""
    return _Birth.lines
