"""An hour of walking with seeded random pulls, pauses, turns and pushes; two graphs side by side."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from typing import Any

import numpy as np

from follower_humanoid.bench.check import Check
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import graph_run, own_domain
from follower_humanoid.graph.record import RunRecorder
from follower_humanoid.graph.simulate import TICK, Chain

_SEED = 5
_PUSH = 50.0  # N for 0.1 s: 5 N·s
_PUSH_TIME = 0.1


class RandomLeader:
    """Pulls for some seconds, pauses, turns, and pushes now and then."""

    def __init__(self, seed: int) -> None:
        """Args: of all that is random."""
        self._rng = np.random.default_rng(seed)
        self._until = self._push_at = 0.0
        self._pull: Array = np.zeros(3)
        self._push: Array = np.zeros(3)
        self._heading = 0.0

    def __call__(self, topic: str, tick: int, sample: Any) -> Any:
        """An interference of the chain."""
        if topic == "leader/right_hand/wrench":
            self._decide(tick * TICK)
            return Wrench(self._pull, np.zeros(3))
        if topic == "base/push":
            since = tick * TICK - self._push_at
            return Wrench(self._push if 0.0 <= since < _PUSH_TIME else np.zeros(3), np.zeros(3))
        return sample

    def _decide(self, now: float) -> None:
        if now < self._until:
            return
        rng = self._rng
        self._until = now + rng.uniform(3.0, 15.0)
        self._heading += rng.uniform(-0.6, 0.6)
        size = 0.0 if rng.random() < 0.3 else rng.uniform(1.0, 6.0)
        self._pull = size * np.array([np.cos(self._heading), np.sin(self._heading), 0.0])
        angle = rng.uniform(0.0, 2.0 * np.pi)
        self._push = _PUSH * np.array([np.cos(angle), np.sin(angle), 0.0])
        self._push_at = now + rng.uniform(0.5, 2.5)


class Forgetful(RunRecorder):
    """Keeps nothing: an hour of everything would fill the memory by itself."""

    def add(self, topic: str, tick: int, sample: Any) -> None:
        """Forgets the sample."""


def soak(effort: Effort) -> Iterator[Check]:
    """A line for the walk, one for two graphs side by side."""
    yield _walk(effort.count(12, 3600))
    yield from _side_by_side(effort)


def _walk(seconds: float) -> Check:
    chain = Chain(interference=RandomLeader(_SEED))
    chain.recorder = Forgetful(TICK, chain.robot.joint_names, chain.robot.urdf)
    warm, memory = round(min(60.0, seconds / 2) / TICK), 0.0
    fault = ""
    try:
        for tick in range(round(seconds / TICK)):
            chain.advance()
            if tick == warm:
                memory = _memory()
            if chain.simulator.fall is not None:
                fault = f"fell at {chain.simulator.time:.1f} s: {chain.simulator.fall.reason}"
                break
        steps = chain.components["motion_composition"].diagnostics()["half_steps"]
    finally:
        chain.close()
    grown = _memory() - memory
    observed = fault or f"{steps} half-steps, memory grew by {grown:.0f} MiB"
    required = "no fall, memory grows by less than 20 MiB"
    return survived(
        f"{seconds:g} s of random pulls, pauses, turns, pushes",
        required,
        observed,
        not fault and grown < 20.0,
    )


def _memory() -> float:
    """Largest so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _side_by_side(effort: Effort) -> Iterator[Check]:
    """Two namespaces of one domain, and in the long form two domains: each walks as if it were alone."""
    options = ("--leader", "fig4", "--duration", "1", "--composed")
    domain = own_domain()
    yield _both("namespaces", (*options, "--namespace"), domain, domain)
    if not effort.brief:
        yield _both("domains", options, domain, domain % 100 + 1)


def _both(how: str, options: tuple[str, ...], first: int, second: int) -> Check:
    names = (("one",), ("two",)) if options[-1] == "--namespace" else ((), ())
    with (
        graph_run(*options, *names[0], domain=first) as one,
        graph_run(*options, *names[1], domain=second) as two,
    ):
        status = (one.status(), two.status())
        bags = [run.recorded() for run in (one, two)]
    hashes = {bag.joint_hash() for bag in bags if bag is not None and not bag.notes}
    good = status == (0, 0) and len(hashes) == 1 and None not in bags
    walk = "the same" if len(hashes) == 1 else "different"
    observed = f"status {status[0]} and {status[1]}, {walk} walk"
    return survived(f"two graphs in two {how}", "both walk as if alone", observed, good)
