"""What rclpy loads of a message type when it is first used."""

from __future__ import annotations

import sys


def load_type_support() -> None:
    """Loads that of all types imported so far: before a fork, once for all processes."""
    for name, module in list(sys.modules.items()):
        if ".msg._" in name or ".srv._" in name:
            for kind in [type(value) for value in vars(module).values()]:
                if hasattr(kind, "__import_type_support__") and kind._TYPE_SUPPORT is None:
                    kind.__import_type_support__()
