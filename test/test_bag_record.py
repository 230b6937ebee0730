"""A run in memory keeps what was added to it."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.core.samples import Joints, Point, Polygon, Wrench
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.record import Run, RunRecorder

TICK = 0.002


def joints(value: float) -> Joints:
    return Joints(np.full(45, value), np.zeros(45), np.zeros(45))


def recorded(count: int = 5) -> Run:
    recorder = RunRecorder(TICK, tuple(f"j{i}" for i in range(45)), "<robot/>", {"seed": "3"})
    for tick in range(count):
        recorder.add("joint_states", tick, joints(0.1 * tick))
        recorder.add("base/push", tick, Wrench(np.zeros(3), np.zeros(3), "torso"))
        if tick % 2 == 0:
            recorder.add("com", tick, Point(np.array([tick, 0.0, 0.8])))
            recorder.add("support_polygon", tick, Polygon(np.zeros((tick + 3, 3))))
    return recorder.finish()


def test_fields_are_stacked_in_order() -> None:
    run = recorded()
    assert run["joint_states"].position.shape == (5, 45)
    np.testing.assert_array_equal(run["joint_states"].position[:, 7], 0.1 * np.arange(5))
    np.testing.assert_array_equal(run["com"].ticks, [0, 2, 4])
    np.testing.assert_array_equal(run["com"].stamps, [0, 4_000_000, 8_000_000])
    assert run["base/push"].texts["frame"] == ("torso",) * 5
    assert run.duration == pytest.approx(4 * TICK)


def test_irregular_samples_stay_objects() -> None:
    series = recorded()["support_polygon"]
    assert [len(polygon.vertices) for polygon in series.samples] == [3, 5, 7]


def test_a_slow_topic_is_held_and_unknown_before_its_first_sample() -> None:
    series = recorded()["com"]
    held = series.held("xyz", np.array([-1, 0, 1, 3, 9]))
    assert np.isnan(held[0]).all()
    np.testing.assert_array_equal(held[1:, 0], [0, 0, 2, 4])


def test_hash_sees_the_last_bit() -> None:
    first, second = recorded(), recorded()
    assert first.joint_hash() == second.joint_hash()
    second["joint_states"].position[3, 3] = np.nextafter(second["joint_states"].position[3, 3], 1.0)
    assert first.joint_hash() != second.joint_hash()


def test_a_topic_that_was_not_recorded_is_named() -> None:
    with pytest.raises(UnknownNameError, match="odom"):
        recorded()["odom"]


def test_a_changing_size_is_refused() -> None:
    recorder = RunRecorder(TICK, (), "")
    recorder.add("joint_states", 0, joints(0.0))
    recorder.add("joint_states", 1, Joints(np.zeros(3), np.zeros(3), np.zeros(3)))
    with pytest.raises(ConfigurationError, match="joint_states"):
        recorder.finish()
