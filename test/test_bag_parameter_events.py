"""Parameters that were changed during a run come out of the bag as they went in."""

from __future__ import annotations

import dataclasses

import pytest
from bag_messages import START, TICK_NS, TOPICS, arrivals, write_bag
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from follower_humanoid.bag.cdr import CdrError, Cursor
from follower_humanoid.bag.parameter_events import parameter_event
from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.recorder import ADJUSTED, Arrival
from follower_humanoid.graph.record import Adjusted

VALUES = {
    "mode": "gravity_compensation", "payload": 12.5, "on": True, "count": -7, "empty": "",
    "numbers": [0.1, -2.0], "none": [0.5], "words": ["a", "", "längere"], "whole": [1, -(2**40)],
    "flags": [True, False, True],
}  # fmt: skip


def event(tick: int, values: dict, node: str = "/robot/arm_controller") -> bytes:
    seconds, nanoseconds = divmod(tick * TICK_NS, 10**9)
    changed = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
    message = ParameterEvent(stamp=Time(sec=seconds, nanosec=nanoseconds), node=node)
    message.changed_parameters = changed
    return bytes(serialize_message(message))


@pytest.mark.parametrize("name", VALUES)
def test_every_kind_of_value(name):
    stamp, node, values = parameter_event(Cursor(event(40, {name: VALUES[name]})))
    assert (stamp, node) == (40 * TICK_NS, "arm_controller")
    expected = VALUES[name]
    assert values == {name: tuple(expected) if isinstance(expected, list) else expected}


def test_several_at_once_in_their_order():
    _, _, values = parameter_event(Cursor(event(0, VALUES)))
    assert list(values) == list(VALUES)


def test_what_breaks_off_is_refused_wherever_it_does():
    data = event(40, VALUES)
    whole = Cursor(data)
    parameter_event(whole)  # behind it may be what the serialiser had reserved
    assert whole.position > 500
    for length in range(whole.position):
        with pytest.raises(CdrError):
            parameter_event(Cursor(data[:length]))


def test_a_bag_brings_them_back_with_their_ticks(tmp_path):
    made = arrivals(60)
    for tick, values in ((40, {"mode": "auto"}), (20, {"payload": 3.0, "mode": "impedance"})):
        made.append(
            Arrival(TOPICS[ADJUSTED], event(tick, values), START + tick * TICK_NS, START + tick * TICK_NS)
        )
    made.append(Arrival(TOPICS[ADJUSTED], event(50, {})[:30], START + 60 * TICK_NS, START))
    run = read_run(write_bag(tmp_path / "bag", made=made))
    assert run.adjusted == (
        Adjusted(20, "arm_controller", {"payload": 3.0, "mode": "impedance"}),
        Adjusted(40, "arm_controller", {"mode": "auto"}),
    )
    assert any(ADJUSTED in note for note in run.notes)


def test_a_bag_without_any_has_none(tmp_path):
    run = read_run(write_bag(tmp_path / "bag", 20))
    assert run.adjusted == ()
    assert dataclasses.replace(run).notes == ()
