"""Executable: the node `motion_composition`."""

from __future__ import annotations

import sys

from follower_humanoid.ros.component_node import ComponentNode
from follower_humanoid.ros.spin import run

NAME = "motion_composition"


def main(args: list[str] | None = None) -> int:
    """Runs the node; returns the exit status."""
    return run([lambda: ComponentNode(NAME)], args)


if __name__ == "__main__":
    sys.exit(main())
