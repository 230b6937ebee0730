"""Which configuration dataclasses make up the parameters of each node."""

from __future__ import annotations

from dataclasses import dataclass

from follower_humanoid.bag.recorder import RecorderConfig
from follower_humanoid.core.config import ParameterInfo, parameter, parameters_of
from follower_humanoid.graph.graph_config import RECORDER, VIEWER, GraphConfig, shared_config_classes
from follower_humanoid.graph.wiring import ARM_TASK, NODES, node_wiring
from follower_humanoid.viewer.config import ViewerConfig


@dataclass(frozen=True)
class RosConfig:
    """What ROS 2 itself declares on every node."""

    use_sim_time: bool = parameter(False, "log lines and clocks of the node follow /clock; stamps always do")


def node_names() -> tuple[str, ...]:
    """Every node that a parameter file may name, in the order of the wiring table."""
    return (*NODES, ARM_TASK.name, RECORDER, VIEWER)


def config_classes(node: str) -> tuple[type, ...]:
    """The configuration dataclasses of a node: its own, then what it shares with others."""
    beside = {RECORDER: RecorderConfig, VIEWER: ViewerConfig}
    own = beside[node] if node in beside else node_wiring(node).component_class().Config
    return (own, *shared_config_classes(node), RosConfig)


def node_parameters(node: str) -> dict[str, ParameterInfo]:
    """Every parameter of a node by its dotted name."""
    return {info.name: info for cls in config_classes(node) for info in parameters_of(cls)}


def shared_parameters() -> dict[str, ParameterInfo]:
    """The parameters that every node has, and that all must agree on."""
    return {info.name: info for cls in (GraphConfig, RosConfig) for info in parameters_of(cls)}
