"""Runs of the arm on its fixed trunk, with forces on the hand and modes over time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from follower_humanoid.arm_experiment.measures import ArmTrace, arm_trace
from follower_humanoid.arm_experiment.simulate import arm_chain
from follower_humanoid.control.arm_modes import COMPENSATION, IMPEDANCE
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.simulate import Chain

Force = Callable[[float], Array | None]
__all__ = ["COMPENSATION", "IMPEDANCE", "drive", "free_arm", "nobody", "random_pushes"]


def nobody(time: float) -> Array | None:
    return None


def drive(chain: Chain, seconds: float, force: Force, modes: dict[float, str] | None = None) -> Run:
    """Runs a chain with a force on the left gripper (axes of world) and changes of mode at their times."""
    simulator, arms = chain.simulator, chain.components["arm_controller"]
    step, tick = simulator.advance, chain.tick_length
    changes = {round(time / tick): mode for time, mode in (modes or {}).items()}

    def advance(inputs: Any) -> None:
        newton = force(simulator.time)
        pull = None if newton is None else Wrench(np.asarray(newton, dtype=float), np.zeros(3))
        step(inputs._replace(leader_left=pull))

    simulator.advance = advance
    try:
        for number in range(round(seconds / tick)):
            if number in changes:
                arms.reconfigure(replace(arms._config, mode=changes[number]))
            chain.advance()
            if simulator.fall is not None:
                break
        return chain.finish()
    finally:
        chain.close()


def free_arm(
    seconds: float, force: Force, mode: str = IMPEDANCE, *, modes: dict[float, str] | None = None,
    tick: float = 0.002, task: bool = False, **parameters: Any,
) -> tuple[Run, ArmTrace]:  # fmt: skip
    """The arm alone, without a task unless asked for."""
    absent = ("leader",) if task else ("leader", "arm_task")
    chain = arm_chain(
        "compliance", {"arm_controller": {"mode": mode, **parameters}}, tick=tick, without=absent
    )
    run = drive(chain, seconds, force, modes)
    return run, arm_trace(run)


def random_pushes(seed: int, top: float, end: float) -> Force:
    """Pushes of random direction, size up to `top` [N] and length, with pauses, until `end` [s]."""
    rng = np.random.default_rng(seed)
    found, time = [], 0.1
    while time < end:
        length = rng.uniform(0.1, 0.5)
        direction = rng.normal(size=3)
        found.append((time, time + length, rng.uniform(2.0, top) * direction / np.linalg.norm(direction)))
        time += length + rng.uniform(0.05, 0.3)
    return lambda now: next((force for begin, until, force in found if begin <= now < until), None)
