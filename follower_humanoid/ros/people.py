"""Wrenches that people send, beside or instead of the lock-stepped leader's.

Stamps are ignored, the newest message wins, silence lets go. Messages of the built-in leader arrive
here too, since everybody publishes on the same topics, and a subscription does not say who
published. The leader's envelope, which is nobody else's, holds a copy of each: what equals a copy byte
by byte is the leader's, everything else a person's, whatever its stamp. A person's wrench takes the
leader's place until let go.
"""

from __future__ import annotations

from collections.abc import Callable

from follower_humanoid.core.cdr import NANOSECONDS, stamp_of
from follower_humanoid.core.samples import Wrench
from follower_humanoid.graph.graph_config import LEADER, RunConfig
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.plant.grip import ZERO, Grip
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.validation import MessageError

_PERIOD = NODES[LEADER].period
_REMEMBERED = 1000  # copies: 10 s, more than a message can be late


class PeopleWrench:
    """One topic's wrench as people give it.

    Attributes:
        topic: Its name.
        lockstepped: True where the built-in leader publishes here too.
        now: Gives the simulated time [s].
        publishers: Gives the number of publishers.
    """

    def __init__(
        self,
        codec: Codec,
        config: RunConfig,
        tick_ns: int,
        knows_frame: Callable[[str], bool],
        warn: Callable[[str], None],
        reject: Callable[[Exception], None],
    ) -> None:
        """Args: codec, times, tick [ns], which frames exist, and where complaints go."""
        self.topic = codec.topic
        self._codec = codec
        self._tick_ns = tick_ns
        self._grip = Grip(config.people_timeout, config.people_release)
        self._knows_frame, self._warn, self._reject = knows_frame, warn, reject
        self.lockstepped = False
        self._leader: dict[int, bytes] = {}  # tick -> copy, in the order of ticks
        self._newest_copy = -1
        # Messages that may be the leader's, whose copy has not come yet: arrival number, tick, message.
        self._undecided: list[tuple[int, int, bytes]] = []
        self._arrivals = self._taken = 0
        self.now: Callable[[], float] = lambda: 0.0
        self.publishers: Callable[[], int] = lambda: 1

    def note_leader(self, data: bytes) -> None:
        """Remembers the copy of a leader's message."""
        tick = stamp_of(data) // self._tick_ns
        self._leader[tick] = data
        self._newest_copy = tick
        if len(self._leader) > _REMEMBERED:
            del self._leader[next(iter(self._leader))]
        if self._undecided:
            self._decide(tick)

    def receive(self, data: bytes) -> None:
        """Takes a message from anybody."""
        self._arrivals += 1
        if self.lockstepped:
            tick, rest = divmod(stamp_of(data), self._tick_ns)
            if rest == 0 and tick % _PERIOD == 0:
                if self._leader.get(tick) == data:
                    return
                if self._newest_copy < tick <= self._newest_copy + 2 * _PERIOD:
                    self._undecided.append((self._arrivals, tick, data))
                    return
        self._take(self._arrivals, data)

    def _decide(self, tick: int) -> None:
        """All copies up to `tick` have come: what equals none of them is a person's."""
        waiting, self._undecided = self._undecided, []
        for arrival, stamped, data in waiting:
            if stamped > tick:
                self._undecided.append((arrival, stamped, data))
            elif self._leader.get(stamped) != data:
                self._take(arrival, data)

    def _take(self, arrival: int, data: bytes) -> None:
        """A person's message."""
        try:
            wrench = self._codec.decode(data)
            if not self._knows_frame(wrench.frame):
                raise MessageError(self.topic, f"no frame '{wrench.frame}' in the robot, nor 'world'")
        except MessageError as error:
            self._reject(error)
            return
        if self.publishers() > 1:
            self._warn(f"several publishers of {self.topic}: the newest message wins")
        if arrival > self._taken:
            self._taken = arrival
            self._grip.receive(wrench, self.now())

    def at(self, time: float) -> Wrench | None:
        """What people do at a simulated time [s]; None when nobody holds on."""
        if self._undecided:  # the leader's copies of two periods ago are all here
            self._decide(round(time * NANOSECONDS) // self._tick_ns - 2 * _PERIOD)
        if not self._grip.received:
            return None
        wrench = self._grip.at(time)
        return None if wrench is ZERO else wrench
