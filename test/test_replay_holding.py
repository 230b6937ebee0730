"""A run whose motor drives held because commands came too late, simulated again: the same bits."""

from __future__ import annotations

import dataclasses
import os
import signal
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml
from graph_bench import bringup, wait_until

from follower_humanoid.bag.reader import read_run
from follower_humanoid.graph.record import Holding, Run
from follower_humanoid.graph.repeatable import repeatable
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.graph.wiring import NodeWiring
from follower_humanoid.replay.again import repeat, simulate_again
from follower_humanoid.ros.simulated_bag import SimulatedBag

TICKS = 120
LEGS, ARMS = "legs/command", "arms/command"
HOLDING = (
    Holding(1, (LEGS,)),
    Holding(2, ()),
    Holding(40, (LEGS, ARMS)),
    Holding(45, (ARMS,)),
    Holding(60, ()),
    Holding(80, (ARMS,)),  # deactivated
    Holding(100, ()),
)
LATE = {LEGS: {1, *range(40, 45)}, ARMS: set(range(40, 60))}
IDLE = range(80, 100)


class RunInRealTime(Chain):
    """Commands come too late now and then, and the arm controller is deactivated for a while."""

    def __init__(self) -> None:
        super().__init__({"leader": {"programme": "fig4"}}, interference=self._late)

    def _late(self, topic: str, tick: int, sample: Any) -> Any:
        if tick not in LATE.get(topic, ()):
            return sample
        self.recorder.add(topic, tick, sample)  # the recorder hears it all the same
        return None

    def _is_idle(self, node: NodeWiring) -> bool:
        return node.name == "arm_controller" and self.tick in IDLE


@pytest.fixture(scope="module")
def run() -> Run:
    chain = RunInRealTime()
    try:
        for _ in range(TICKS):
            chain.advance()
        about = {"parameters.yaml": yaml.safe_dump({"leader": {"ros__parameters": {"programme": "fig4"}}})}
        return dataclasses.replace(chain.finish(), about=about, holding=HOLDING)
    finally:
        chain.close()


def test_it_is_identical_bit_for_bit(run: Run) -> None:
    outcome = repeat(repeatable(run), verify=True)
    assert outcome.difference is None
    assert outcome.compared == TICKS


@pytest.mark.parametrize(("left_out", "tick"), [(0, 2), (2, 41), (5, 81)])
def test_without_knowing_of_it_the_next_tick_is_another(run: Run, left_out: int, tick: int) -> None:
    holding = tuple(entry for number, entry in enumerate(HOLDING) if number != left_out)
    outcome = repeat(repeatable(dataclasses.replace(run, holding=holding)), verify=True)
    assert outcome.difference is not None
    assert outcome.difference.tick == tick


def test_it_is_told(run: Run) -> None:
    told = [note for note in repeatable(run).notes if "drives held" in note]
    assert told == [
        "the motor drives held 4 times for want of arms/command, legs/command, first at 0.002 s"
    ]


def test_a_kept_repetition_carries_it_on(run: Run, tmp_path: Path) -> None:
    repeat(repeatable(run), verify=False, keep=partial(SimulatedBag, tmp_path / "bag", None))
    assert read_run(tmp_path / "bag").holding == HOLDING


def test_a_run_in_real_time_with_a_controller_held_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "bag"
    with bringup(tmp_path, "--realtime", "--bag", str(bag)) as running:
        running.wait_until_it_runs()
        controller = running.child("leg_controller")
        os.kill(controller, signal.SIGSTOP)
        assert wait_until(lambda: f"no {LEGS} of tick" in running.complained), running.complained
        os.kill(controller, signal.SIGCONT)
        later = running.time + 1.0
        assert wait_until(lambda: running.time > later or running.process.poll() is not None)  # it may fall
        running.end()
    holding = read_run(bag).holding
    assert any(LEGS in entry.topics for entry in holding)
    assert [entry.tick for entry in holding] == sorted(entry.tick for entry in holding)
    assert simulate_again(bag, None, verify=True) == 0
    assert "identical to the bag: joint positions of" in capsys.readouterr().out
