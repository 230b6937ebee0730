"""Executable: the node `simulator`."""

from __future__ import annotations

import sys

from follower_humanoid.ros.simulator_node import SimulatorNode
from follower_humanoid.ros.spin import run


def main(args: list[str] | None = None) -> int:
    """Runs the node; returns the exit status."""
    return run([SimulatorNode], args)


if __name__ == "__main__":
    sys.exit(main())
