"""Imports what the nodes run, which compiles the inner loops the first time.

Whoever starts several processes that need it does it once before, since each would compile for itself; on
the command line it is `python -m follower_humanoid.compile`.
"""

from __future__ import annotations

import sys
from typing import Any

from numba.core import event

from follower_humanoid.graph.wiring import ARM_TASK, NODES


class _Announcement(event.Listener):
    """Says once, when the first compilation begins, that it will take a while."""

    said = False

    def on_start(self, event: Any) -> None:
        if not self.said:
            self.said = True
            print("compiling the inner loops, once: up to a minute ...", file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Nothing: the next one follows."""


def import_components() -> None:
    """Imports every component of the wiring table; kernels come from disk if they were compiled before."""
    with event.install_listener("numba:compile", _Announcement()):
        for node in (*NODES.values(), ARM_TASK):
            node.component_class()


if __name__ == "__main__":
    import_components()
