"""Who is waited for at the start and at a reset."""

from __future__ import annotations

from std_msgs.msg import String

from follower_humanoid.graph.lockstep import CLOCK
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros.barrier import RollCall, expected_readers, reset_known
from follower_humanoid.ros.qos import LOCKSTEP


class Listener:
    """A node of which only the subscription matters."""

    def create_subscription(self, kind, topic, callback, qos):
        self.hears = lambda text: callback(String(data=text))


def roll_call(*present):
    node, complete = Listener(), []
    return RollCall(node, present, lambda: complete.append(True)), node, complete


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


def test_the_first_clock_must_reach_whom_it_paces():
    everyone = frozenset(NODES)
    assert expected_readers(CLOCK, everyone) == {"leader"}
    lonely = everyone - {"wrench_sensing", "arm_controller"}
    assert expected_readers(CLOCK, lonely) == {"leader", "gait_mapping"}


def test_a_reader_may_be_two_seconds_late():
    assert LOCKSTEP.depth >= 1000
