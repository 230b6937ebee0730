"""The whole chain as one loop, without ROS: same objects, same wiring, same results."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from follower_humanoid.core.config import build
from follower_humanoid.errors import UnknownNameError
from follower_humanoid.graph.chain_arguments import check_choice, check_parameters, programme_of, ticks_of
from follower_humanoid.graph.graph_config import LEADER, GraphConfig
from follower_humanoid.graph.record import Adjusted, Run, RunRecorder
from follower_humanoid.graph.wiring import (
    NODES,
    PRODUCER,
    SIMULATOR,
    NodeWiring,
    is_same_tick,
    last_period,
    nodes_with,
)
from follower_humanoid.robot.model import RobotModel

TICK = 0.002
Parameters = Mapping[str, Mapping[str, Any]]
Interference = Callable[[str, int, Any], Any]
Samples = Mapping[str, Any]  # by topic

_PERIODS = frozenset(node.period for node in PRODUCER.values())
# Ticks for which a sample may be of use: to the end of the period after the one it was made in.
_KEPT = 2 * max(_PERIODS)


class _Wires:
    """What flows to and from a node, looked up once.

    Attributes:
        outputs: Name and topic of each output.
    """

    def __init__(self, node: NodeWiring) -> None:
        """The wires of one node of the table."""
        self._class = node.component_class().Inputs
        # Of each input, in their order, the topic and the period of who makes it; 0 if what comes at a tick
        # is used at that tick. Nothing comes to an input that is not wired.
        self._sources: list[tuple[str, int]] = []
        for name in self._class.__match_args__:
            topic = node.inputs.get(name, "")
            same_tick = not topic or is_same_tick(topic)
            self._sources.append((topic, 0 if same_tick else PRODUCER[topic].period))
        self.outputs = tuple(node.outputs.items())

    def inputs(self, used: Mapping[int, Samples]) -> Any:
        """What the node uses at a tick. Args: the samples used of those made with each period."""
        return self._class(*[used[period].get(topic) for topic, period in self._sources])


class Chain:
    """Every node's component, wired as in the graph, stepped tick by tick."""

    def __init__(
        self,
        parameters: Parameters | None = None,
        tick: float = TICK,
        urdf: str = "",
        without: tuple[str, ...] = (),
        interference: Interference | None = None,
        more: tuple[str, ...] = (),
    ) -> None:
        """Makes the components.

        Args:
            parameters: Node → dotted parameter name → value; what is left out keeps its default.
            tick: Control tick [s].
            urdf: Robot description of controllers and plant; empty: the package's.
            without: Nodes left out; their topics stay empty.
            interference: Called with (topic, tick, sample) for every sample; what it returns flows on in
                its place, as if another node published there.
            more: Nodes besides those that always run.

        Raises:
            ConfigurationError: A parameter, a node's name or the tick cannot be used.
        """  # fmt: skip
        check_choice(without, more)
        table = nodes_with(more)
        self._parameters = {} if parameters is None else parameters
        check_parameters(self._parameters, table)
        self.tick_length = build(GraphConfig, {"tick": tick}).tick
        self.nodes = [node for node in table.values() if node.name not in without]
        configs = [self._config(node) for node in self.nodes]  # all of them before there is a world
        self.robot = RobotModel(urdf)
        self._interference = interference
        self.components: dict[str, Any] = {
            node.name: node.make(config, self.robot, self.tick_length)
            for node, config in zip(self.nodes, configs, strict=True)
        }
        self.simulator = self.components[SIMULATOR]
        self._flow: dict[int, dict[str, Any]] = {}  # tick → topic → sample
        self._used: dict[int, Samples] = {}  # period of their makers, or 0 → samples used at this tick
        self._wires = {node.name: _Wires(node) for node in self.nodes}
        self.recorder = RunRecorder(self.tick_length, self.robot.joint_names, self.robot.urdf)
        self.tick = 0
        gc.freeze()  # what exists now stays: collections during the run need not look at it again

    def advance(self) -> None:
        """One control tick: state, references, commands, physics."""
        tick, time = self.tick, self.tick * self.tick_length
        self._look_back()
        simulator = NODES[SIMULATOR]
        self._publish(simulator, self.simulator.observe())
        for node in self.nodes:
            if node.name != SIMULATOR and tick % node.period == 0 and not self._is_idle(node):
                self._publish(node, self.components[node.name].step(self._inputs(node), time))
        self.simulator.advance(self._inputs(simulator))
        self.tick += 1

    def adjust(self, node: str, values: Mapping[str, Any]) -> None:
        """Changes parameters of a running component, as on a running node: the next tick uses them.

        Raises:
            ConfigurationError: No such node, or a value cannot be used.
        """
        if node not in self.components:
            raise UnknownNameError("node", node, self.components)
        merged = {**self._parameters.get(node, {}), **values}
        component = self.components[node]
        component.reconfigure(build(type(component).Config, merged, node))
        self._parameters = {**self._parameters, node: merged}
        self.recorder.adjust(Adjusted(self.tick, node, dict(values)))

    def finish(self) -> Run:
        """What was recorded so far."""
        return self.recorder.finish()

    def close(self) -> None:
        """Ends the physics engine."""
        gc.unfreeze()
        self.simulator.close()

    def _make(self, node: NodeWiring) -> Any:
        return node.make(self._config(node), self.robot, self.tick_length)

    def _config(self, node: NodeWiring) -> Any:
        return build(node.component_class().Config, self._parameters.get(node.name, {}), node.name)

    def _is_idle(self, node: NodeWiring) -> bool:
        """Whether a node takes no step at this tick and has nothing to say."""
        return False

    def _look_back(self) -> None:
        """Finds the samples that are used at this tick, and forgets those that no longer are."""
        tick, flow = self.tick, self._flow
        self._used = {period: flow.get(last_period(tick, period), {}) for period in _PERIODS}
        self._used[0] = flow.setdefault(tick, {})
        flow.pop(tick - _KEPT, None)

    def _inputs(self, node: NodeWiring) -> Any:
        return self._wires[node.name].inputs(self._used)

    def _publish(self, node: NodeWiring, outputs: Any) -> None:
        tick, interference, record = self.tick, self._interference, self.recorder.add
        samples = self._flow.setdefault(tick, {})
        for name, topic in self._wires[node.name].outputs:
            sample = getattr(outputs, name)
            if interference is not None:
                sample = interference(topic, tick, sample)
            if sample is not None:
                samples[topic] = sample
                record(topic, tick, sample)


def simulate(
    leader: str | Path = "fig4",
    duration: float = 22.0,
    parameters: Parameters | None = None,
    *,
    tick: float = TICK,
    urdf: str = "",
    interference: Interference | None = None,
    stop_at_fall: bool = True,
) -> Run:
    """Runs the whole chain for a time and returns everything that flowed.

    Args:
        leader: Force programme: built-in name, YAML file, or `none`.
        duration: Simulated time, a tick at least [s].
        parameters: See `Chain`.
        tick: Control tick [s].
        urdf: See `Chain`.
        interference: See `Chain`.
        stop_at_fall: End when the robot has fallen.

    Raises:
        ConfigurationError: An argument cannot be used.
    """  # fmt: skip
    settings = {} if parameters is None else parameters
    check_parameters(settings, NODES)
    programme = programme_of(leader)
    if programme is not None:
        settings = {**settings, LEADER: {"programme": programme, **settings.get(LEADER, {})}}
    ticks = ticks_of(duration, build(GraphConfig, {"tick": tick}).tick)
    without = (LEADER,) if programme is None else ()
    chain = Chain(settings, tick, urdf, without, interference)
    try:
        for _ in range(ticks):
            chain.advance()
            if stop_at_fall and chain.simulator.fall is not None:
                break
        return chain.finish()
    finally:
        chain.close()
