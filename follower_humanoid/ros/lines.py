"""Direct lines between the processes that one bringup forks: pairs of sockets that they are born with.

What a node publishes in a tick reaches the nodes of its own graph this way (see `envelope`) without threads
of the middleware on either side, which would cost more than most nodes' work. Nobody else can reach
these sockets, they need no name, and nothing is left of them when a process dies. Who is not born in
the same bringup hears the same bytes from the topics.
"""

from __future__ import annotations

import errno
import select
import socket
from collections import deque
from collections.abc import Collection, Iterable
from contextlib import suppress

from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.lockstep import hears_clock
from follower_humanoid.graph.wiring import PRODUCER, SIMULATOR, nodes_with
from follower_humanoid.ros.parcel import Parcel

# Messages that wait for one who does not listen; the system itself keeps 13 to 26 more. As many
# as on a topic; for the recorder four seconds of the fastest: a disk may hesitate that long.
DEPTH, RECORDER_DEPTH = 1000, 2000
LARGEST = 1 << 17  # bytes of one message
_LONGEST_WORD = 64  # bytes of what a hearer says
# Room for one message of any size, once: to ask for new memory of that size costs more than the message.
_ARRIVED = memoryview(bytearray(LARGEST))
_GONE = (errno.EPIPE, errno.ECONNRESET, errno.ENOTCONN)
_NO_ROOM = (errno.EAGAIN, errno.ENOBUFS, errno.ENOMEM)


class Mouth:
    """Where one process sends to another; never waits for it.

    Attributes:
        open: False once the other one is gone.
        lost: Messages that the other one will never get, since it did not listen for too long.
    """

    def __init__(self, end: socket.socket, depth: int = DEPTH) -> None:
        """Args: its end of the pair, and how many messages wait."""
        end.setblocking(False)
        self._end = end
        self._late: deque[bytes] = deque(maxlen=depth)
        self._word = b""
        self.open = True
        self.lost = 0

    def send(self, data: bytes) -> None:
        """Sends a message, or keeps it for later where the other one does not listen now.

        Raises:
            ValueError: Too large; the other one could not take it in.
        """
        if len(data) > LARGEST:
            raise ValueError(f"a message of {len(data)} bytes: valid: up to {LARGEST}")
        if self._late:
            self.flush()
        if self.open and (self._late or not self._push(data)):
            self.lost += len(self._late) == self._late.maxlen
            self._late.append(data)

    def heard_back(self) -> bytes:
        """What the other one has said last, see `Ear.say`; empty where it has said nothing."""
        with suppress(OSError):  # nothing there, or nobody
            while self.open and (word := self._end.recv(_LONGEST_WORD)):
                self._word = word
        return self._word

    def flush(self) -> int:
        """Sends what was kept, as far as it goes; returns how many messages are left."""
        while self._late and self._push(self._late[0]):
            if self._late:  # unless the other one is gone
                self._late.popleft()
        return len(self._late)

    def _push(self, data: bytes) -> bool:
        """False where there is no room; who is gone misses nothing."""
        try:
            self._end.send(data)
        except OSError as error:
            if error.errno in _NO_ROOM:
                return False
            if error.errno not in _GONE:
                raise
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
        if self.open:
            self._poll.poll(1e3 * seconds)

    def take(self) -> bytes | None:
        """The next message; None where there is none now."""
        if not self.open:
            return None
        try:
            size = self._end.recv_into(_ARRIVED)
        except BlockingIOError:
            return None
        except ConnectionError:
            size = 0
        if not size:
            self.close()
            return None
        return _ARRIVED[:size].tobytes()

    def say(self, word: bytes) -> None:
        """Says something to the one who is heard: how much of it is wanted, say. It need not listen."""
        with suppress(OSError):
            self._end.send(word)

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

    def __init__(self) -> None:
        """None yet."""
        self.mouths: dict[tuple[str, str], Mouth] = {}
        self.ears: dict[tuple[str, str], Ear] = {}
        self._parcels: dict[Mouth, Parcel] = {}

    def lay(self, pairs: Iterable[tuple[str, str]], composed: bool = False) -> None:
        """Lays them, for every process that is forked from now on.

        Args:
            pairs: Who sends to whom.
            composed: Whether all who send share one process, and so one line to each who hears.
        """
        laid: dict[tuple[str, str], tuple[Mouth, Ear]] = {}
        for pair in pairs:
            line = ("", pair[1]) if composed else pair
            if line not in laid:
                sending, hearing = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
                depth = RECORDER_DEPTH if pair[1] == RECORDER else DEPTH
                laid[line] = Mouth(sending, depth), Ear(hearing)
            self.mouths[pair], self.ears[pair] = laid[line]

    def keep(self, names: Collection[str]) -> None:
        """Lets go of all ends but those of the given nodes: only so does a hearer learn of an end."""
        for pair in [pair for pair in self.mouths if pair[0] not in names]:
            self.mouths.pop(pair).close()
        for pair in [pair for pair in self.ears if pair[1] not in names]:
            self.ears.pop(pair).close()

    def mouths_of(self, name: str) -> dict[str, Mouth]:
        """Whom a node can reach, and where."""
        return {hearer: mouth for (sender, hearer), mouth in self.mouths.items() if sender == name}

    def parcel_of(self, name: str) -> Parcel | None:
        """What goes to the recorder from a node and those that share its line; None without a recorder."""
        mouth = self.mouths.get((name, RECORDER))
        if mouth is None:
            return None
        if mouth not in self._parcels:
            alone = sum(other is mouth for other in self.mouths.values()) == 1
            self._parcels[mouth] = Parcel(mouth.send, alone)
        return self._parcels[mouth]

    def ear_of(self, name: str, sender: str) -> Ear | None:
        """Where a node hears another; None where it does not."""
        ear = self.ears.get((sender, name))
        return ear if ear is not None and ear.open else None

    def hear_only(self, name: str, senders: Collection[str]) -> None:
        """Closes the ears of a node for all others: nobody keeps messages for who will not listen."""
        heard = [self.ears[pair] for pair in self.ears if pair[1] == name and pair[0] in senders]
        for pair, ear in self.ears.items():
            if pair[1] == name and ear not in heard:
                ear.close()


BORN_WITH = Lines()
"""The lines of this process: none where bringup did not fork it."""


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
