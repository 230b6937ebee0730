"""SIGINT and SIGTERM while a program still loads what it needs: a clean stop, nothing has begun yet."""

from __future__ import annotations

import signal
import sys
from types import FrameType


def stop_at_a_signal() -> None:
    """From now on either signal ends this process with status 0, until somebody else takes them over."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)


def _leave(number: int, frame: FrameType | None) -> None:
    sys.exit(0)
