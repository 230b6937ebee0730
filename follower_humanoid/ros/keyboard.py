"""The space bar of a terminal, where there is one."""

from __future__ import annotations

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_LOOK = 0.1


@contextmanager
def on_space(action: Callable[[], None]) -> Iterator[None]:
    """Calls `action` at every press of the space bar while the block runs."""
    if not sys.stdin or not sys.stdin.isatty() or not _in_foreground():
        yield
        return
    keys = sys.stdin.fileno()
    before = termios.tcgetattr(keys)
    over = threading.Event()

    def listen() -> None:
        while not over.is_set():
            if select.select([keys], [], [], _LOOK)[0] and b" " in os.read(keys, 64):
                action()

    tty.setcbreak(keys)
    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    try:
        yield
    finally:
        over.set()
        listener.join()
        termios.tcsetattr(keys, termios.TCSADRAIN, before)


def _in_foreground() -> bool:
    """A process in the background would be halted when it touches the terminal."""
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except OSError:
        return False
