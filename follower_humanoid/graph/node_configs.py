"""Which configuration dataclasses make up the parameters of each node."""

from __future__ import annotations

from follower_humanoid.core.config import ParameterInfo, parameters_of
from follower_humanoid.graph.wiring import NODES, node_wiring


def node_names() -> tuple[str, ...]:
    """Every node that a parameter file may name, in the order of the wiring table."""
    return tuple(NODES)


def config_classes(node: str) -> tuple[type, ...]:
    """The configuration dataclasses of a node; their names do not overlap.

    Raises:
        UnknownNameError: No node of that name.
    """
    return (node_wiring(node).component_class().Config,)


def node_parameters(node: str) -> dict[str, ParameterInfo]:
    """Every parameter of a node by its dotted name.

    Raises:
        UnknownNameError: No node of that name.
    """
    return {info.name: info for cls in config_classes(node) for info in parameters_of(cls)}
