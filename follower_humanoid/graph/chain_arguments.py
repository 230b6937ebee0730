"""What may be asked of the chain without ROS: looked at before anything is made."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable, Mapping
from numbers import Real
from pathlib import Path
from typing import Any

from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.graph_config import LONGEST_RUN
from follower_humanoid.graph.wiring import ARM_TASK, NODES, SIMULATOR

NOBODY = "none"  # the leader of a robot that is not led


def check_parameters(parameters: Mapping[str, Mapping[str, Any]], nodes: Iterable[str]) -> None:
    """Whether values are given for nodes that there are; which values, their configurations say.

    Args:
        parameters: Node → dotted parameter name → value.
        nodes: Names that a node may have.

    Raises:
        ConfigurationError: No such mapping.
        UnknownNameError: No such node.
    """
    if not isinstance(parameters, Mapping):
        raise ConfigurationError(f"parameters = {parameters!r}: needs a mapping of nodes to their parameters")
    valid = tuple(nodes)
    for node, values in parameters.items():
        if node not in valid:
            raise UnknownNameError("node", str(node), valid, "parameters")
        if not isinstance(values, Mapping):
            raise ConfigurationError(
                f"parameters: {node} = {values!r}: needs a mapping of parameter names to values"
            )


def check_choice(without: Collection[str], more: Collection[str]) -> None:
    """Whether the nodes that are left out, and those besides, can be.

    Raises:
        ConfigurationError: A text in the place of names, or a name that cannot be there.
    """
    optional = [name for name in (*NODES, ARM_TASK.name) if name != SIMULATOR]
    for where, names, valid in (("without", without, optional), ("more", more, [ARM_TASK.name])):
        if isinstance(names, str):
            raise ConfigurationError(f"{where} = '{names}': needs a tuple of names, of {', '.join(valid)}")
        for name in names:
            if name not in valid:
                hint = "nothing moves without it" if name == SIMULATOR else ""
                raise UnknownNameError("node", str(name), valid, where, hint)


def programme_of(leader: str | Path) -> str | None:
    """A force programme as the leader's parameter takes it; None for `none`.

    Raises:
        ConfigurationError: Neither a name nor a path.
    """
    name = str(leader) if isinstance(leader, Path) else leader
    if not isinstance(name, str):
        raise ConfigurationError(
            f"leader = {leader!r}: valid: the name of a force programme, {NOBODY}, or the path of a YAML file"
        )
    if name == NOBODY:
        return None
    return str(Path(name).absolute()) if os.sep in name else name


def ticks_of(duration: float, tick: float) -> int:
    """How many control ticks a run has, 1 at least.

    Args:
        duration: Simulated time [s].
        tick: Control tick [s].

    Raises:
        ConfigurationError: No such time, or one without a tick.
    """
    usable = isinstance(duration, Real) and math.isfinite(duration) and duration <= LONGEST_RUN
    ticks = round(duration / tick) if usable else 0
    if ticks < 1:
        raise ConfigurationError(f"duration = {duration!r}: valid: {tick} to {LONGEST_RUN:g} s")
    return ticks
