"""Executable: several nodes in one process, on one executor. `composed --nodes a,b,c [--ros-args ...]`."""

from __future__ import annotations

import argparse
import sys
from functools import partial

from follower_humanoid.graph.wiring import SIMULATOR, node_wiring
from follower_humanoid.ros.component_node import ComponentNode
from follower_humanoid.ros.managed_node import ManagedNode
from follower_humanoid.ros.simulator_node import SimulatorNode
from follower_humanoid.ros.spin import run


def make(name: str) -> ManagedNode:
    """The node of that name.

    Raises:
        UnknownNameError: No such node.
    """
    return SimulatorNode() if name == SIMULATOR else ComponentNode(node_wiring(name).name)


def main(args: list[str] | None = None) -> int:
    """Runs the nodes; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", required=True, help="names, comma-separated")
    options, ros_args = parser.parse_known_args(args)
    return run([partial(make, name) for name in options.nodes.split(",")], ros_args)


if __name__ == "__main__":
    sys.exit(main())
