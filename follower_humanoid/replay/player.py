"""Sends the messages of a bag when they are due."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.replay.events import CLOCK, CLOCK_TYPE, Event, events, with_clock
from follower_humanoid.replay.index import BagIndex
from follower_humanoid.replay.pace import Pace

CLOCK_RATE = 100.0


@dataclass(frozen=True)
class PlayOptions:
    """What is played and how.

    Attributes:
        bag: Folder or file.
        rate: Recorded seconds per wall second.
        loop: Again and again.
        topics: Names of topics, none for all.
        without: Names of topics that are left out.
        start: Begin that long after the first message [s].
        start_option: What the command calls that.
        duration: Play that much of the recorded time [s]; None for all.
        paused: Begin with a pause.
        clock: Rate of the clock made where the bag has none [Hz]; 0: none.
        clock_always: Play the bag's own clock with any choice of topics.
    """

    bag: Path
    rate: float = 1.0
    loop: bool = False
    topics: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    start: float = 0.0
    start_option: str = "--start"
    duration: float | None = None
    paused: bool = False
    clock: float = CLOCK_RATE
    clock_always: bool = True


class Player:
    """One playback.

    Attributes:
        topics: Full names of what is played, without a clock made here.
        clocks: Names of the bag's own clocks.
        pace: Pauses, resumes and stops it.
        sent: Messages so far.
    """

    def __init__(self, index: BagIndex, options: PlayOptions, playable: Iterable[str]) -> None:
        """Args: the bag, the options, and the topics whose type is known here.

        Raises:
            ConfigurationError: A topic that is not in the bag, a start behind its end, or nothing to play
                from there on.
        """
        if options.start > 0.0 and options.start >= index.duration:
            raise ConfigurationError(
                f"{options.start_option} {options.start:g}: "
                f"bag {index.path} ends after {index.duration:.3f} s"
            )
        self._index, self._options = index, options
        chosen = index.chosen(options.topics)
        if options.without:
            chosen -= index.chosen(options.without)
        known = frozenset(playable)
        chosen &= known
        clocks = {name for name, topic in index.topics.items() if topic.type_name == CLOCK_TYPE}
        self.clocks = frozenset(clocks)
        # Whoever follows the clock needs it with any choice of topics.
        also = self.clocks if options.clock_always else frozenset()
        self.topics = chosen | (also & known)
        if not chosen:
            raise ConfigurationError(f"bag {index.path} holds nothing that can be played here")
        self._span = self._begin_and_end()
        self._refuse_silence(chosen)
        self.pace = Pace(options.rate, options.paused)
        self.sent = 0

    @property
    def makes_clock(self) -> bool:
        """Whether `/clock` is made here."""
        return not self.clocks and self._options.clock > 0.0

    def run(self, send: Callable[[str, bytes], None]) -> None:
        """Plays to the end or until stopped.

        Args:
            send: Takes the full name of a topic and a serialized message.
        """
        begin, _ = self._span
        while not self.pace.stopped:
            begun = False
            for time, topic, data in self._events():
                if not begun:  # not before the first chunk is unpacked
                    begun = True
                    self.pace.begin(begin)
                if not self.pace.wait_for(time):
                    return
                send(topic, data)
                self.sent += 1
            if not self._options.loop:
                return

    def _begin_and_end(self) -> tuple[int, float]:
        """The recorded time that is played, since the epoch [ns]."""
        length = self._options.duration
        begin = self._index.begin + round(self._options.start * 1e9)
        return begin, math.inf if length is None else begin + round(length * 1e9)

    def _refuse_silence(self, chosen: frozenset[str]) -> None:
        """Refuses what plays nothing: a loop would read the bag for ever without a pause.

        The clocks that go with any choice of topics do not count: alone they are nothing to play.

        Raises:
            ConfigurationError: No message of the chosen topics is in the time that is played.
        """
        index, options = self._index, self._options
        filled = frozenset(name for name, topic in index.topics.items() if topic.count)
        near = self._silence_near(chosen, filled) if chosen & filled else ""
        if near is None:
            return
        asked = f"{options.start_option} {options.start:g}: " if options.start > 0.0 else ""
        raise ConfigurationError(f"{asked}bag {index.path} holds no {', '.join(sorted(chosen))}{near}")

    def _silence_near(self, chosen: frozenset[str], filled: frozenset[str]) -> str | None:
        """Where the nearest message of the chosen topics is, if none is played; None if one is."""
        (begin, end), first = self._span, self._index.begin
        if end == math.inf and (begin == first or filled <= chosen):  # the last one at least: no need to look
            return None
        near = ""
        for event in events(self._index, chosen):
            if begin <= event.time <= end:
                return None
            after = f"{(event.time - first) / 1e9:.3f} s"
            if event.time > end:
                return f" until {after}, after the {self._options.duration:g} s to play"
            near = f" after {after}"
        return near

    def _events(self) -> Iterator[Event]:
        begin, end = self._span
        found: Iterable[Event] = events(self._index, self.topics, begin)
        if self.makes_clock:
            found = with_clock(found, round(1e9 / self._options.clock))
        for event in found:
            if event.time > end:
                return
            yield event

    def made_topics(self) -> dict[str, str]:
        """Name → type of what is sent besides the bag's own topics."""
        return {CLOCK: CLOCK_TYPE} if self.makes_clock else {}
