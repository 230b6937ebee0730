"""The line of a run on a terminal: left once, whatever is said after it."""

from __future__ import annotations

import io

import pytest

from follower_humanoid.ros.status import StatusLine, has_begun


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_line_is_left_once():
    terminal = Terminal()
    line = StatusLine(terminal)
    line.end()
    assert terminal.getvalue() == ""
    line.show({"simulator": {"simulated_time [s]": "1.5"}})
    for _ in range(3):
        line.end()
    assert terminal.getvalue().count("\n") == 1
    assert terminal.getvalue().endswith("\n")


@pytest.mark.parametrize(
    ("told", "ours", "begun"),
    [
        ({"simulated_time [s]": "0"}, True, False),
        ({"simulated_time [s]": "0.002"}, True, True),
        ({"simulated_time [s]": "0"}, False, False),
        ({"simulated_time [s]": "soon"}, True, True),
        ({}, True, False),
        ({}, False, True),  # somebody else's simulator, which need not tell
    ],
)
def test_a_run_has_begun_once_simulated_time_goes_on(told, ours, begun):
    assert has_begun({"simulator": told}, ours) is begun
