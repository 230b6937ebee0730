"""Parameters that every node of the graph shares, and those of a run, free of ROS."""

from __future__ import annotations

from dataclasses import dataclass

from follower_humanoid.core.config import parameter
from follower_humanoid.errors import UnknownNameError
from follower_humanoid.graph.wiring import ARM_TASK, NODES, SIMULATOR

RECORDER = "recorder"
VIEWER = "viewer"
LEADER = "leader"
ALL_NODES = ",".join(NODES)
LONGEST_RUN = 1e7  # [s]


@dataclass(frozen=True)
class GraphConfig:
    """What all nodes must agree on."""

    tick: float = parameter(0.002, "control tick, a whole number of physics steps", "s", 0.001, 0.02)
    urdf: str = parameter("", "URDF file of the robot; empty: the package's own", path=True)
    nodes: str = parameter(ALL_NODES, "nodes of this package that run, comma-separated")
    by_topic: str = parameter(
        "", "topics, comma-separated, that nodes hear by name even from nodes of this package"
    )
    autostart: bool = parameter(True, "configure and activate without a lifecycle manager")
    watchdog: float = parameter(
        5.0, "wall time after which a missing message ends the run; 0 = never", "s", 0.0, 3600.0
    )

    @property
    def present(self) -> frozenset[str]:
        """The nodes that run.

        Raises:
            UnknownNameError: A name that no node has.
        """
        names = frozenset(name.strip() for name in self.nodes.split(",") if name.strip())
        for name in sorted(names):
            if name not in NODES and name not in (RECORDER, ARM_TASK.name):
                raise UnknownNameError("node", name, (*NODES, ARM_TASK.name, RECORDER))
        return names

    @property
    def heard_by_topic(self) -> frozenset[str]:
        """Topics that no node takes from an envelope, since they are remapped."""
        return frozenset(name.strip() for name in self.by_topic.split(",") if name.strip())


@dataclass(frozen=True)
class RunConfig:
    """When a run ends and how fast it goes: parameters of the simulator node."""

    duration: float = parameter(
        0.0, "simulated time after which the run ends; 0 = endless", "s", 0.0, LONGEST_RUN
    )
    settle: float = parameter(
        0.0, "longest time after `duration` to wait until the robot stands; 0 = none", "s", 0.0, 1000.0
    )
    realtime: bool = parameter(False, "not faster than real time")
    hold_after: float = parameter(
        0.25, "in real time: silence of a controller after which the motor drives hold", "s", 0.01, 10.0
    )
    people_timeout: float = parameter(
        0.5, "silence of a person's wrench topic after which it lets go", "s", 0.0, 1000.0
    )
    people_release: float = parameter(0.2, "time over which it lets go", "s", 0.0, 1000.0)


def shared_config_classes(node: str) -> tuple[type, ...]:
    """Configuration classes that a node has besides its component's own."""
    return (GraphConfig, RunConfig) if node == SIMULATOR else (GraphConfig,)
