"""Which messages a node waits for at each tick, free of ROS.

A node steps at tick t once the message of exactly `used_tick(t, topic)` is there for every input:
never the latest one, so a run is the same bit for bit however its nodes are placed and timed.
An output that was not published at a tick is announced as absent and counts as a message.

A topic whose own node was left out comes from a stranger. If the stranger keeps the grid of
ticks it is waited for like any other; if not (a joystick, the command line), its newest message
is held and nobody waits. After `STALE` of simulated time without another one it is absent: nobody
walks on by a word from long ago.

A node of ours that was left behind may leave for a while: it says which tick is the first without it,
and from there on nobody waits for what it publishes. With its next message it is back.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import cast

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.lockstep_input import Input
from follower_humanoid.graph.wiring import (
    PRODUCER,
    SIMULATOR,
    NodeWiring,
    is_optional,
    is_same_tick,
    last_period,
)

CLOCK = "clock"
STALE = 0.5  # simulated time for which a stranger's newest message is held [s]
_FAR_AHEAD = 100  # ticks; no lock-stepped stranger runs that far ahead
_FURTHEST = 2500  # ticks that a node may fall behind in real time and still catch up


@dataclass(frozen=True)
class Missing:
    """A message that a node waits for."""

    topic: str
    tick: int
    producer: str

    def __str__(self) -> str:
        return f"{self.topic} of tick {self.tick} from {self.producer}"


def hears_clock(node: NodeWiring, present: Collection[str]) -> bool:
    """Whether the clock paces a node, since none of the nodes that run does."""
    return node.name != SIMULATOR and all(
        PRODUCER[topic].name not in present for topic in node.inputs.values()
    )


class LockStep:
    """The inputs of one node, tick by tick.

    Attributes:
        tick: The tick of the next step.
        late: Messages that came when their tick was over or already there; a node that steps at every
            tick has none.
        strange: Messages of ticks so far ahead that no node of the graph can have come to them.
        stale: Inputs that were absent because what was held of a stranger had become too old.
    """

    def __init__(
        self,
        node: NodeWiring,
        present: Collection[str],
        topics: Collection[str] = (),
        hold: int = 250,
    ) -> None:
        """Starts at tick 0.

        Args:
            node: Whose inputs.
            present: Nodes that run; what others would publish comes from strangers.
            topics: The inputs to wait for; all of the node's if empty. A node without inputs is
                paced by the clock, and so is one that hears strangers only: they may not pace it.
            hold: Ticks for which a stranger's message is held, see `STALE`.
        """
        self.tick = 0
        self.late = self.strange = 0
        self.stale = 0
        self._hold_for = hold
        self._period = node.period
        self._origin = 0
        names = dict.fromkeys(topics or node.inputs.values())
        self._inputs = {name: self._input(name, present) for name in names}
        if hears_clock(node, present):
            self._inputs[CLOCK] = Input((CLOCK,), SIMULATOR, 1, at_once=True, foreign=False, once=True)
        self._entries = list(self._inputs.values())
        self._some_held = any(entry.held for entry in self._entries)
        self._await()

    def put_together(self, topics: Sequence[str]) -> None:
        """These will come in one piece: `put` takes a tuple of their samples, under the first of them.

        To be said before the first message. They are used at the same tick, and come from a node of ours.
        """
        first = self._inputs[topics[0]]
        first.topics = tuple(topics)
        for topic in topics[1:]:
            other = self._inputs[topic]
            if (other.producer, other.at_once, other.foreign) != (first.producer, first.at_once, False):
                raise ConfigurationError(f"{topic} does not come in one piece with {topics[0]}")
            self._entries.remove(other)
            self._inputs[topic] = first
        self._count_missing()

    def _input(self, topic: str, present: Collection[str]) -> Input:
        producer, at_once = PRODUCER[topic], is_same_tick(topic)
        foreign = producer.name not in present
        once = not foreign and (at_once or producer.period <= self._period)
        made = Input((topic,), producer.name, producer.period, at_once, foreign, once)
        made.held = foreign and is_optional(topic)
        return made

    @property
    def topics(self) -> tuple[str, ...]:
        """What is waited for."""
        return tuple(self._inputs)

    @property
    def ready(self) -> bool:
        """Whether the step of `tick` can be taken."""
        return self._missing == 0

    @property
    def paced(self) -> bool:
        """False where nobody is waited for, since all that is heard is held."""
        return not self._some_held or not all(entry.held for entry in self._entries)

    def missing(self) -> list[Missing]:
        """What the step of `tick` still needs."""
        return [
            Missing(topic, entry.awaited, entry.producer)
            for entry in self._entries
            if entry.missing and entry.awaited is not None
            for topic in entry.topics
        ]

    def waits_for(self, topic: str) -> bool:
        """Whether the step of `tick` still needs a message."""
        return self._missing > 0 and self._inputs[topic].missing

    def needs(self, topic: str, tick: int) -> bool:
        """Whether a message can be used by this or a later step; false where it may be dropped unread."""
        entry = self._inputs[topic]
        return entry.foreign or entry.awaited is None or tick >= entry.awaited

    def put(self, topic: str, tick: int | None, sample: object) -> bool:
        """Takes a message in.

        Args:
            topic: Where it came.
            tick: Its tick, None where the stamp is not on the grid of ticks.
            sample: Its content; None for "not published at this tick". See `put_together`.

        Returns:
            True where it made the step of `tick` possible.
        """
        entry = self._inputs[topic]
        if tick is not None and tick == entry.awaited and entry.missing and not entry.foreign:
            entry.samples[tick] = sample
            self._missing -= 1
            return self._missing == 0
        on_grid = tick is not None and tick % entry.period == 0
        if entry.held and sample is None:
            return False  # nobody waits for it
        if entry.foreign and sample is not None:
            floor = 0 if entry.awaited is None else entry.awaited
            furthest = max(floor, self._origin) + _FAR_AHEAD
            if on_grid and tick is not None and not entry.held and floor - self._period < tick < floor:
                entry.newest = sample  # of a tick between two steps of ours: on time, though never used
                return False
            if entry.held or not on_grid or tick is None or not floor <= tick <= furthest:
                return self._hold(entry, sample)
        elif tick is None or not on_grid:
            self.late += 1
            return False
        floor = entry.begins if entry.awaited is None else max(entry.awaited, entry.begins)
        if tick in entry.samples or tick < floor:
            self.late += 1
            return False
        if entry.left is not None:
            return self._come_back(entry, tick, sample)
        if tick > max(floor, self._origin) + _FURTHEST:  # after a reset nothing of before is awaited
            self.strange += 1
            return False
        entry.samples[tick] = sample
        if tick != entry.awaited:
            return False
        self._missing -= 1
        return self._missing == 0

    def take(self) -> dict[str, object]:
        """The inputs of the step of `tick`; moves on to the next one."""
        held_from = self.tick - self._hold_for
        values: dict[str, object] = {}
        for entry in self._entries:
            value = entry.take(held_from)
            if value is None:
                if entry.held and entry.newest is not None:
                    self.stale += 1
                values.update(dict.fromkeys(entry.topics))
            elif len(entry.topics) == 1:
                values[entry.topics[0]] = value
            else:
                values.update(zip(entry.topics, cast("tuple[object, ...]", value), strict=True))
        self.tick += self._period
        self._await()
        return values

    def give_up(self) -> list[Missing]:
        """Stops waiting for strangers who do not answer; motor commands are waited for all the same."""
        given_up = []
        for entry in self._entries:
            if entry.foreign and not entry.at_once and entry.missing and entry.awaited is not None:
                given_up.append(Missing(entry.topics[0], entry.awaited, entry.producer))
                self._hold(entry, entry.newest)
        return given_up

    def _come_back(self, entry: Input, tick: int, sample: object) -> bool:
        """A message from a node that has left: of before that, or the first of those to come."""
        entry.samples[tick] = sample
        if entry.left is not None and tick >= entry.left:
            entry.begins, entry.left = tick, None
        return self._count_missing()

    def leave(self, producer: str, tick: int) -> bool:
        """A node publishes nothing from a tick on; returns whether the step of `tick` is possible now."""
        for entry in self._entries:
            if entry.producer == producer and not entry.foreign and tick >= entry.begins:
                entry.left = tick
        return self._count_missing()

    def give_up_on(self, topics: Collection[str]) -> list[Missing]:
        """Goes on without what is missing of these topics until their nodes have caught up."""
        given_up = [missing for missing in self.missing() if missing.topic in topics]
        for missing in given_up:
            self._inputs[missing.topic].left = missing.tick
        self._count_missing()
        return given_up

    def restart(self, tick: int) -> None:
        """Forgets everything from before a tick: what was computed earlier is absent from now on."""
        self._origin = tick
        self.tick = -(-tick // self._period) * self._period
        for entry in self._entries:
            entry.newest = None
        self._await()

    def _hold(self, entry: Input, sample: object) -> bool:
        was_missing = entry.missing
        entry.held, entry.held_since, entry.newest = True, self.tick, sample
        self._some_held = True
        entry.samples.clear()
        return was_missing and self._count_missing()

    def _await(self) -> None:
        """Works out what the step of `tick` needs and forgets what no step needs any more."""
        tick, missing = self.tick, 0
        for entry in self._entries:
            used = tick if entry.at_once else last_period(tick, entry.period)
            if used < self._origin:
                entry.awaited = None
                continue
            if used != entry.awaited:
                entry.awaited = used
                if entry.samples:
                    entry.forget(used)
            if used not in entry.samples and entry.missing:
                missing += 1
        self._missing = missing

    def _count_missing(self) -> bool:
        """Counts what the step of `tick` still needs; true where that is nothing."""
        self._missing = sum(entry.missing for entry in self._entries)
        return self._missing == 0
