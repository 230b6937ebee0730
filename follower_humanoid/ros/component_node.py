"""A node that runs one component of the wiring table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from follower_humanoid.graph.wiring import node_wiring
from follower_humanoid.ros.lockstep_node import LockStepNode


class ComponentNode(LockStepNode):
    """Inputs of a tick in, `step`, outputs of the tick out."""

    def __init__(self, name: str, **options: Any) -> None:
        """Args: the node's name in the wiring table."""
        super().__init__(node_wiring(name), **options)
        self._inputs = self.wiring.component_class().Inputs
        self._topic_of = tuple(self.wiring.inputs.items())

    def step(self, tick: int, samples: Mapping[str, Any]) -> None:
        """One step of the component."""
        inputs = self._inputs(**{name: samples[topic] for name, topic in self._topic_of})
        self.publish(self.component.step(inputs, tick * self.graph.tick), tick)
