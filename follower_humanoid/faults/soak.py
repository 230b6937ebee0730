"""An hour of walking with seeded random pulls, pauses, turns and pushes, recorded in a bag.

`python -m follower_humanoid.faults.soak --minutes 60 --seed 5` does it alone, says every simulated minute
how it goes, and can be given in pieces: other seeds, fewer minutes.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from follower_humanoid.bench.check import Check
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.graph.simulate import TICK, Chain, simulate
from follower_humanoid.replay.index import index_bag
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.simulated_bag import SimulatedBag

SEED = 5
MINUTES = 60.0
_PUSH = 50.0  # N for 0.1 s: 5 N·s
_PUSH_TIME = 0.1
_MOST_GROWTH = 20.0  # MiB
_MINUTE = round(60.0 / TICK)


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


def soak(effort: Effort) -> Iterator[Check]:
    """Lines for the walk, for its memory and for its bag."""
    minutes = 0.2 if effort.brief else MINUTES
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder:
        yield from walk(minutes, SEED, Path(folder) / "bag", _tell)


def walk(minutes: float, seed: int, folder: Path, say: Callable[[str], None]) -> Iterator[Check]:
    """Walks under a random leader.

    Args:
        minutes: Simulated.
        seed: Of the leader.
        folder: The bag, which must not exist.
        say: Told every simulated minute how it goes.
    """
    chain = Chain(interference=RandomLeader(seed))
    bag = SimulatedBag(folder, None, simulate("none", 2 * TICK), RobotModel())
    chain.recorder = bag
    ticks = round(minutes * 60.0 / TICK)
    settled, memory = min(_MINUTE, ticks // 2), 0.0
    begin = time.monotonic()
    try:
        while chain.tick < ticks and chain.simulator.fall is None:
            chain.advance()
            if chain.tick == settled:
                memory = resident_memory()
            if chain.tick % _MINUTE == 0:
                walked, seconds = _half_steps(chain), time.monotonic() - begin
                say(
                    f"{chain.tick // _MINUTE} min, {walked} half-steps, {resident_memory():.0f} MiB, "
                    f"{seconds:.0f} s of wall time"
                )
        fall, steps, grown = chain.simulator.fall, _half_steps(chain), resident_memory() - memory
    finally:
        chain.close()
        bag.close()
    what = f"{minutes:g} min of pulls, pauses, turns, pushes"
    observed = f"{steps} half-steps" if fall is None else f"fell at {fall.time:.1f} s: {fall.reason}"
    yield survived(f"{what}, seed {seed}", "no fall", observed, fall is None)
    walked_on = f"{grown:.1f} MiB since {settled * TICK:g} s, of {memory:.0f} MiB"
    yield survived("its memory", f"grows by less than {_MOST_GROWTH:g} MiB", walked_on, grown < _MOST_GROWTH)
    index = index_bag(folder)
    states = index.topics["/joint_states"].count
    size = sum(file.stat().st_size for file in folder.iterdir()) / 1e6
    observed = f"{states} states of {chain.tick} ticks, {size:.0f} MB" + "".join(
        f"; {n}" for n in index.notes
    )
    good = states == chain.tick and not index.notes
    yield survived("its bag", "complete: a state per tick", observed, good)


def _half_steps(chain: Chain) -> int:
    return int(chain.components["motion_composition"].diagnostics()["half_steps"])


def resident_memory() -> float:
    """Of this process now [MiB]; a peak would hide growth behind what was there before."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * 4096 / 2**20


def _tell(text: str) -> None:
    print(f"       {text}", file=sys.stderr, flush=True)


def main(args: list[str] | None = None) -> int:
    """Walks; 0 = every line holds."""
    parser = argparse.ArgumentParser(prog="soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=MINUTES, help="simulated")
    parser.add_argument("--seed", type=int, default=SEED, help="of the leader")
    parser.add_argument(
        "--bag", type=Path, help="folder of the bag, which must not exist; default: none is kept"
    )
    options = parser.parse_args(args)
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder:
        good = True
        for line in walk(options.minutes, options.seed, options.bag or Path(folder) / "bag", _tell):
            mark = "ok  " if line.passed else "MISS"
            print(f"  {mark} {line.what:<46} {line.required:<40} {line.measured}", flush=True)
            good = good and line.passed
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
