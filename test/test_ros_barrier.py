"""Who is waited for at the start and at a reset."""

from __future__ import annotations

import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros.barrier import RollCall, expected_readers, reset_known
from follower_humanoid.ros.qos import LOCKSTEP


class Listener:
    """A node of which only the subscription matters."""

    def __init__(self):
        self.rejected = []

    def create_subscription(self, kind, topic, callback, qos, raw):
        assert raw  # what is no String must not reach the middleware's own reader
        self.hears_bytes = callback
        self.hears = lambda text: callback(serialize_message(String(data=text)))


def roll_call(*present):
    node, complete = Listener(), []
    call = RollCall(node, present, lambda: complete.append(True), node.rejected.append)
    return call, node, complete


def test_a_run_begins_when_the_recorder_is_there_too():
    call, node, _ = roll_call("simulator", "leader", "recorder")
    assert call.waiting_for() == ["leader", "recorder"]
    node.hears("leader")
    node.hears("somebody")
    assert call.waiting_for() == ["recorder"]
    node.hears("recorder")
    assert call.waiting_for() == []


def test_a_reset_does_not_concern_the_recorder():
    call, node, complete = roll_call("simulator", "leader", "recorder")
    call.expect_reset(40)
    node.hears(reset_known("leader", 40))
    assert complete == [True]


@pytest.mark.parametrize("rubbish", [b"", b"\0\1", b"\0\1\0\0\xff\xff\xff\xff", b"\0\1\0\0\2\0\0\0\xff\0"])
def test_what_is_no_text_is_rejected(rubbish):
    call, node, _ = roll_call("simulator", "leader")
    node.hears_bytes(rubbish)
    assert call.waiting_for() == ["leader"]
    assert "graph/ready" in str(node.rejected[0])


def test_the_first_clock_must_reach_whom_it_paces():
    everyone = frozenset(NODES)
    assert expected_readers(CLOCK, everyone) == {"leader"}
    lonely = everyone - {"wrench_sensing", "arm_controller"}
    assert expected_readers(CLOCK, lonely) == {"leader", "gait_mapping"}


def test_a_reader_may_be_two_seconds_late():
    assert LOCKSTEP.depth >= 1000
