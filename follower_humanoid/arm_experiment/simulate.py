"""An arm experiment as one loop, without ROS: same objects, same wiring, same results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from follower_humanoid.arm_experiment.experiments import experiment
from follower_humanoid.graph.chain_arguments import ticks_of
from follower_humanoid.graph.config_file import load_parameters
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.simulate import TICK, Chain, Interference, Parameters
from follower_humanoid.graph.wiring import ARM_TASK, NODES


def arm_chain(
    name: str,
    parameters: Parameters | None = None,
    *,
    tick: float = TICK,
    interference: Interference | None = None,
    without: tuple[str, ...] = (),
) -> Chain:
    """The chain of an experiment.

    Args:
        name: `board` or `compliance`.
        parameters: Node → dotted parameter name → value, over the experiment's own.
        tick: Control tick [s].
        interference: See `Chain`.
        without: Nodes of the experiment that are left out.
    """  # fmt: skip
    chosen = experiment(name)
    settings: dict[str, dict[str, Any]] = load_parameters([chosen.parameter_file])
    if chosen.programme_file is not None:
        settings.setdefault("leader", {})["programme"] = str(chosen.programme_file)
    for node, values in (parameters or {}).items():
        settings.setdefault(node, {}).update(values)
    absent = tuple(node for node in (*NODES, ARM_TASK.name) if node not in chosen.nodes)
    return Chain(settings, tick, "", (*absent, *without), interference, (ARM_TASK.name,))


def simulate_arm(
    name: str,
    duration: float | None = None,
    parameters: Parameters | None = None,
    *,
    tick: float = TICK,
    interference: Interference | None = None,
    without: tuple[str, ...] = (),
    watch: Callable[[Chain], None] | None = None,
) -> Run:
    """Runs an experiment and returns everything that flowed; arguments as of `arm_chain`.

    Args:
        name, parameters, tick, interference, without: See `arm_chain`.
        duration: Simulated time, the experiment's own by default [s].
        watch: Called after each tick.

    Raises:
        ConfigurationError: An argument cannot be used.
    """  # fmt: skip
    chain = arm_chain(name, parameters, tick=tick, interference=interference, without=without)
    try:
        for _ in range(ticks_of(experiment(name).duration if duration is None else duration, tick)):
            chain.advance()
            if watch is not None:
                watch(chain)
        return chain.finish()
    finally:
        chain.close()
