"""The measuring of speed: bare physics walks the same walk, shares and courses are worked out rightly."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from graph_bench import wait_until

from follower_humanoid.bench.growth import Course, _walk
from follower_humanoid.bench.placement import Placed, cpu_of_children, memory_of_children
from follower_humanoid.bench.speed import messaging_share
from follower_humanoid.bench.spent import spent_of
from follower_humanoid.bench.tape import Tape
from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.plant import bullet_kernels


def test_the_tape_walks_the_same_walk():
    ticks = 25
    chain = Chain({"leader": {"programme": "fig4"}}, 0.002)
    for _ in range(ticks):
        chain.advance()
    walked = chain.simulator.plant.q.copy()
    chain.close()
    tape = Tape("fig4", ticks, 0.002)
    cost = tape.play()
    assert cost.cpu > 0.0
    np.testing.assert_array_equal(tape.state, walked)


def test_what_a_chain_spends_its_time_on():
    watched, plain = (Chain({"leader": {"programme": "fig4"}}, 0.002) for _ in range(2))
    kernel = bullet_kernels.step
    spent = spent_of(watched, 25)
    for _ in range(25):
        plain.advance()
    assert all(wall > 0.0 for wall in spent.parts().values())
    assert bullet_kernels.step is kernel  # the clocks are gone
    np.testing.assert_array_equal(watched.simulator.plant.q, plain.simulator.plant.q)
    watched.close()
    plain.close()


def test_time_is_told_of_where_it_went():
    model = pin.buildSampleModelHumanoid()
    data, q = model.createData(), pin.neutral(model)

    class Passes:
        def advance(self):
            for _ in range(50):
                pin.crba(model, data, q)

    spent = spent_of(Passes(), 20)
    assert spent.bullet == spent.kernels == 0.0
    assert spent.pinocchio > 0.0 and spent.python > 0.0


def placed(**cpu):
    return Placed(wall=1.0, cpu=cpu, start_up=1.0, memory={}, values={})


def test_messaging_is_what_the_components_do_not_use():
    runs = [placed(simulator=3.0, leg_controller=1.0), placed(simulator=3.5, leg_controller=1.5)]
    nodes = {"simulator": [1.0, 1.5, 2.0], "leg_controller": [0.75]}
    assert messaging_share(runs, nodes) == pytest.approx(1.0 - 2.25 / 4.5)


def test_memory_is_told_of_the_processes_that_one_has_started():
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(3600)"])
    try:
        assert wait_until(lambda: "-c" in memory_of_children(os.getpid()))  # until then it is still this one
        data = memory_of_children(os.getpid(), "Pss_Anon")["-c"]
        assert memory_of_children(os.getpid())["-c"] > data > 0
        assert cpu_of_children(os.getpid()) >= 0.0
    finally:
        process.kill()
        process.wait()


def test_a_course_knows_its_pace_and_its_memory():
    course = Course()
    for second in range(101):
        course.simulated.append(float(second))
        course.wall.append(2.0 * second if second <= 50 else 100.0 + 4.0 * (second - 50))
        course.cpu.append(2.0 * second if second <= 50 else 100.0 + 3.0 * (second - 50))
        course.memory.append(100 if second < 60 else 110)
    assert course.pace(course.wall, 0.0, 0.5) == pytest.approx(2.0)
    assert course.pace(course.wall, 0.5, 1.0) == pytest.approx(4.0)
    assert course.slower_at_the_end() == pytest.approx(1.5)
    assert course.memory_since(10.0) == pytest.approx(1.1)
    assert course.memory_since(60.0) == pytest.approx(1.0)


def test_the_programme_pulls_to_the_end(tmp_path):
    file = tmp_path / "walk.yaml"
    file.write_text(_walk(65.0))
    times = [line["until"] for line in read_yaml(file)]
    assert times == sorted(times)
    assert times[-1] >= 65.0
