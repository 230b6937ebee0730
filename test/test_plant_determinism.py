"""The same bits in every process, and several plants side by side."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from plant_bench import Holding, plant_from

from follower_humanoid.core.samples import Wrench


def motion_hash(ticks=300, companion=False):
    simulator = plant_from({})
    other = plant_from({"standing.hip_height": 0.8}) if companion else None
    holding, digest = Holding(simulator, 200.0, 5.0), hashlib.sha256()
    for n in range(ticks):
        pull = Wrench(np.array([20.0 * np.sin(0.05 * n), 5.0, -10.0]), np.zeros(3), "torso")
        simulator.advance(holding.inputs(simulator.observe(), leader_left=pull))
        if other is not None:
            other.advance(other.Inputs(push=pull))
        state = simulator.observe()
        for array in (state.joints.position, state.left_foot.force, state.left_wrist.torque):
            digest.update(array.tobytes())
    simulator.close()
    if other is not None:
        other.close()
    return digest.hexdigest()


def hash_elsewhere(ticks, **environment):
    program = f"import test_plant_determinism as t; print('hash', t.motion_hash({ticks}))"
    found = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parent,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return [line for line in found.stdout.splitlines() if line.startswith("hash ")]


def test_same_bits_in_another_process():
    assert hash_elsewhere(300, PYTHONHASHSEED="7") == [f"hash {motion_hash(300)}"]


def test_compiled_loops_and_plain_python_give_the_same_bits():
    assert hash_elsewhere(40, NUMBA_DISABLE_JIT="1") == [f"hash {motion_hash(40)}"]


def test_a_second_plant_in_the_process_changes_nothing():
    assert motion_hash(companion=True) == motion_hash()


def test_reset_repeats_the_motion():
    simulator = plant_from({})
    runs = []
    for _ in range(2):
        holding, track = Holding(simulator), []
        push = Wrench(np.array([30.0, 10.0, 0.0]), np.zeros(3))
        for _ in range(100):
            simulator.advance(holding.inputs(simulator.observe(), push=push))
            track.append(simulator.observe().joints.position)
        runs.append(np.array(track))
        simulator.reset()
    assert np.array_equal(runs[0], runs[1])
    simulator.close()


def test_a_reset_takes_one_tick_and_time_goes_on():
    simulator = plant_from({})
    for _ in range(3):
        simulator.advance(simulator.Inputs())
    simulator.reset()
    assert (simulator.tick, simulator.time) == (4, 0.008)
    q = simulator.plant.q.copy()
    q[2] = 0.4
    simulator.plant.bullet.place(q, np.zeros(51))
    simulator.advance(simulator.Inputs())
    assert simulator.fall.time == pytest.approx(0.010)
    simulator.close()
