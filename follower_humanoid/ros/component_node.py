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
        # Topic of each input, in their order; nothing comes to an input that is not wired.
        self._topics = [self.wiring.inputs.get(name) for name in self._inputs.__match_args__]

    def step(self, tick: int, samples: Mapping[str, Any]) -> None:
        """One step of the component."""
        inputs = self._inputs(*[None if topic is None else samples[topic] for topic in self._topics])
        self.publish(self.component.step(inputs, tick * self.graph.tick), tick)
