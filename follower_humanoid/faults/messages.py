"""Random and mutated messages, given to every decoder, and to the intake of people's wrenches."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from follower_humanoid.bench.check import Check
from follower_humanoid.core.topics import PEOPLE, TOPICS
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.mutations import damaged_bytes
from follower_humanoid.graph.graph_config import RunConfig
from follower_humanoid.graph.record import samples_of
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope
from follower_humanoid.ros.people import PeopleWrench
from follower_humanoid.ros.quiet import quiet_stderr
from follower_humanoid.ros.validation import MessageError

_TICKS = 20
TICK_NS = 2_000_000
_NUMBERS = (float("nan"), float("inf"), -float("inf"), 1e300, -1e300, 5e-324)


@cache
def whole_messages() -> dict[str, tuple[Codec, list[bytes]]]:
    """Topic → its codec, and messages of a run of some ticks."""
    run, robot = simulate("fig4", _TICKS * 0.002), RobotModel()
    found = {}
    for name in run.series:
        codec = Codec(name, robot)
        sent = [codec.encode(sample, tick * TICK_NS) for tick, sample in samples_of(run[name]).items()]
        found[name] = (codec, sent)
    return found


def hostile_message(whole: bytes, rng: random.Random) -> bytes:
    """Rubbish, a damaged message, or one with a number in it that is none or too large."""
    kind = rng.randrange(4)
    if kind == 0:
        return rng.randbytes(rng.randint(0, 200))
    if kind == 1:
        return whole[:4] + rng.randbytes(rng.randint(0, len(whole)))
    if kind == 2:
        return damaged_bytes(whole, rng)
    data = bytearray(whole)
    if len(data) > 28:
        at = 4 + 8 * rng.randrange((len(data) - 12) // 8)
        data[at : at + 8] = np.float64(rng.choice(_NUMBERS)).tobytes()
    return bytes(data)


def hostile_messages(effort: Effort) -> Iterator[Check]:
    """A line for internal topics, for envelopes and for what people publish."""
    count = effort.count(300, 100_000)
    topics = [topic for topic in whole_messages() if topic not in PEOPLE]
    with quiet_stderr():  # the deserialiser has a line of its own for each
        lines = [_summed("messages on internal topics", topics, count), _envelopes(count)]
        lines += [_from_people(topic, count) for topic in sorted(PEOPLE)]
    yield from lines


def _summed(what: str, topics: list[str], count: int) -> Check:
    rejected, findings = 0, []
    for topic in topics:
        codec, sent = whole_messages()[topic]
        rng = random.Random(topic)
        for number in range(count):
            finding = decoded(codec, hostile_message(sent[number % len(sent)], rng))
            rejected += finding == ""
            if finding:
                findings.append(f"{topic}, message {number}: {finding}")
    total = count * len(topics)
    observed = f"{rejected} of {total} rejected, the others finite" + "".join(f"; {f}" for f in findings[:3])
    required = f"{count} on each of {len(topics)} topics: finite or rejected with a reason"
    return survived(what, required, observed, not findings)


def decoded(codec: Codec, data: bytes) -> str | None:
    """None where a usable sample came out, nothing where it was rejected, else what went wrong."""
    try:
        sample = codec.decode(data)
    except MessageError as error:
        return "" if codec.topic in str(error) else f"topic not named: {error}"
    except Exception as error:  # whatever else it is, it is a finding
        return f"{type(error).__name__}: {error}"
    return None if _is_finite(sample, codec.topic) else "not finite"


def _is_finite(sample: Any, topic: str) -> bool:
    optional = TOPICS[topic].joints in ("legs", "arms")  # commands may leave references out: nan
    for field in dataclasses.fields(sample):
        value = getattr(sample, field.name)
        left_out = optional and field.name != "effort"
        if isinstance(value, np.ndarray | float) and not left_out and not np.isfinite(value).all():
            return False
    return True


def _envelopes(count: int) -> Check:
    rejected, findings = 0, []
    for name, node in NODES.items():
        envelope, rng = Envelope(node), random.Random(name)
        parts = [
            whole_messages()[topic][1][0] if topic in whole_messages() else b"" for topic in envelope.topics
        ]
        whole = envelope.seal(0, parts)
        for number in range(count):
            try:
                envelope.open(hostile_message(whole, rng))
            except MessageError:
                rejected += 1
            except Exception as error:  # whatever else it is, it is a finding
                findings.append(f"{name}, envelope {number}: {type(error).__name__}: {error}")
    observed = f"{rejected} of {count * len(NODES)} rejected" + "".join(f"; {f}" for f in findings[:3])
    required = f"{count} from each of {len(NODES)} nodes: opened or rejected"
    return survived("envelopes between nodes", required, observed, not findings)


def _from_people(topic: str, count: int) -> Check:
    """Messages of strangers beside the built-in leader's, from several publishers, in bursts and silence."""
    codec, sent = whole_messages()[topic]
    robot, rng = RobotModel(), random.Random(topic)
    frames = {frame.name for frame in robot.pin_model.frames} | {"", "world"}
    rejections: list[str] = []
    person = PeopleWrench(
        codec, RunConfig(), TICK_NS, frames.__contains__, lambda _: None, lambda e: rejections.append(str(e))
    )
    now = 0.0
    person.now, person.publishers, person.lockstepped = lambda: now, lambda: 2, True
    findings = []
    for number in range(count):
        if number % 20 == 0:  # a burst, then at times silence
            now += rng.choice((0.002, 0.1, 2.0))
        whole = sent[number % len(sent)]
        try:
            if number % 3 == 0:
                person.note_leader(whole)
            person.receive(hostile_message(whole, rng))
            held = person.at(now)
        except Exception as error:  # whatever it is, it is a finding
            findings.append(f"message {number}: {type(error).__name__}: {error}")
            continue
        if held is not None and not (np.isfinite(held.force).all() and np.isfinite(held.torque).all()):
            findings.append(f"message {number}: a force that is no number")
    if person.at(now + 10.0) is not None:
        findings.append("still held after ten seconds of silence")
    observed = f"{len(rejections)} rejected, let go at the end" + "".join(f"; {f}" for f in findings[:3])
    required = f"{count} messages: finite force or rejected; silence lets go"
    return survived(f"messages on {topic}", required, observed, not findings)
