"""What goes into an envelope comes out of it, byte for byte, and ROS 2 can read it as what it says it is."""

from __future__ import annotations

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from std_msgs.msg import UInt8MultiArray

from follower_humanoid.graph.wiring import NODES, used_tick
from follower_humanoid.ros.envelope import Envelope, hears_slow
from follower_humanoid.ros.outlet import _used_by_slow_nodes
from follower_humanoid.ros.validation import MessageError

NODE = NODES["simulator"]
STAMP = 123_456_789_012_345


def messages(rng):
    """One per topic, of any length."""
    return [
        rng.bytes(int(length)) for length in rng.integers(0, 3000, len(NODE.outputs)) * rng.integers(0, 2)
    ]


@pytest.mark.parametrize("seed", range(5))
def test_round_trip(seed):
    sent = messages(np.random.default_rng(seed))
    sent[seed] = b""
    assert Envelope(NODE).open(Envelope(NODE).seal(STAMP, sent)) == (STAMP, sent)


def test_it_is_a_standard_message():
    data = Envelope(NODE).seal(STAMP, messages(np.random.default_rng(0)))
    message = deserialize_message(data, UInt8MultiArray)
    assert message.layout.dim == []
    assert bytes(message.data) == data[16:]
    assert int.from_bytes(bytes(message.data[:8]), "little") == STAMP


@pytest.mark.parametrize("length", [0, 4, 20, 60, -1])
def test_what_is_cut_short_is_refused(length):
    data = Envelope(NODE).seal(STAMP, [b"abc"] * len(NODE.outputs))
    with pytest.raises(MessageError, match="graph/simulator"):
        Envelope(NODE).open(data[:length])


@pytest.mark.parametrize("at", [1, 4, 8, 12, 24])
def test_lengths_that_do_not_agree_are_refused(at):
    data = bytearray(Envelope(NODE).seal(STAMP, [b"abcd"] * len(NODE.outputs)))
    data[at] ^= 2
    with pytest.raises(MessageError, match="graph/simulator"):
        Envelope(NODE).open(bytes(data))


def test_topics_stand_in_the_order_of_the_wiring():
    assert Envelope(NODE).topics == tuple(NODE.outputs.values())


@pytest.mark.parametrize("name", NODES)
def test_slow_nodes_get_every_tick_that_they_use_and_few_others(name):
    producer = NODES[name]
    ticks = set(_used_by_slow_nodes(producer, NODES.values()))
    sent = {tick for tick in range(0, 100) if any((tick + lag) % period == 0 for lag, period in ticks)}
    for reader in NODES.values():
        if not hears_slow(reader, producer):
            continue
        for topic in set(reader.inputs.values()) & set(producer.outputs.values()):
            used = {used_tick(tick, topic) for tick in range(0, 100, reader.period)}
            assert {tick for tick in used if tick >= 0} <= sent
    assert len(sent) <= 20
