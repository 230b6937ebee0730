"""A run held in memory: what flowed on every topic, stacked for measuring and drawing.

`simulate(...)` and the bag reader both end in a `Run`, so the same code measures and draws either.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core import samples
from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.core.samples import Array, Sample
from follower_humanoid.core.topics import TOPICS, Topic
from follower_humanoid.errors import ConfigurationError, UnknownNameError

Integers = NDArray[np.int64]

# Samples whose size changes from one to the next: kept as objects, never stacked.
_IRREGULAR = (samples.Polygon, samples.Footsteps, samples.PrimitiveStates)


@dataclass(frozen=True)
class Series:
    """Everything that was seen on one topic, in the order of time.

    A numeric field of the sample type is an attribute: `run["joint_states"].position` has shape
    (T, 45), `run["gait"].walk_speed` shape (T,).

    Attributes:
        topic: Name, kind of sample and frame.
        ticks: Control tick of each sample, shape (T,).
        stamps: Time of each sample, shape (T,) [ns].
        fields: Numeric field → stacked array, shape (T, ...).
        texts: Text field (`frame` of a wrench) → one word per sample.
        samples: The samples themselves where their size changes (polygons, footsteps, primitives).
    """

    topic: Topic
    ticks: Integers
    stamps: Integers
    fields: Mapping[str, Array] = field(default_factory=dict)
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    samples: tuple[Any, ...] = ()

    def __len__(self) -> int:
        return len(self.ticks)

    def __getattr__(self, name: str) -> Array:
        fields: Mapping[str, Array] = object.__getattribute__(self, "fields")
        if name in fields:
            return fields[name]
        raise AttributeError(
            f"{self.topic.name} has no field '{name}'; it has {', '.join(fields) or 'samples'}"
        )

    @property
    def times(self) -> Array:
        """Time of each sample, shape (T,) [s]."""
        return self.stamps / NANOSECONDS

    def latest(self, ticks: Integers) -> NDArray[np.intp]:
        """Index of the last sample at or before each tick; −1 where there was none yet."""
        return np.searchsorted(self.ticks, ticks, side="right") - 1

    def held(self, name: str, ticks: Integers) -> Array:
        """A field carried on to the given ticks, NaN before its first sample, shape (len(ticks), ...)."""
        values = self.fields[name]
        rows = self.latest(ticks)
        held = np.full((len(ticks), *values.shape[1:]), np.nan)
        held[rows >= 0] = values[rows[rows >= 0]]
        return held


@dataclass(frozen=True)
class Adjusted:
    """Parameters of a node that were changed while it ran.

    Attributes:
        tick: The first that used them.
        node: Its name.
        values: Dotted name → new value.
    """

    tick: int
    node: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Holding:
    """Motor commands that did not come in time, so that the drives held.

    Attributes:
        tick: The first without them.
        topics: Without which from then on; empty: all are there again.
    """

    tick: int
    topics: tuple[str, ...]


@dataclass(frozen=True)
class Run:
    """A whole run.

    Attributes:
        tick: Control tick [s].
        joint_names: Order of the joints of a whole-body sample.
        urdf: URDF text of the robot that ran.
        series: Topic → what was seen on it; topics nobody published are left out.
        about: What a repetition needs (parameters, programme, versions, seed), as texts.
        notes: What is missing or was repaired, one sentence each; empty for a whole run.
        adjusted: Parameters changed during the run, in the order of time.
        holding: When the motor drives held for want of commands, in the order of time.
    """

    tick: float
    joint_names: tuple[str, ...]
    urdf: str
    series: Mapping[str, Series]
    about: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    adjusted: tuple[Adjusted, ...] = ()
    holding: tuple[Holding, ...] = ()

    def __getitem__(self, topic: str) -> Series:
        if topic not in self.series:
            raise UnknownNameError("recorded topic", topic, self.series)
        return self.series[topic]

    def __contains__(self, topic: object) -> bool:
        return topic in self.series

    def __iter__(self) -> Iterator[str]:
        return iter(self.series)

    def __len__(self) -> int:
        return len(self.series)

    @property
    def duration(self) -> float:
        """Time of the last sample of any topic [s]."""
        return max((int(s.stamps[-1]) for s in self.series.values() if len(s)), default=0) / NANOSECONDS

    def joint_hash(self) -> str:
        """SHA-256 over all joint positions in order: equal only where two runs agree bit for bit."""
        return hashlib.sha256(self["joint_states"].position.astype("<f8").tobytes()).hexdigest()


class RunRecorder:
    """Collects samples while something runs; cheap enough for every topic of every tick.

    Samples are never written to once made, so holding them is enough: stacking waits for the end.
    """

    def __init__(
        self,
        tick: float,
        joint_names: tuple[str, ...],
        urdf: str,
        about: Mapping[str, str] | None = None,
    ) -> None:
        """Args: the control tick [s] and the metadata of `Run`."""
        self._tick = tick
        self._joint_names = joint_names
        self._urdf = urdf
        self._about = dict(about or {})
        # Topic → ticks and samples, in the order of time.
        self._kept: dict[str, tuple[list[int], list[Sample]]] = {name: ([], []) for name in TOPICS}
        self._adjusted: list[Adjusted] = []
        self._holding: list[Holding] = []

    def adjust(self, adjusted: Adjusted) -> None:
        """Keeps a change of parameters."""
        self._adjusted.append(adjusted)

    def hold(self, holding: Holding) -> None:
        """Keeps that the motor drives hold from a tick on, or no longer do."""
        self._holding.append(holding)

    def add(self, topic: str, tick: int, sample: Sample) -> None:
        """Keeps one sample; samples of a topic come in the order of their ticks.

        Raises:
            KeyError: No such topic.
        """
        ticks, samples = self._kept[topic]
        ticks.append(tick)
        samples.append(sample)

    def close(self) -> None:
        """Nothing more comes; a recorder that writes ends its file."""

    def finish(self, notes: tuple[str, ...] = ()) -> Run:
        """The run so far, stacked."""
        tick_ns = round(self._tick * NANOSECONDS)
        series = {}
        for name, (kept, collected) in self._kept.items():
            if collected:
                ticks = np.array(kept, dtype=np.int64)
                series[name] = stacked(TOPICS[name], ticks, ticks * tick_ns, collected)
        return Run(
            self._tick, self._joint_names, self._urdf, series, self._about, notes,
            tuple(self._adjusted), tuple(self._holding),
        )  # fmt: skip


def stacked(topic: Topic, ticks: Integers, stamps: Integers, collected: list[Any]) -> Series:
    """One topic's samples as a series.

    Args:
        topic: Where the samples come from.
        ticks, stamps: Of each sample, shape (T,), the stamps in [ns].
        collected: T samples of the topic's kind.

    Raises:
        ConfigurationError: Arrays of one field differ in size from sample to sample.
    """
    if topic.kind in _IRREGULAR:
        return Series(topic, ticks, stamps, samples=tuple(collected))
    fields: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    for entry in dataclasses.fields(topic.kind):
        column = [getattr(sample, entry.name) for sample in collected]
        if isinstance(column[0], str):
            texts[entry.name] = tuple(column)
            continue
        try:
            fields[entry.name] = np.array(column, dtype=np.float64)
        except ValueError:
            message = f"{topic.name}: the size of {entry.name} changes within the run"
            raise ConfigurationError(message) from None
    return Series(topic, ticks, stamps, fields, texts)


def samples_of(series: Series) -> dict[int, Any]:
    """Tick → sample of a series, as it was before it was recorded."""
    ticks = series.ticks.tolist()
    if series.samples:
        return dict(zip(ticks, series.samples, strict=True))
    names = [entry.name for entry in dataclasses.fields(series.topic.kind)]
    columns = [series.texts[name] if name in series.texts else series.fields[name] for name in names]
    kind = series.topic.kind
    return {tick: kind(*(_entry(column, row) for column in columns)) for row, tick in enumerate(ticks)}


def _entry(column: Any, row: int) -> Any:
    value = column[row]
    return float(value) if isinstance(value, np.floating) else value
