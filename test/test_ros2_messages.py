"""Messages from YAML and back: every kind of field, and complaints that name field and valid names."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PolygonStamped, PoseWithCovariance, WrenchStamped
from sensor_msgs.msg import JointState

from follower_humanoid.command_line import UsageError
from follower_humanoid.ros2_front.messages import (
    field_of,
    fill,
    interface,
    plain,
    read_values,
    type_name_of,
    yaml_text,
)
from follower_humanoid.ros2_front.verbs import CommandError


def filled(message_class, text):
    message = message_class()
    fill(message, read_values(text))
    return message


def test_what_people_type_becomes_a_message():
    message = filled(WrenchStamped, "{wrench: {force: {x: 5}}}")
    assert message.wrench.force.x == 5.0
    assert message.wrench.force.y == 0.0


def test_lists_of_numbers_texts_and_messages():
    state = filled(JointState, "{name: [a, 1], position: [1, 2.5], header: {frame_id: base_link}}")
    assert list(state.name) == ["a", "1"]
    assert list(state.position) == [1.0, 2.5]
    polygon = filled(PolygonStamped, "{polygon: {points: [{x: 1}, {y: 2}]}}")
    assert [(p.x, p.y) for p in polygon.polygon.points] == [(1.0, 0.0), (0.0, 2.0)]
    pose = filled(PoseWithCovariance, f"{{covariance: {list(range(36))}}}")
    assert pose.covariance[35] == 35.0


def test_octets():
    array = filled(DiagnosticArray, "{status: [{level: 2, name: simulator}]}")
    assert array.status[0].level == DiagnosticStatus.ERROR
    assert plain(array)["status"][0]["level"] == 2


def test_a_header_may_be_made_automatically():
    assert filled(WrenchStamped, "{header: auto}").header.stamp.sec > 1_000_000_000
    assert filled(WrenchStamped, "{header: {stamp: now}}").header.stamp.sec > 1_000_000_000


def test_what_was_printed_can_be_published_again():
    message = filled(JointState, "{header: {stamp: {sec: 3}}, name: [a], position: [0.1], effort: [.nan]}")
    again = filled(JointState, yaml_text(plain(message)))
    assert again.name == message.name
    assert again.position == message.position
    assert again.header == message.header


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{wrench: {forc: {x: 5}}}", "no field 'wrench.forc' in geometry_msgs/msg/Wrench; valid: force, tor"),
        ("{wrench: {force: {x: much}}}", "wrench.force.x = 'much'"),
        ("{wrench: {force: {x: true}}}", "wrench.force.x = True: needs a number"),
        ("{wrench: {force: 5}}", "wrench.force = 5: needs a mapping"),
        ("{header: {stamp: {nanosec: -1}}}", "header.stamp.nanosec = -1: valid: 0 to 4294967295"),
        ("{header: {stamp: {sec: 0.5}}}", "needs a whole number"),
        ("5", "mapping"),
        ("{wrench: {", "no YAML"),
    ],
)
def test_what_does_not_fit_is_named(text, told):
    with pytest.raises(UsageError) as error:
        filled(WrenchStamped, text)
    assert told in str(error.value)


def test_a_list_of_the_wrong_length_is_named():
    with pytest.raises(UsageError, match="covariance has 2 entries: needs 36"):
        filled(PoseWithCovariance, "{covariance: [1, 2]}")


def test_types_by_their_long_and_short_name():
    assert interface("geometry_msgs/msg/WrenchStamped") is interface("geometry_msgs/WrenchStamped")
    assert type_name_of(WrenchStamped) == "geometry_msgs/msg/WrenchStamped"
    assert interface("std_srvs/srv/Trigger", "srv").Request is not None


@pytest.mark.parametrize(
    ("name", "error", "told"),
    [
        ("no_such_msgs/msg/A", CommandError, "package no_such_msgs is not installed"),
        ("geometry_msgs/msg/Nothing", CommandError, "has no such type"),
        ("Wrench", UsageError, "is no type"),
        ("geometry_msgs/srv/Wrench", UsageError, "is no type"),
    ],
)
def test_unknown_types(name, error, told):
    with pytest.raises(error, match=told):
        interface(name)


def test_parts_of_a_message():
    state = filled(JointState, "{position: [1, 2.5]}")
    assert field_of(state, "position[1]") == 2.5
    assert field_of(state, "header.frame_id") == ""
    with pytest.raises(UsageError, match=r"no field 'position\[2\]'"):
        field_of(state, "position[2]")


def test_long_lists_and_texts_are_cut():
    state = filled(JointState, f"{{position: {list(range(200))}, header: {{frame_id: {'x' * 200}}}}}")
    shown = plain(state, 128)
    assert len(shown["position"]) == 129
    assert shown["position"][-1] == "..."
    assert len(shown["header"]["frame_id"]) == 131
    assert plain(state, arrays=False)["position"] == "<sequence<double>: 200 entries>"
