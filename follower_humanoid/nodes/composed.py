"""Executable: several nodes in one process, on one executor. `composed --nodes a,b,c [--ros-args ...]`."""

from __future__ import annotations

import sys
from functools import partial

from follower_humanoid.command_line import Parser, split_ros_args
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError
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
    own, ros_args = split_ros_args(sys.argv[1:] if args is None else args)
    parser = Parser(prog="composed", description="Several nodes in one process.", allow_abbrev=False)
    parser.add_argument("--nodes", required=True, help="names, comma-separated")
    try:
        names = parser.parse_args(own).nodes.split(",")
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION
    bus = Bus(names)
    return run([partial(make, name, bus) for name in names], ["--ros-args", *ros_args], bus)


if __name__ == "__main__":
    sys.exit(main())
