"""A simulator in a process of its own gives the same bits, the same words, and an end where there is one."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
from contextlib import contextmanager

import numpy as np
import pytest
from plant_bench import Holding, plant_from, robot

from follower_humanoid.core.config import build
from follower_humanoid.core.samples import Wrench
from follower_humanoid.errors import ConfigurationError, PhysicsError
from follower_humanoid.plant.remote_simulator import PHYSICS_CPU, RemoteSimulator, serve
from follower_humanoid.plant.simulator import SimulatorConfig, SimulatorInputs

PERIOD = 0.002
PATIENCE = 300.0


@contextmanager
def server():
    """A process that serves, and our end of the line to it."""
    mine, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)

    def live() -> None:
        mine.close()
        serve(its)

    process = multiprocessing.get_context("fork").Process(target=live)
    process.start()
    its.close()
    try:
        yield mine, process
    finally:
        mine.close()
        if process.is_alive():
            os.kill(process.pid, signal.SIGCONT)
        process.join()  # it ends by itself: else this never does


def remote(line, patience=PATIENCE, period=PERIOD, **values):
    named = {name.replace("__", "."): value for name, value in values.items()}
    return RemoteSimulator(line, patience, build(SimulatorConfig, named, "simulator"), "", robot(), period)


def assert_same(one, other):
    for name, here, there in zip(one._fields, one, other, strict=True):
        assert (here is None) == (there is None), name
        if here is None:
            continue
        assert type(here) is type(there)
        for field in type(here).__dataclass_fields__:
            a, b = getattr(here, field), getattr(there, field)
            assert a == b if isinstance(a, str) else a.tobytes() == b.tobytes(), f"{name}.{field}"


@pytest.mark.parametrize("board", [{}, {"board__stiffness": 1000.0}])
def test_the_same_bits_as_in_this_process(board):
    here = plant_from({name.replace("__", "."): value for name, value in board.items()})
    holding = Holding(here, 200.0, 5.0)
    with server() as (line, _):
        there = remote(line, **board)
        assert_same(here.observe(), there.observe())
        for n in range(60):
            pull = Wrench(np.array([20.0 * np.sin(0.05 * n), 5.0, -10.0]), np.zeros(3), "torso")
            inputs = holding.inputs(here.observe(), leader_left=pull if n % 3 else None)
            here.advance(inputs)
            there.advance(inputs)
            assert_same(here.observe(), there.observe())
        here.reset()
        there.reset()
        assert_same(here.observe(), there.observe())
        told = there.diagnostics()
        assert told.pop(PHYSICS_CPU) > 0.0
        assert told == here.diagnostics()
        assert there.voltage_limit == here.plant.motors.voltage_limit
        there.close()
    here.close()


def test_a_fall_is_told_from_there():
    with server() as (line, _):
        there = remote(line)
        assert there.fall is None
        shove = Wrench(np.array([0.0, 150.0, 0.0]), np.zeros(3))
        for _ in range(2000):
            there.advance(SimulatorInputs(push=shove))
            there.observe()
            if there.fall is not None:
                break
        assert there.fall is not None
        assert there.fall.time > 0.0


def test_what_cannot_be_made_is_refused_in_the_same_words():
    with server() as (line, _):
        with pytest.raises(ConfigurationError, match="must be a whole number of physics steps") as there:
            remote(line, period=0.0015)
        with pytest.raises(ConfigurationError) as here:
            plant_from({}, period=0.0015)
        assert str(there.value) == str(here.value)
        assert remote(line).observe().odometry.position[2] > 0.5  # and asked again it is made


def test_an_error_in_a_step_comes_out_where_its_state_is_asked_for():
    with server() as (line, _):
        there = remote(line)
        there.advance(SimulatorInputs(push=Wrench(np.full(3, np.nan), np.zeros(3))))
        with pytest.raises(PhysicsError, match="finite"):
            there.observe()


def test_the_end_of_its_process_is_noticed():
    with server() as (line, process):
        there = remote(line)
        told = there.diagnostics()
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        there.advance(SimulatorInputs())
        assert there.diagnostics() == told  # what it said last
        for ask in (there.observe, there.reset, lambda: there.advance(SimulatorInputs())):
            with pytest.raises(PhysicsError, match="is gone"):
                ask()
        there.close()


def test_silence_is_not_waited_for_for_ever():
    with server() as (line, process):
        there = remote(line, patience=0.05)
        os.kill(process.pid, signal.SIGSTOP)
        there.advance(SimulatorInputs())
        for _ in range(2):  # nothing is asked again of who has been silent: its late answers would be others'
            with pytest.raises(PhysicsError, match=r"silent for 0\.05 s"):
                there.observe()
            os.kill(process.pid, signal.SIGCONT)
        assert there.diagnostics() == {}


def test_making_it_takes_what_it_takes():
    with server() as (line, _):
        remote(line, patience=1e-3)
        remote(line)


def test_an_answer_that_nobody_wants_is_no_error():
    with server() as (line, process):
        remote(line).advance(SimulatorInputs())
        line.close()
        process.join()
        assert process.exitcode == 0


def test_frames_are_known_without_asking():
    with server() as (line, _):
        there = remote(line)
        assert there.knows_frame("")
        assert there.knows_frame("l_gripper")
        assert not there.knows_frame("nowhere")
