"""The robot falls, or its physics break."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from follower_humanoid.bench.check import Check
from follower_humanoid.core.samples import Wrench
from follower_humanoid.errors import PhysicsError
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import graph_run
from follower_humanoid.faults.nodes import FELL, end_of, ended_well
from follower_humanoid.graph.simulate import TICK, Chain

LATEST = 0.2  # s from fallen to told


def falling(effort: Effort) -> Iterator[Check]:
    """Lines for a fall, for the motors then, and for broken physics; in the long form of a graph too."""
    yield from _shoved(effort)
    yield _broken()
    if not effort.brief:
        yield from in_a_graph()


def _shoved(effort: Effort) -> Iterator[Check]:
    directions = effort.count(1, 8)
    late, volts = [], []
    for number in range(directions):
        angle = 2.0 * np.pi * number / directions
        shove = Wrench(600.0 * np.array([np.cos(angle), np.sin(angle), 0.0]), np.zeros(3))
        chain = Chain(interference=_pushing(shove))
        try:
            late.append(_time_to_tell(chain))
            for _ in range(100):
                chain.advance()
            volts.append(float(np.abs(chain.simulator.plant.motors.voltage).max()))
        finally:
            chain.close()
    observed = f"told after {max(late):.3f} s at most, {directions} directions"
    yield survived("shoved over with 600 N", f"told within {LATEST} s", observed, max(late) <= LATEST)
    peak = max(volts)
    yield survived("motors of a fallen robot", "0 V: damped by their own", f"{peak:.1f} V", peak == 0.0)


def _pushing(shove: Wrench) -> Any:
    return lambda topic, tick, sample: shove if topic == "base/push" else sample


def _time_to_tell(chain: Chain) -> float:
    """From the first tick at which it lies, by a look of our own, to the fall being told [s]."""
    standing = float(chain.simulator.plant.q[2])
    lies_since = None
    for _ in range(round(10.0 / TICK)):
        chain.advance()
        simulator = chain.simulator
        lies = simulator.plant.q[2] < 0.6 * standing or simulator.plant.rotation[2, 2] < np.cos(np.pi / 4)
        if lies_since is None and lies:
            lies_since = simulator.time
        if simulator.fall is not None:
            return 0.0 if lies_since is None else simulator.time - lies_since
    return float("inf")


def _broken() -> Check:
    chain = Chain(without=("leader",))
    try:
        for _ in range(50):
            chain.advance()
        chain.simulator.plant.motors.current[3] = np.nan
        chain.advance()
        observed, good = "went on", False
    except PhysicsError as error:
        observed = str(error)
        good = f"{50 * TICK:.3f}"[:4] in observed and observed.endswith(f"in: {chain.robot.joint_names[3]}")
    finally:
        chain.close()
    return survived("not a number in the physics", "ends, says when and where it began", observed, good)


def in_a_graph() -> Iterator[Check]:
    """What bringup makes of a fall, and of broken physics."""
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder:
        shove = Path(folder) / "shove.yaml"
        shove.write_text(
            "- {until: 0.2}\n- {until: 0.6, base: [600, 0, 0]}\n- {until: 60}\n", encoding="utf-8"
        )
        with graph_run("--leader", str(shove)) as run:
            status, words, bag = run.status(), run.said, run.recorded()
    fell_at = float((re.findall(r"the robot fell at ([0-9.]+) s", words) or ["nan"])[0])
    after = float("nan") if bag is None else bag.duration - fell_at
    observed = f"status {status}, ends {after:.3f} s after the fall"
    good = status == FELL and abs(after - 1.0) < 0.01 and bag is not None and not bag.notes
    yield survived("a graph whose robot falls", "status 3, told, ends 1 s later, whole bag", observed, good)
    with graph_run("--leader", "fig4", "--without", "simulator") as run:
        command = [sys.executable, "-m", "follower_humanoid.faults.broken_simulator"]
        broken = subprocess.Popen(command, env=run.environment, stderr=subprocess.DEVNULL)
        try:
            status, said, observed = run.status(), run.said, end_of(run)
        finally:
            broken.terminate()
            broken.wait(60)
        good = status == 1 and "physics left the finite numbers at 0.10" in said and ended_well(run)
    yield survived(
        "a graph whose physics break", "status 1, told when and where", f"status {status}, {observed}", good
    )
