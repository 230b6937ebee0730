"""Why a run that is simulated again may come out differently, and what happened in it, for the user."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from follower_humanoid.bag.about import VERSIONS, versions
from follower_humanoid.core.yaml_file import parse_yaml
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.graph_config import LEADER
from follower_humanoid.graph.record import Adjusted, Run
from follower_humanoid.graph.wiring import NODES


def repetition_notes(
    run: Run,
    nodes: frozenset[str],
    resets: Iterable[int],
    adjusted: Iterable[Adjusted],
    applied: Iterable[str],
) -> Iterator[str]:
    """One sentence each.

    Args:
        run: The recorded run.
        nodes: Nodes that are simulated again.
        resets: Ticks at which the robot was put back on its feet.
        adjusted: Parameters changed while it ran.
        applied: Topics that tell what acted on the robot.
    """
    yield from _version_notes(run)
    yield from _gap_notes(run, applied)
    yield from _foreign_notes(run, nodes)
    yield from _frame_notes(run)
    if at := ", ".join(f"{tick * run.tick:.3f} s" for tick in sorted(resets)):
        yield f"the robot was put back on its feet at {at}"
    for change in adjusted:
        words = ", ".join(f"{name} = {value}" for name, value in change.values.items())
        yield f"{change.node}: {words} from {change.tick * run.tick:.3f} s on"
    yield from _holding_notes(run)


def _version_notes(run: Run) -> Iterator[str]:
    try:
        recorded = parse_yaml(run.about.get(VERSIONS, ""), VERSIONS) or {}
    except ConfigurationError:
        recorded = {}
    here = versions()
    for name, version in recorded.items() if isinstance(recorded, dict) else ():
        if name in here and here[name] != version:
            yield f"recorded with {name} {version}, here is {here[name]}: the last bits may differ"


def _gap_notes(run: Run, applied: Iterable[str]) -> Iterator[str]:
    count = int(run["joint_states"].ticks[-1]) + 1
    for topic in applied:
        missing = count - len(np.unique(run[topic].ticks))
        if missing > 0:
            yield f"{topic}: {missing} of {count} ticks are missing; the wrench before is held there"


def _holding_notes(run: Run) -> Iterator[str]:
    beginnings = [holding for holding in run.holding if holding.topics]
    if not beginnings:
        return
    listed = ", ".join(sorted({topic for holding in beginnings for topic in holding.topics}))
    first, times = beginnings[0].tick * run.tick, len(beginnings)
    yield f"the motor drives held {times} times for want of {listed}, first at {first:.3f} s"


def _foreign_notes(run: Run, nodes: frozenset[str]) -> Iterator[str]:
    for name in sorted(NODES.keys() - nodes - {LEADER}):
        topics = [topic for topic in NODES[name].outputs.values() if topic in run]
        if topics:
            yield f"{name} was somebody else's: what it published is taken from the bag ({', '.join(topics)})"


def _frame_notes(run: Run) -> Iterator[str]:
    for topic in ("leader/left_hand/wrench", "leader/right_hand/wrench", "base/push"):
        frames = set(run[topic].texts["frame"]) - {"", "world"} if topic in run else set()
        if frames:
            listed = ", ".join(sorted(frames))
            yield f"{topic} came in axes of {listed}; what is repeated is its mean over each tick in world"
