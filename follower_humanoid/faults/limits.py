"""Too much of everything: forces, voltages, references and walking parameters beyond their limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from follower_humanoid.bench.check import Check
from follower_humanoid.core.config import build, parameters_of
from follower_humanoid.core.samples import Array, Gait, Joints, Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.graph.node_configs import config_classes, node_names
from follower_humanoid.graph.simulate import TICK, Chain

Interference = Callable[[str, int, Any], Any]
STANDING = {"leader": {"programme": "fig4"}}


def chain_with(interference: Interference, seconds: float, leader: bool = False) -> tuple[Chain, str]:
    """Runs the ROS-free chain under an interference; returns it, closed, and what went wrong."""
    chain = Chain(without=() if leader else ("leader",), interference=interference)
    fault = ""
    try:
        for _ in range(round(seconds / TICK)):
            chain.advance()
            if chain.simulator.fall is not None:
                fault = f"fell at {chain.simulator.fall.time:.2f} s: {chain.simulator.fall.reason}"
                break
    except Exception as error:  # whatever it is: nothing may break
        fault = f"{type(error).__name__} at {chain.simulator.time:.3f} s: {error}"
    finally:
        chain.close()
    return chain, fault


def beyond_limits(effort: Effort) -> Iterator[Check]:
    """A line per limit."""
    yield from huge_pulls(effort)
    yield huge_commands()
    yield huge_gait(effort)
    yield out_of_range()


def huge_pulls(effort: Effort) -> Iterator[Check]:
    """A hand pulled with 1e300 N for 20 ms: the limiter's 200 N act."""

    def pulled(topic: str, tick: int, sample: Any) -> Any:
        if topic == "leader/left_hand/wrench" and 100 <= tick < 110:
            return Wrench(np.array([0.0, 0.0, 1e300]), np.full(3, -1e300))
        return sample

    chain, fault = chain_with(pulled, effort.count(1, 4), leader=True)
    cut = chain.simulator.diagnostics()["limited_wrenches_left_hand"]
    strongest = float(np.abs(chain.finish()["left_hand/applied"].force).max())
    good = not fault and strongest <= 200.0 * (1 + 1e-9) and int(cut) > 0
    observed = fault or f"{strongest:.1f} N acted, {cut} ticks counted"
    yield survived("1e300 N on a hand for 20 ms", "cut to 200 N, counted, stands", observed, good)


def huge_commands() -> Check:
    """Voltages and references far beyond range for 10 ms, then none: the drives hold within the range."""

    def commanded(topic: str, tick: int, sample: Any) -> Any:
        if topic == "arms/command" and 50 <= tick < 55:
            return Joints(*(np.full(14, value) for value in (1e300, -1e300, 1e300)))
        return None if topic == "arms/command" and tick >= 55 else sample

    chain, fault = chain_with(commanded, 0.4)
    count = chain.simulator.diagnostics()["limited_references"]
    arms = chain.robot.groups.arms
    last: Array = chain.finish()["joint_states"].position[-1][arms]
    inside = bool(((last > chain.robot.lower[arms] - 0.05) & (last < chain.robot.upper[arms] + 0.05)).all())
    observed = fault or f"joints {'within' if inside else 'outside'} their range, {count} references cut"
    return survived(
        "voltages and references of ±1e300", "cut, counted; joints in range", observed,
        not fault and inside and int(count) > 0,
    )  # fmt: skip


def huge_gait(effort: Effort) -> Check:
    """Walking parameters of any size, standing and while they change at every update."""
    rng = np.random.default_rng(3)
    sizes = (0.0, -1.0, 1e-300, 1e3, -1e300, 1e300)

    def asked(topic: str, tick: int, sample: Any) -> Any:
        if topic != "gait" or not isinstance(sample, Gait):
            return sample
        wild = rng.choice(sizes, 4)
        return replace(
            sample, walk_dir=float(wild[0]), step_length=float(wild[1]), step_height=float(wild[2]),
            heading=float(wild[3]),
        )  # fmt: skip

    seconds = effort.count(1, 10)
    chain, fault = chain_with(asked, seconds)
    count = chain.components["motion_composition"].diagnostics()["gait_limited_ticks"]
    observed = fault or f"stands, {count} ticks counted"
    return survived(
        "gait of ±1e300 at every update", "cut, counted, stands", observed, not fault and count > 0
    )


def out_of_range() -> Check:
    """Every parameter of every node, just outside of its range, and not a number."""
    tried, wrong = 0, []
    for node in node_names():
        for config in config_classes(node):
            for info in parameters_of(config):
                for value in (info.low, info.high):
                    if value is None or isinstance(info.default, bool):
                        continue
                    outside = value - 1.0 if value == info.low else value + 1.0
                    for bad in (outside, float("nan"), float("inf")):
                        tried += 1
                        wrong += _accepted(config, info.name, bad, info.default)
    observed = f"{tried} refused" if not wrong else f"accepted or unnamed: {', '.join(wrong[:5])}"
    required = "each refused with name, value and bounds"
    return survived("parameters out of their range", required, observed, not wrong)


def _accepted(config: type, name: str, bad: float, default: Any) -> list[str]:
    value = [bad] * len(default) if isinstance(default, tuple) else bad
    try:
        build(config, {name: value})
    except ConfigurationError as error:
        told = name in str(error) and ("valid" in str(error) or "finite" in str(error))
        return [] if told else [name]
    return [name]
