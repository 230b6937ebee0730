"""Half-steps found in foot forces and sole poses of made-up walks."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from gait_bench import robot, vertical

from follower_humanoid.bench.kinematics import Motion
from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.graph.half_steps import half_steps
from follower_humanoid.graph.record import Run, RunRecorder

TICK = 0.01
WEIGHT = 716.0
# Side, lift-off, landing [s], length of the way along the heading [m].
WALK = ((Side.RIGHT, 1.0, 2.0, 0.25), (Side.LEFT, 3.0, 4.0, 0.50), (Side.RIGHT, 5.0, 6.0, 0.25))


class Walk:
    """A walk along a heading, by the forces under the feet and the places of the soles."""

    def __init__(self, heading: float = 0.0, duration: float = 7.0) -> None:
        ticks = round(duration / TICK)
        self.times = np.arange(ticks) * TICK
        self.load = {side: np.full(ticks, WEIGHT / 2) for side in SIDES}
        self.along = {side: np.zeros(ticks) for side in SIDES}
        self.height = {side: np.zeros(ticks) for side in SIDES}
        self.heading = heading

    def swing(self, side: Side, begin: float, end: float, way: float, lift: float = 0.05) -> Walk:
        u = np.clip((self.times - begin) / (end - begin), 0.0, 1.0)
        self.along[side] = self.along[side] + way * u
        self.height[side] = self.height[side] + 16 * lift * u**2 * (1 - u) ** 2
        air = (self.times >= begin - 1e-9) & (self.times < end - 1e-9)
        self.load[side][air] = 0.0
        self.load[side.other][air] = WEIGHT
        return self

    def found(self) -> list[tuple[Side, float, float, float, float, bool]]:
        steps = half_steps(self._run(), self._motion().sole_at)
        return [(s.side, s.lift_off, s.landing, s.length, s.heading, s.counted) for s in steps]

    def _run(self) -> Run:
        recorder = RunRecorder(TICK, robot().joint_names, robot().urdf)
        for side in SIDES:
            for tick, load in enumerate(self.load[side]):
                recorder.add(f"{side.value}_foot/wrench", tick, vertical(load))
        return recorder.finish()

    def _motion(self) -> Motion:
        c, s = math.cos(self.heading), math.sin(self.heading)

        def place(side: Side) -> Array:
            x, y = self.along[side], np.full(len(self.times), side.sign * 0.09)
            return np.column_stack((c * x - s * y, s * x + c * y, self.height[side]))

        values = dict.fromkeys(field.name for field in dataclasses.fields(Motion))
        values["times"] = self.times
        values["sole"] = {side: place(side) for side in SIDES}
        values["sole_yaw"] = {side: np.full(len(self.times), self.heading) for side in SIDES}
        return Motion(**values)


@pytest.mark.parametrize("heading", [0.0, 0.6435, -2.8])
def test_steps_are_found_with_times_lengths_and_heading(heading: float) -> None:
    walk = Walk(heading)
    for swing in WALK:
        walk.swing(*swing)
    found = walk.found()
    assert [step[0] for step in found] == [Side.RIGHT, Side.LEFT, Side.RIGHT]
    np.testing.assert_allclose([step[1] for step in found], [1.0, 3.0, 5.0], atol=1.5 * TICK)
    np.testing.assert_allclose([step[2] for step in found], [2.0, 4.0, 6.0], atol=1.5 * TICK)
    np.testing.assert_allclose([step[3] for step in found], [0.25, 0.25, 0.0], atol=1e-9)
    np.testing.assert_allclose([step[4] for step in found], heading)


def test_a_closing_step_is_not_counted_and_one_backward_is() -> None:
    walk = Walk(duration=9.0)
    for swing in (*WALK, (Side.LEFT, 7.0, 8.0, -0.2)):
        walk.swing(*swing)
    assert [step[5] for step in walk.found()] == [True, True, False, True]
    assert walk.found()[-1][3] == pytest.approx(-0.2)


def test_standing_is_no_step() -> None:
    assert Walk().found() == []


def test_a_foot_unloaded_without_being_lifted_has_not_stepped() -> None:
    walk = Walk().swing(Side.LEFT, 1.0, 1.3, 0.0, lift=0.004)
    assert walk.found() == []


def test_a_light_first_touch_does_not_end_the_step() -> None:
    walk = Walk().swing(*WALK[0])
    touch = (walk.times > 1.8) & (walk.times < 1.85)
    walk.load[Side.RIGHT][touch] = 60.0
    found = walk.found()
    assert len(found) == 1
    assert found[0][2] == pytest.approx(2.0, abs=1.5 * TICK)


def test_a_step_still_in_the_air_at_the_end_is_none() -> None:
    walk = Walk(duration=3.5)
    for swing in WALK[:2]:
        walk.swing(*swing)
    assert [step[0] for step in walk.found()] == [Side.RIGHT]


def test_a_foot_that_begins_in_the_air_has_not_lifted_off() -> None:
    walk = Walk()
    walk.height[Side.RIGHT][:80] = 0.05
    for swing in WALK:
        walk.swing(*swing)
    walk.load[Side.RIGHT][:80] = 0.0
    assert [step[1] for step in walk.found()] == pytest.approx([1.0, 3.0, 5.0], abs=1.5 * TICK)


def test_steps_come_in_the_order_of_landing() -> None:
    walk = Walk(duration=12.0)
    for k in range(5):
        walk.swing((Side.LEFT, Side.RIGHT)[k % 2], 1.0 + 2 * k, 2.0 + 2 * k, 0.4)
    found = walk.found()
    assert [step[0].value for step in found] == ["left", "right", "left", "right", "left"]
    assert [step[2] for step in found] == sorted(step[2] for step in found)
