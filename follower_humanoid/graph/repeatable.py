"""What a recorded run carries for a repetition: looked at before anything is made."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from follower_humanoid.core.config import build, parameters_of
from follower_humanoid.core.yaml_file import parse_yaml
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.node_configs import node_parameters
from follower_humanoid.graph.record import Adjusted, Run
from follower_humanoid.graph.repetition_notes import repetition_notes
from follower_humanoid.graph.wiring import ARM_TASK, NODES, SIMULATOR, NodeWiring, nodes_with

PARAMETERS = "parameters.yaml"
_KEY = "ros__parameters"
# Input of the simulator → topic that tells what acted.
APPLIED = {
    "leader_left": "left_hand/applied",
    "leader_right": "right_hand/applied",
    "push": "base/applied",
}
# Resets fall on ticks at which every node steps.
_PERIODS = math.lcm(*(node.period for node in NODES.values()))


@dataclass(frozen=True)
class Recorded:
    """What a repetition takes from a recorded run.

    Attributes:
        run: The recorded run.
        nodes: Nodes of the wiring table that ran.
        parameters: Node → dotted name → value, of the components.
        adjusted: Changes of parameters of those nodes.
        resets: Ticks at which the robot was put back on its feet.
        notes: Why the repetition may come out differently, one sentence each.
    """

    run: Run
    nodes: frozenset[str]
    parameters: Mapping[str, Mapping[str, Any]]
    resets: frozenset[int]
    adjusted: tuple[Adjusted, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @property
    def table(self) -> Mapping[str, NodeWiring]:
        """The wiring table of the run."""
        return nodes_with(self.nodes)

    @property
    def ticks(self) -> int:
        """Ticks from time 0 to the last recorded joint state."""
        return int(self.run["joint_states"].ticks[-1]) + 1


def repeatable(run: Run) -> Recorded:
    """Takes from a run what a repetition needs.

    Raises:
        ConfigurationError: The bag does not carry it, or this version of the package does not know it.
    """
    values = _carried_parameters(run)
    states = run["joint_states"]
    if states.ticks[0] != 0:
        raise ConfigurationError(
            f"the bag begins at {states.times[0]:.3f} s; a run can be simulated again from time 0 only"
        )
    if not run.urdf:
        raise ConfigurationError("the bag carries no URDF, which simulating it again needs")
    for topic in APPLIED.values():
        if topic not in run:
            raise ConfigurationError(f"the bag holds no {topic}, which simulating it again needs")
    listed = str(values.get(SIMULATOR, {}).get("nodes", ",".join(NODES))).split(",")
    names = {name.strip() for name in listed}
    if any(topic in run for topic in ARM_TASK.outputs.values()):
        names.add(ARM_TASK.name)
    nodes = frozenset(names & nodes_with(names).keys())
    resets = _resets(run)
    parameters = _component_parameters(values, nodes)
    adjusted = _adjusted(run, nodes, parameters)
    notes = tuple(repetition_notes(run, nodes, resets, adjusted, APPLIED.values()))
    return Recorded(run, nodes, parameters, resets, adjusted, notes)


def _carried_parameters(run: Run) -> dict[str, dict[str, Any]]:
    if PARAMETERS not in run.about:
        raise ConfigurationError(
            f"the bag carries no {PARAMETERS}: only a run recorded by bringup can be simulated again"
        )
    try:
        content = parse_yaml(run.about[PARAMETERS], PARAMETERS)
        return {str(node): dict(block[_KEY]) for node, block in content.items()}
    except (ConfigurationError, AttributeError, KeyError, TypeError, ValueError):
        raise ConfigurationError(f"{PARAMETERS} in the bag cannot be read") from None


def _component_parameters(
    values: Mapping[str, Mapping[str, Any]], nodes: frozenset[str]
) -> dict[str, dict[str, Any]]:
    """Those of the components; the others say how the graph ran, which makes no difference."""
    parameters: dict[str, dict[str, Any]] = {}
    for name, node in nodes_with(nodes).items():
        given = values.get(name, {})
        known = node_parameters(name)
        for parameter in given:
            if parameter not in known:
                raise UnknownNameError("parameter", parameter, known, f"{PARAMETERS} in the bag: {name}")
        own = {info.name for info in parameters_of(node.component_class().Config)}
        parameters[name] = {parameter: value for parameter, value in given.items() if parameter in own}
    return parameters


def _adjusted(
    run: Run, nodes: frozenset[str], parameters: Mapping[str, Mapping[str, Any]]
) -> tuple[Adjusted, ...]:
    """What was changed while it ran, of the nodes that are simulated again.

    Raises:
        ConfigurationError: This version of the package cannot change it while it runs.
    """
    found, table, values = [], nodes_with(nodes), {name: dict(given) for name, given in parameters.items()}
    for change in run.adjusted:
        if change.node not in nodes:
            continue
        config = table[change.node].component_class().Config
        adjustable = {info.name for info in parameters_of(config) if not info.read_only}
        for name in change.values:
            if name not in adjustable:
                where = f"changed during the recorded run: {change.node}"
                raise UnknownNameError("adjustable parameter", name, adjustable, where)
        values[change.node].update(change.values)
        build(config, values[change.node], change.node)
        found.append(change)
    return tuple(found)


def _resets(run: Run) -> frozenset[int]:
    """Ticks at which joints and base are again, bit for bit, where they were at time 0."""
    joints, base = run["joint_states"], run["odom"]
    if len(joints) != len(base) or not np.array_equal(joints.ticks, base.ticks):
        return frozenset()
    state = np.hstack((joints.position, base.position, base.quat_xyzw))
    at_start = (state == state[0]).all(axis=1)
    began = np.flatnonzero(at_start[1:] & ~at_start[:-1]) + 1
    return frozenset(int(tick) for tick in joints.ticks[began] if tick % _PERIODS == 0)
