"""Wrenches that people send, beside or instead of the lock-stepped leader's.

Stamps are ignored, the newest message wins, silence lets go. Messages of the built-in leader arrive
here too, since everybody publishes on the same topics; they are told apart by their bytes, because
a subscription does not say who published. A person's wrench takes the leader's place until let go.
"""

from __future__ import annotations

from collections.abc import Callable

from follower_humanoid.core.samples import Wrench
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.plant.grip import ZERO, Grip
from follower_humanoid.ros.codecs import Codec, stamp_of
from follower_humanoid.ros.graph_config import LEADER, RunConfig
from follower_humanoid.ros.validation import MessageError

_REMEMBERED = 20


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
        self._leader: dict[int, bytes] = {}
        self.now: Callable[[], float] = lambda: 0.0
        self.publishers: Callable[[], int] = lambda: 1

    def note_leader(self, data: bytes) -> None:
        """Remembers a message of the lock-stepped leader."""
        self._leader[stamp_of(data) // self._tick_ns] = data
        while len(self._leader) > _REMEMBERED:
            del self._leader[next(iter(self._leader))]

    def receive(self, data: bytes) -> None:
        """Takes a message from anybody."""
        several = self.publishers() > 1
        if self.lockstepped and (not several or self._is_leaders(data)):
            return
        try:
            wrench = self._codec.decode(data)
            if not self._knows_frame(wrench.frame):
                raise MessageError(self.topic, f"no frame '{wrench.frame}' in the robot, nor 'world'")
        except MessageError as error:
            self._reject(error)
            return
        if several:
            self._warn(f"several publishers of {self.topic}: the newest message wins")
        self._grip.receive(wrench, self.now())

    def _is_leaders(self, data: bytes) -> bool:
        tick = stamp_of(data) // self._tick_ns
        if tick in self._leader:
            return self._leader[tick] == data
        # The copy for the lock-step may come after this one, by a period of the leader at most.
        newest = max(self._leader, default=-1)
        return newest < tick <= newest + 2 * NODES[LEADER].period

    def at(self, time: float) -> Wrench | None:
        """What people do at a simulated time [s]; None when nobody holds on."""
        if not self._grip.received:
            return None
        wrench = self._grip.at(time)
        return None if wrench is ZERO else wrench
