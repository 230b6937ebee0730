"""What is heard on /diagnostics, which is everybody's topic, and what comes of nonsense there."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message

from follower_humanoid.ros.director import reports_in
from follower_humanoid.ros.status import status_text, summary_text


def report(name, hardware, **values):
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return serialize_message(
        DiagnosticArray(status=[DiagnosticStatus(name=name, hardware_id=hardware, values=pairs)])
    )


@pytest.mark.parametrize(
    ("name", "hardware", "namespace", "heard"),
    [
        ("/simulator", "/", "/", "simulator"),
        ("/one/simulator", "/one", "/one", "simulator"),
        ("/two/simulator", "/two", "/one", None),  # another robot
        ("simulator", "arm 7", "/", None),  # somebody else's, of the same name
        ("/camera", "/", "/", None),
        ("/x/../simulator", "/", "/", None),
    ],
)
def test_only_nodes_of_this_graph_are_heard(name, hardware, namespace, heard):
    found = reports_in(report(name, hardware, tick="3"), namespace)
    assert found == ({heard: {"tick": "3"}} if heard else {})


@pytest.mark.parametrize("rubbish", [b"", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 50])
def test_rubbish_is_no_report_and_says_nothing(rubbish, capfd):
    assert reports_in(rubbish, "/") == {}
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("value", ["", "much", "nan", "1e999", "{}", "\0", "9" * 5000])
def test_a_value_that_is_no_number_breaks_no_line(value):
    keys = ("simulated_time [s]", "real_time_factor", "saturated_ticks")
    values = {"simulator": dict.fromkeys(keys, value)}
    assert "real-time factor" in status_text(values)
    assert isinstance(summary_text(values), str)
