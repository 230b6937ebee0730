"""Which configuration dataclasses make up the parameters of each node."""

from __future__ import annotations

from follower_humanoid.core.config import ParameterInfo, parameters_of
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.ros.graph_config import RECORDER, GraphConfig, shared_config_classes


def node_names() -> tuple[str, ...]:
    """Every node that a parameter file may name, in the order of the wiring table."""
    return (*NODES, RECORDER)


def config_classes(node: str) -> tuple[type, ...]:
    """The configuration dataclasses of a node: its component's own, then what it shares with others."""
    own = (NODES[node].component_class().Config,) if node in NODES else ()
    return (*own, *shared_config_classes(node))


def node_parameters(node: str) -> dict[str, ParameterInfo]:
    """Every parameter of a node by its dotted name."""
    return {info.name: info for cls in config_classes(node) for info in parameters_of(cls)}


def shared_parameters() -> dict[str, ParameterInfo]:
    """The parameters that all nodes must agree on."""
    return {info.name: info for info in parameters_of(GraphConfig)}
