"""An hour of walking with seeded random pulls, pauses, turns and pushes, recorded in bags.

`python -m follower_humanoid.faults.soak --minutes 60 --seed 5` does it alone, says every simulated minute
how it goes, and can be given in pieces: other seeds, fewer minutes.
"""

from __future__ import annotations

import argparse
import shutil
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
_BAG = 10  # minutes in one bag


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


class _Bags:
    """One bag after the other, each of ten simulated minutes, looked at when it is full.

    Attributes:
        states: In all of them.
        size: Of all of them [bytes].
        notes: What is missing, one sentence each.
    """

    def __init__(self, chain: Chain, folder: Path, keep: bool) -> None:
        """Args: whose recorder they are, where they go, and whether they stay."""
        self._chain, self._folder, self._keep = chain, folder, keep
        self._like, self._robot = simulate("none", 2 * TICK), RobotModel()
        self._path = folder
        self._bag: SimulatedBag | None = None
        self.states = self.size = 0
        self.notes: list[str] = []

    def begin(self) -> None:
        """Ends the one that is open, and begins another."""
        self.end()
        self._path = self._folder / f"bag_at_{self._chain.tick * TICK:.0f}"
        self._chain.recorder = self._bag = SimulatedBag(self._path, None, self._like, self._robot)

    def end(self) -> None:
        """Closes the one that is open and looks at it."""
        if self._bag is None:
            return
        self._bag.close()
        self._bag = None
        index = index_bag(self._path)
        self.states += index.topics["/joint_states"].count
        self.size += sum(file.stat().st_size for file in self._path.iterdir())
        self.notes += index.notes
        if not self._keep:
            shutil.rmtree(self._path)


def soak(effort: Effort) -> Iterator[Check]:
    """Lines for the walk, for its memory and for its bags."""
    minutes = 0.2 if effort.brief else MINUTES
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder:
        yield from walk(minutes, SEED, Path(folder), _tell)


def walk(
    minutes: float, seed: int, folder: Path, say: Callable[[str], None], keep: bool = False
) -> Iterator[Check]:
    """Walks under a random leader.

    Args:
        minutes: Simulated.
        seed: Of the leader.
        folder: Of the bags.
        say: Told every simulated minute how it goes.
        keep: The bags stay, 100 MB a minute.
    """
    chain = Chain(interference=RandomLeader(seed))
    bags = _Bags(chain, folder, keep)
    ticks = round(minutes * 60.0 / TICK)
    settled, memory = min(_MINUTE, ticks // 2), 0.0
    begin = time.monotonic()
    try:
        while chain.tick < ticks and chain.simulator.fall is None:
            if chain.tick % (_BAG * _MINUTE) == 0:
                bags.begin()
            chain.advance()
            if chain.tick == settled:
                memory = resident_memory()
            if chain.tick % _MINUTE == 0:
                say(
                    f"{chain.tick // _MINUTE} min, {_half_steps(chain)} half-steps, "
                    f"{resident_memory():.0f} MiB, {time.monotonic() - begin:.0f} s of wall time"
                )
        fall, steps, grown = chain.simulator.fall, _half_steps(chain), resident_memory() - memory
    finally:
        chain.close()
        bags.end()
    what = f"{minutes:g} min of pulls, pauses, turns, pushes, seed {seed}"
    observed = f"{steps} half-steps" if fall is None else f"fell at {fall.time:.1f} s: {fall.reason}"
    yield survived(what, "no fall", observed, fall is None)
    observed = f"{grown:.1f} MiB since {settled * TICK:g} s, {memory:.0f} MiB then"
    yield survived("its memory", f"grows by less than {_MOST_GROWTH:g} MiB", observed, grown < _MOST_GROWTH)
    observed = f"{bags.states} states of {chain.tick} ticks, {bags.size / 1e6:.0f} MB"
    observed += "".join(f"; {note}" for note in bags.notes)
    good = bags.states == chain.tick and not bags.notes
    yield survived("its bags", "complete: a state per tick", observed, good)


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
    parser.add_argument("--bags", type=Path, help="folder in which the bags stay; default: none is kept")
    options = parser.parse_args(args)
    good = True
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder:
        kept: Path | None = options.bags
        for line in walk(options.minutes, options.seed, kept or Path(folder), _tell, kept is not None):
            mark = "ok  " if line.passed else "MISS"
            print(f"  {mark} {line.what:<46} {line.required:<40} {line.measured}", flush=True)
            good = good and line.passed
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
