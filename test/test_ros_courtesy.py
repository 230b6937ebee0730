"""Who makes what everybody waits for gives way to nobody; who only looks on gives way to all."""

from __future__ import annotations

import multiprocessing
import os

import pytest

from follower_humanoid.ros.courtesy import give_way


def scheduling(nodes, aside, told):
    before = os.nice(0)
    give_way(nodes, aside)
    told.put((os.nice(0) - before, os.sched_getscheduler(0) == os.SCHED_BATCH))


def scheduled(nodes, aside=False):
    context = multiprocessing.get_context("fork")
    told = context.SimpleQueue()
    process = context.Process(target=scheduling, args=(nodes, aside, told))
    process.start()
    found = told.get()
    process.join()
    return found


@pytest.mark.parametrize("name", ["simulator", "leg_controller", "arm_controller"])
def test_who_everybody_waits_for_is_woken_at_once(name):
    assert scheduled([name]) == (0, False)
    assert scheduled(["motion_composition", name]) == (0, False)


@pytest.mark.parametrize("name", ["motion_composition", "zmp_balance", "leader", "recorder"])
def test_others_wait_until_nobody_else_would(name):
    niceness, batch = scheduled([name])
    assert 0 < niceness < scheduled([], aside=True)[0]
    assert batch
