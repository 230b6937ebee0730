"""The line of a run on a terminal: left once, whatever is said after it."""

from __future__ import annotations

import io

from follower_humanoid.ros.status import StatusLine


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
