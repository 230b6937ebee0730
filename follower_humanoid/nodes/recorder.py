"""Executable: the node `recorder`."""

from __future__ import annotations

import sys

from follower_humanoid.ros.recorder_node import RecorderNode
from follower_humanoid.ros.spin import run


def main(args: list[str] | None = None) -> int:
    """Runs the node; returns the exit status."""
    return run([RecorderNode], args)


if __name__ == "__main__":
    sys.exit(main())
