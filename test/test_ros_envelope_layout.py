"""Envelopes written and read in one piece are those of the codecs, message by message."""

from __future__ import annotations

import dataclasses
import struct

import numpy as np
import pytest
from test_ros_codecs import ROBOT, sample_of

from follower_humanoid.core.topics import TOPICS
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.envelope import Envelope
from follower_humanoid.ros.envelope_reader import EnvelopeReader
from follower_humanoid.ros.envelope_writer import EnvelopeWriter
from follower_humanoid.ros.validation import MessageError

pytestmark = pytest.mark.filterwarnings("ignore:overflow")

CODECS = {topic: Codec(topic, ROBOT) for topic in TOPICS}
STAMP = 987_654_000_000


def samples_of(node, rng, absent=0.2):
    return {
        topic: None if rng.random() < absent else sample_of(TOPICS[topic], rng)
        for topic in node.outputs.values()
    }


def by_codecs(node, samples, stamp=STAMP):
    messages = [b"" if s is None else CODECS[topic].encode(s, stamp) for topic, s in samples.items()]
    return Envelope(node).seal(stamp, messages)


def topics_of(node):
    return [topic for topic in node.outputs.values() if CODECS[topic].read_layout is not None]


def reader(node):
    """Of all that is ever read by the fast way."""
    return EnvelopeReader(Envelope(node), {topic: CODECS[topic] for topic in topics_of(node)})


def same(one, other):
    if one is None or other is None:
        return one is other
    if not dataclasses.is_dataclass(one):
        return np.array_equal(one, other)
    return type(one) is type(other) and all(
        same(getattr(one, field.name), getattr(other, field.name)) for field in dataclasses.fields(one)
    )


@pytest.mark.parametrize("name", NODES)
def test_written_in_one_piece_it_is_the_same_bytes(name):
    node, rng = NODES[name], np.random.default_rng(3)
    writer = EnvelopeWriter(Envelope(node), CODECS)
    for tick in range(200):
        samples, stamp = samples_of(node, rng), STAMP + tick
        data, places = writer.seal(samples, stamp)
        assert data == by_codecs(node, samples, stamp)
        for topic, sample in samples.items():
            assert (topic in places) == (sample is not None)
            if sample is not None:
                assert data[places[topic]] == CODECS[topic].encode(sample, stamp)


def test_numbers_of_any_kind_and_order_in_memory_are_written_as_doubles():
    node, rng = NODES["leg_controller"], np.random.default_rng(4)
    (topic, sample), *_ = samples_of(node, rng, absent=0.0).items()
    n = len(sample.effort)
    odd = dataclasses.replace(sample, position=np.arange(n), velocity=np.arange(2.0 * n)[::2])
    data, places = EnvelopeWriter(Envelope(node), CODECS).seal({topic: odd}, STAMP)
    assert data[places[topic]] == CODECS[topic].encode(odd, STAMP)


@pytest.mark.parametrize("more", [0, 1])  # as many numbers in all, or one less
def test_an_array_of_a_wrong_length_is_never_sent(more):
    node, rng = NODES["leg_controller"], np.random.default_rng(4)
    (topic, sample), *_ = samples_of(node, rng, absent=0.0).items()
    velocity = np.concatenate((sample.velocity, np.zeros(more)))
    wrong = dataclasses.replace(sample, velocity=velocity, effort=sample.effort[1:])
    with pytest.raises(ValueError, match="numbers in place of"):
        EnvelopeWriter(Envelope(node), CODECS).seal({topic: wrong}, STAMP)


@pytest.mark.parametrize("name", NODES)
def test_read_in_one_look_it_is_the_same_samples(name):
    node, rng = NODES[name], np.random.default_rng(5)
    read = reader(node)
    for _ in range(100):
        samples = samples_of(node, rng)
        for topic, sample in zip(topics_of(node), read.read(by_codecs(node, samples)), strict=True):
            sent = samples[topic]
            assert same(sample, None if sent is None else CODECS[topic].decode(CODECS[topic].encode(sent, 0)))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["simulator", "zmp_balance"])
def test_a_number_that_is_not_finite_is_refused_wherever_it_stands(name, bad):
    node, rng = NODES[name], np.random.default_rng(7)
    read, samples = reader(node), samples_of(node, rng, absent=0.0)
    data = by_codecs(node, samples)
    read.read(data)
    (plan,) = read._plans.values()
    for first, count in plan._runs:
        for at in range(first, first + count, 8):
            broken = data[:at] + struct.pack("<d", bad) + data[at + 8 :]
            with pytest.raises(MessageError, match="not finite"):
                read.read(broken)


def test_a_stranger_s_order_of_joints_is_read_by_the_codec():
    node, topic = NODES["simulator"], "joint_states"
    samples = samples_of(node, np.random.default_rng(1), absent=0.0)
    messages = {t: CODECS[t].encode(s, STAMP) for t, s in samples.items()}
    swapped = messages[topic].replace(b"l_knee", b"??????").replace(b"r_knee", b"l_knee")
    messages[topic] = swapped.replace(b"??????", b"r_knee")
    found = reader(node).read(Envelope(node).seal(STAMP, list(messages.values())))
    read = dict(zip(topics_of(node), found, strict=True))[topic]
    assert not same(read, samples[topic])
    assert same(read, CODECS[topic].decode(messages[topic]))


def test_lengths_that_are_not_there_are_refused_before_anything_is_made():
    node = NODES["simulator"]
    data = bytearray(by_codecs(node, samples_of(node, np.random.default_rng(2))))
    table = Envelope(node).contents - 4 * len(node.outputs)
    data[table : table + 4] = b"\xff\xff\xff\xff"
    with pytest.raises(MessageError, match="cut short"):
        reader(node).read(bytes(data))


@pytest.mark.parametrize("seed", range(3))
def test_cut_short_it_is_refused_although_its_lengths_are_known(seed):
    node, rng = NODES["simulator"], np.random.default_rng(seed)
    read, data = reader(node), by_codecs(node, samples_of(node, rng, absent=0.0))
    read.read(data)
    for length in rng.integers(read.envelope.contents, len(data), 20):
        with pytest.raises(MessageError, match="graph/simulator"):
            read.read(data[:length])
