"""Reads a recorded run, whole or cut off, into the form that measuring and drawing work on."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from follower_humanoid.bag.cdr import CdrError, Cursor, decode_batch
from follower_humanoid.bag.layouts import IRREGULAR, WALKS
from follower_humanoid.bag.mcap_file import McapFile, Message, bag_files
from follower_humanoid.bag.parameter_events import parameter_event
from follower_humanoid.bag.recorder import ADJUSTED, HOLDING
from follower_humanoid.bag.writer import ABOUT_METADATA, URDF_ATTACHMENT
from follower_humanoid.core import samples
from follower_humanoid.core.cdr import LARGEST_STAMP, NANOSECONDS
from follower_humanoid.core.samples import Array
from follower_humanoid.core.topics import TOPICS, Topic
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Adjusted, Holding, Integers, Run, Series

_NEEDED = ("joint_states", "odom")
# Slack of a person's stamp against the time it was received at before it is taken for a foreign clock.
_STAMP_SLACK = NANOSECONDS


@dataclass
class _Collected:
    """What one topic has gathered so far, in pieces of a chunk each."""

    topic: Topic
    received: list[Integers] = field(default_factory=list)
    stamps: list[Integers] = field(default_factory=list)
    numbers: list[dict[str, Array]] = field(default_factory=list)
    frames: list[str] = field(default_factory=list)
    names: tuple[str, ...] = ()
    samples: list[Any] = field(default_factory=list)
    broken: int = 0


def read_run(bag: Path, namespace: str | None = None) -> Run:
    """The run recorded in a bag folder or .mcap file.

    Args:
        bag: Where it is.
        namespace: Of the robot; None: the only one in the bag.

    Raises:
        ConfigurationError: Nothing readable there, or no follower in it.
    """
    files = [McapFile(path) for path in bag_files(bag)]
    collected: dict[str, _Collected] = {}
    changes: dict[str, list[bytes]] = {ADJUSTED: [], HOLDING: []}
    prefix = None if namespace is None else f"/{namespace.strip('/')}/".replace("//", "/")
    for file in files:
        for messages in file.chunks():
            if prefix is None:
                prefix = _only_prefix(file, bag)
            _collect(file, messages, prefix, collected, changes)
    found = sorted({channel.topic for file in files for channel in file.channels.values()})
    for name in _NEEDED:
        if name not in collected:
            listed = ", ".join(found) or "nothing"
            raise ConfigurationError(f"bag {bag} holds no {name} of a follower; it holds {listed}")
        if not collected[name].stamps:
            raise ConfigurationError(f"bag {bag}: none of its {collected[name].broken} {name} can be decoded")
    notes = [note for file in files for note in file.notes]
    try:
        return _run(files, collected, changes, notes)
    except ConfigurationError as error:
        raise ConfigurationError(f"bag {bag}: {error}") from None


def _only_prefix(file: McapFile, bag: Path) -> str | None:
    topics = {channel.topic for channel in file.channels.values()}
    prefixes = sorted(
        topic.removesuffix("joint_states")
        for topic in topics
        if topic.endswith("/joint_states") and topic.removesuffix("joint_states") + "odom" in topics
    )
    if len(prefixes) > 1:
        listed = ", ".join(prefix.strip("/") or "/" for prefix in prefixes)
        raise ConfigurationError(f"bag {bag} holds several robots; choose a namespace: {listed}")
    return prefixes[0] if prefixes else None


def _collect(
    file: McapFile,
    messages: list[Message],
    prefix: str | None,
    collected: dict[str, _Collected],
    changes: dict[str, list[bytes]],
) -> None:
    if prefix is None:
        return
    by_channel: dict[int, list[Message]] = {}
    for message in messages:
        by_channel.setdefault(message.channel, []).append(message)
    for channel, group in by_channel.items():
        info = file.channels.get(channel)
        if info is None or not info.topic.startswith(prefix):
            continue
        name = info.topic.removeprefix(prefix)
        if name in TOPICS:
            _decode(collected.setdefault(name, _Collected(TOPICS[name])), group)
        elif name in changes:
            changes[name] += [message.data for message in group]


def _decode(into: _Collected, messages: list[Message]) -> None:
    if into.topic.kind in IRREGULAR:
        _decode_irregular(into, messages)
        return
    datas = [message.data for message in messages]
    received = np.array([message.received for message in messages], dtype=np.int64)
    batches = decode_batch(datas, WALKS[into.topic.kind])
    into.broken += len(messages) - sum(len(batch.rows) for batch in batches)
    for batch in batches:
        frame, *rest = batch.words
        names = rest[0] if rest else ()
        numbers = batch.numbers
        if into.topic.kind in (samples.Joints, samples.Gait, samples.ContactPlan):
            if not names or (into.topic.kind is samples.Gait and "walk_dir" not in names):
                into.broken += len(batch.rows)  # nothing in it has a meaning
                continue
            into.names = into.names or names
            numbers = _in_order(numbers, names, into.names)
        into.received.append(received[batch.rows])
        into.stamps.append(batch.stamps)
        into.numbers.append(numbers)
        into.frames += [frame[0]] * len(batch.rows)


def _in_order(numbers: dict[str, Array], names: tuple[str, ...], wanted: tuple[str, ...]) -> dict[str, Array]:
    """Columns in the order of `wanted`; NaN where a message leaves a name or a field out."""
    column = {name: index for index, name in enumerate(names)}
    ordered = {}
    for field_name, values in numbers.items():
        whole = np.full((len(values), len(wanted)), np.nan)
        if values.shape[1] == len(names):
            for target, name in enumerate(wanted):
                if name in column:
                    whole[:, target] = values[:, column[name]]
        ordered[field_name] = values if names == wanted and values.shape[1] == len(names) else whole
    return ordered


def _decode_irregular(into: _Collected, messages: list[Message]) -> None:
    decode = IRREGULAR[into.topic.kind]
    received, stamps = [], []
    for message in messages:
        try:
            stamp, sample = decode(Cursor(message.data))
        except CdrError:
            into.broken += 1
            continue
        if stamp is None:  # an empty array of markers carries no stamp
            continue
        received.append(message.received)
        stamps.append(stamp)
        into.samples.append(sample)
    into.received.append(np.array(received, dtype=np.int64))
    into.stamps.append(np.array(stamps, dtype=np.int64))


def _run(
    files: Sequence[McapFile],
    collected: dict[str, _Collected],
    changes: dict[str, list[bytes]],
    notes: list[str],
) -> Run:
    attachments = {name: data for file in files for name, data in file.attachments.items()}
    about = {name: data.decode("utf-8", errors="replace") for name, data in attachments.items()}
    urdf = about.pop(URDF_ATTACHMENT, "")
    for file in files:
        about.update(file.metadata.get(ABOUT_METADATA, {}))
    joints = collected["joint_states"]
    stamps = np.concatenate(joints.stamps)
    received = np.concatenate(joints.received)
    tick_ns = _tick(about, stamps)
    series = {}
    for name, entry in collected.items():
        if entry.broken:
            notes.append(f"{name}: {entry.broken} messages cannot be decoded and are left out")
        if entry.stamps:
            made = _series(entry, tick_ns, received, stamps)
            if len(made):
                series[name] = made
    states = series["joint_states"].ticks
    missing = int(states[-1] - states[0] + 1 - len(states))
    if missing:
        notes.append(f"joint_states: {missing} of {states[-1] - states[0] + 1} ticks are missing")
    adjusted = _changes(ADJUSTED, _adjusted, changes, tick_ns, notes)
    holding = _changes(HOLDING, _holding, changes, tick_ns, notes)
    return Run(tick_ns / NANOSECONDS, joints.names, urdf, series, about, tuple(notes), adjusted, holding)


def _adjusted(cursor: Cursor, tick_ns: int) -> Adjusted:
    stamp, node, values = parameter_event(cursor)
    return Adjusted(round(stamp / tick_ns), node, values)


def _holding(cursor: Cursor, tick_ns: int) -> Holding:
    stamp, topics = cursor.header()
    return Holding(round(stamp / tick_ns), tuple(name for name in topics.split(",") if name))


Change = TypeVar("Change", Adjusted, Holding)


def _changes(
    topic: str,
    decode: Callable[[Cursor, int], Change],
    changes: dict[str, list[bytes]],
    tick_ns: int,
    notes: list[str],
) -> tuple[Change, ...]:
    """What happened during the run, in the order of time."""
    found: list[Change] = []
    for data in changes[topic]:
        try:
            found.append(decode(Cursor(data), tick_ns))
        except CdrError as error:
            notes.append(f"{topic}: a message cannot be decoded and is left out: {error}")
    return tuple(sorted(found, key=lambda change: change.tick))


def _tick(about: dict[str, str], stamps: Integers) -> int:
    """Control tick [ns]: as recorded, else the commonest distance of two joint states."""
    if "tick" in about:
        return _recorded_tick(about["tick"])
    distances = Counter(np.diff(np.unique(stamps)).tolist())
    if not distances:
        raise ConfigurationError("it holds a single joint state: too little to tell the control tick")
    return int(distances.most_common(1)[0][0])


def _recorded_tick(text: str) -> int:
    """A control tick [ns] as it is recorded, in [s]."""
    try:
        tick = float(text) * NANOSECONDS
    except ValueError:
        tick = math.nan
    if not 0.5 < tick <= LARGEST_STAMP:  # so that it rounds to 1 ns at least
        raise ConfigurationError(f"control tick {text[:40]!r}: needs seconds, 1e-9 to 2e9")
    return round(tick)


def _series(entry: _Collected, tick_ns: int, state_received: Integers, state_stamps: Integers) -> Series:
    received = np.concatenate(entry.received)
    stamps = np.concatenate(entry.stamps)
    if not entry.topic.everybody and entry.topic.name.partition("/")[2] != "applied":
        stamps = _person_stamps(stamps, received, state_received, state_stamps)
    order = np.argsort(stamps, kind="stable")
    # A message that was delivered twice is one sample.
    order = order[np.diff(stamps[order], prepend=stamps[order[:1]] - 1) != 0]
    stamps = stamps[order]
    ticks = np.rint(stamps / tick_ns).astype(np.int64)
    if entry.topic.kind in IRREGULAR:
        return Series(entry.topic, ticks, stamps, samples=tuple(entry.samples[i] for i in order))
    fields = {
        name: np.concatenate([piece[name] for piece in entry.numbers])[order]
        for name in entry.numbers[0]
        if not name.endswith("covariance")
    }
    if entry.topic.kind in (samples.Gait, samples.ContactPlan):
        fields = {name: fields["position"][:, column] for column, name in enumerate(entry.names)}
        if entry.topic.kind is samples.Gait and "heading" not in fields:
            fields["heading"] = fields["walk_dir"]
    texts = {"frame": tuple(entry.frames[i] for i in order)} if entry.topic.kind is samples.Wrench else {}
    return Series(entry.topic, ticks, stamps, fields, texts)


def _person_stamps(
    stamps: Integers, received: Integers, state_received: Integers, state_stamps: Integers
) -> Integers:
    """What people publish counts from when it came: a stamp of another clock gives way to the run's own."""
    order = np.argsort(state_received, kind="stable")
    arrived = np.interp(received, state_received[order], state_stamps[order]).astype(np.int64)
    foreign = np.abs(stamps - arrived) > _STAMP_SLACK
    return np.where(foreign, arrived, stamps)
