"""Runs a recorded run again, from what its bag carries.

Everything that acted on the robot from outside is in the bag: the parameters, the URDF, and per tick
the wrenches that people and the leader applied. What is taken from the bag:

- the applied wrenches, in the place of the leader and of people;
- parameters that were changed during the run, at their ticks;
- motor commands that came too late in real time, or not at all from a deactivated controller, so that
  the drives held;
- resets, told by the robot standing as at time 0 again;
- the topics of nodes that were not this package's own (`bringup --without NODE`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from follower_humanoid.core.samples import Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.graph_config import LEADER
from follower_humanoid.graph.record import Adjusted, Run, RunRecorder, Series, samples_of
from follower_humanoid.graph.repeatable import APPLIED, Recorded
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.graph.wiring import NODES, SIMULATOR, NodeWiring
from follower_humanoid.robot.model import RobotModel

SEQUENCE = "sequence.yaml"
_COMPOSITION = "motion_composition"
_COMMANDS = {topic: name for name, topic in NODES[SIMULATOR].inputs.items() if topic.endswith("/command")}
Keep = Callable[[Run, RobotModel], RunRecorder]
"""Makes a recorder for a repetition of a run by a robot."""


class Repetition(Chain):
    """The chain with the recorded wrenches in the place of the leader and of people."""

    def __init__(self, recorded: Recorded, folder: Path, keep: Keep | None = None) -> None:
        """Makes the components.

        Args:
            recorded: What is repeated.
            folder: Where the URDF may be written to.
            keep: Makes what takes the samples in; None: nothing is kept.
        """
        self._recorded = recorded
        urdf = folder / "robot.urdf"
        urdf.write_text(recorded.run.urdf, encoding="utf-8")
        parameters = _with_carried_sequence(recorded, folder)
        absent = tuple(name for name in NODES if name == LEADER or name not in recorded.nodes)
        more = tuple(recorded.table.keys() - NODES.keys())
        super().__init__(parameters, recorded.run.tick, str(urdf), absent, more=more)
        self.recorder = (keep or _no_recorder)(recorded.run, self.robot)
        self._changes: dict[int, list[Adjusted]] = {}
        for change in recorded.adjusted:
            self._changes.setdefault(change.tick, []).append(change)
        self._holding = {holding.tick: holding for holding in recorded.run.holding}
        self._without: tuple[str, ...] = ()
        self._said = {t: frozenset(recorded.run[t].ticks.tolist()) for t in _COMMANDS if t in recorded.run}
        self._held = {
            name: _Held(recorded.run[topic], recorded.ticks) for name, topic in APPLIED.items()
        }
        self._foreign = {
            topic: samples_of(recorded.run[topic])
            for name in absent
            if name != LEADER
            for topic in NODES[name].outputs.values()
            if topic in recorded.run
        }

    def advance(self) -> None:
        """One control tick, or the reset that took its place."""
        for change in self._changes.get(self.tick, ()):
            self.adjust(change.node, change.values)
        if self.tick in self._holding:
            self._without = self._holding[self.tick].topics
            self.recorder.hold(self._holding[self.tick])
        for topic, samples in self._foreign.items():
            if self.tick in samples:
                self._flow.setdefault(self.tick, {})[topic] = samples[self.tick]
                self.recorder.add(topic, self.tick, samples[self.tick])
        if self.tick + 1 in self._recorded.resets:
            self._reset()
        else:
            super().advance()

    def publish_state(self) -> None:
        """The state of a tick that nobody steps any more: the last one of the run."""
        self._publish(NODES[SIMULATOR], self.simulator.observe())

    def close(self) -> None:
        """Ends the physics engine and whatever is being written."""
        super().close()
        self.recorder.close()

    def _reset(self) -> None:
        """The robot stands at the next tick, everyone else is new and knows nothing from before."""
        self.publish_state()
        self.simulator.reset()
        self._flow.clear()
        self.components = {
            node.name: self.simulator if node.name == SIMULATOR else self._make(node) for node in self.nodes
        }
        self.tick += 1

    def _is_idle(self, node: NodeWiring) -> bool:
        """A controller that was deactivated: what only came too late was recorded all the same."""
        missing = [topic for topic in node.outputs.values() if topic in self._without]
        return any(self.tick not in self._said.get(topic, ()) for topic in missing)

    def _inputs(self, node: Any) -> Any:
        inputs = super()._inputs(node)
        if node.name != SIMULATOR:
            return inputs
        # The state of a tick tells what acted in the tick before it.
        wrenches = {name: held.at(self.tick + 1) for name, held in self._held.items()}
        missing = {_COMMANDS[topic]: None for topic in self._without if topic in _COMMANDS}
        return inputs._replace(**wrenches, **missing)


def _with_carried_sequence(recorded: Recorded, folder: Path) -> Mapping[str, Mapping[str, Any]]:
    """The parameters with the sequence that the bag carries: a path in a bag is never followed.

    Raises:
        ConfigurationError: The run had a sequence of its own, and the bag does not carry it.
    """
    composition = recorded.parameters.get(_COMPOSITION, {})
    if not composition.get("sequence"):
        return recorded.parameters
    if SEQUENCE not in recorded.run.about:
        raise ConfigurationError(f"the bag carries no {SEQUENCE}, which its parameters ask for")
    path = folder / SEQUENCE
    path.write_text(recorded.run.about[SEQUENCE], encoding="utf-8")
    return {**recorded.parameters, _COMPOSITION: {**composition, "sequence": str(path)}}


class _NoRecorder(RunRecorder):
    """Keeps nothing: what a repetition of hours needs is one tick at a time."""

    def add(self, topic: str, tick: int, sample: Any) -> None:
        """Forgets the sample."""


def _no_recorder(run: Run, robot: RobotModel) -> RunRecorder:
    return _NoRecorder(run.tick, robot.joint_names, robot.urdf)


class _Held:
    """A recorded wrench by tick; where a tick is missing, that of the tick before."""

    def __init__(self, series: Series, count: int) -> None:
        rows = series.latest(np.arange(count + 1))
        self._force, self._torque, self._rows = series.force, series.torque, rows
        self._count = count

    def at(self, tick: int) -> Wrench | None:
        if tick >= self._count or self._rows[tick] < 0:
            return None
        row = self._rows[tick]
        return Wrench(self._force[row], self._torque[row])
