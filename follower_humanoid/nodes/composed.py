"""Executable: several nodes in one process, on one executor. `composed --nodes a,b,c [--ros-args ...]`."""

from __future__ import annotations

import argparse
import sys
from functools import partial

from follower_humanoid.graph.wiring import SIMULATOR, node_wiring
from follower_humanoid.ros.bus import Bus
from follower_humanoid.ros.component_node import ComponentNode
from follower_humanoid.ros.managed_node import ManagedNode
from follower_humanoid.ros.simulator_node import SimulatorNode
from follower_humanoid.ros.spin import run


def make(name: str, bus: Bus) -> ManagedNode:
    """The node of that name.

    Raises:
        UnknownNameError: No such node.
    """
    return SimulatorNode(bus=bus) if name == SIMULATOR else ComponentNode(node_wiring(name).name, bus=bus)


def main(args: list[str] | None = None) -> int:
    """Runs the nodes; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", required=True, help="names, comma-separated")
    options, ros_args = parser.parse_known_args(args)
    names = options.nodes.split(",")
    bus = Bus(names)
    return run([partial(make, name, bus) for name in names], ros_args, bus)


if __name__ == "__main__":
    sys.exit(main())
