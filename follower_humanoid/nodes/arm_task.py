"""Executable: the node `arm_task`."""

from __future__ import annotations

import sys

from follower_humanoid.ros.component_node import ComponentNode
from follower_humanoid.ros.spin import run

NAME = "arm_task"


def main(args: list[str] | None = None) -> int:
    """Runs the node; returns the exit status."""
    return run([lambda: ComponentNode(NAME)], args)


if __name__ == "__main__":
    sys.exit(main())
