"""What bringup tells the user: one status line while it runs, a summary at the end."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import TextIO

Values = Mapping[str, Mapping[str, str]]
_LINE_EVERY = 2.0  # wall time between two lines where they cannot overwrite one another [s]

# Node, key of its diagnostics, words, format.
_SUMMARY = (
    ("simulator", "simulated_time [s]", "simulated time", "{:.3f} s"),
    ("simulator", "mean_real_time_factor", "real-time factor", "{:.2f}"),
    ("simulator", "lateness_p99 [s]", "lateness of a tick, 99 %", "{:.4f} s"),
    ("simulator", "late_ticks", "ticks late by a whole tick", "{:.0f}"),
    ("motion_composition", "half_steps", "half-steps", "{:.0f}"),
    ("motion_composition", "lengths [m]", "lengths", "{} m"),
    ("motion_composition", "heading [rad]", "heading", "{:.4f} rad"),
    ("zmp_balance", "zmp_error_along [m]", "ZMP error along, rms", "{:.4f} m"),
    ("zmp_balance", "zmp_error_across [m]", "ZMP error across, rms", "{:.4f} m"),
    ("zmp_balance", "smallest_zmp_margin [m]", "smallest ZMP margin", "{:.4f} m"),
    ("simulator", "peak_voltage [V]", "peak voltage", "{:.1f} V"),
    ("simulator", "saturated_ticks", "ticks at the voltage limit", "{:.0f}"),
    ("simulator", "joint_hash", "joint hash", "{}"),
    ("recorder", "bag", "bag", "{}"),
)


class StatusLine:
    """One line, rewritten on a terminal, now and then a new one elsewhere."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """Args: where to write, stdout if None."""
        self._stream = stream or sys.stdout
        self._terminal = self._stream.isatty()
        self._written_at = 0.0
        self._text = ""

    def show(self, values: Values) -> None:
        """Writes the line if it has changed."""
        text = status_text(values)
        now = time.monotonic()
        if not text or text == self._text or (not self._terminal and now - self._written_at < _LINE_EVERY):
            return
        self._text, self._written_at = text, now
        self._stream.write(f"\r\x1b[K{text}" if self._terminal else f"{text}\n")
        self._stream.flush()

    def end(self) -> None:
        """Leaves the line."""
        if self._terminal and self._text:
            self._stream.write("\n")
            self._stream.flush()
        self._text = ""


def status_text(values: Values) -> str:
    """Simulated time, real-time factor, steps, ZMP margin; empty before there is anything to say."""
    simulator = values.get("simulator", {})
    if "simulated_time [s]" not in simulator:
        return ""
    parts = [f"t = {_number(simulator, 'simulated_time [s]', '{:.2f}')} s"]
    parts.append(f"real-time factor {_number(simulator, 'real_time_factor', '{:.2f}')}")
    parts.append(f"steps {_number(values.get('motion_composition', {}), 'half_steps', '{:.0f}')}")
    parts.append(f"ZMP margin {_number(values.get('zmp_balance', {}), 'zmp_margin [m]', '{:.3f} m')}")
    return "   ".join(parts)


def has_begun(values: Values, ours: bool) -> bool:
    """Whether a tick was taken, as far as is known; with another's simulator, which need not tell, it may be.

    Args:
        values: What the nodes last said.
        ours: Whether the simulator is this package's.
    """
    told = values.get("simulator", {}).get("simulated_time [s]")
    if told is None:
        return not ours
    try:
        return float(told) > 0.0
    except ValueError:
        return True


def summary_text(values: Values) -> str:
    """A line per quantity; one that its node did not report is left out."""
    lines = []
    for node, key, words, form in _SUMMARY:
        text = _number(values.get(node, {}), key, form)
        if text != "-":
            lines.append(f"  {words + ':':<30}{text}")
    return "\n".join(lines)


def _number(values: Mapping[str, str], key: str, form: str) -> str:
    text = values.get(key, "")
    if not text:
        return "-"
    try:
        return form.format(float(text))
    except ValueError:
        return form.format(text) if form.startswith("{}") else text
