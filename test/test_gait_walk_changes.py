"""Speed, direction, length and height may change at any instant: no jump, and the step comes out right."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, Tick, WalkerBench, always

from follower_humanoid.core.samples import Array, Gait, Side
from follower_humanoid.gait.feet import FootPose, half_step_length
from follower_humanoid.gait.walk_plan import WalkerConfig

CHANGES = {
    "length": replace(AHEAD, step_length=1.25),
    "shorter": replace(AHEAD, step_length=0.7),
    "speed": replace(AHEAD, walk_speed=1.5),
    "slower": replace(AHEAD, walk_speed=0.8),
    "height": replace(AHEAD, step_height=2.0),
    "direction": replace(AHEAD, walk_dir=0.2, heading=0.2),
    "sideways": replace(AHEAD, walk_dir=0.4),
    "all": Gait(1.2, -0.15, 1.1, 1.5, -0.15),
    "stop": STAND,
}
DT = 0.005
FREEZE = WalkerConfig().freeze


class Bench(WalkerBench):
    """Knows how far the present swing has come and records the channels' own derivatives."""

    def __init__(self) -> None:
        super().__init__(dt=DT)
        self.motion: list[Array] = []
        self._landed: list[tuple[Tick, FootPose, FootPose]] = []

    def tick(self, gait: Gait, loads: dict[Side, float] | None = None, steady: bool = True) -> Tick:
        before = self.walker.swinging
        tick = super().tick(gait, loads, steady)
        half = self.walker.half_step
        if half is not None and half.single_support and tick.landed is None:
            swing = half.swing
            channels = (swing.place, swing.height, swing.attitude)
            derivatives = ("position", "velocity", "acceleration")
            self.motion.append(
                np.array([np.concatenate([getattr(c, name) for c in channels]) for name in derivatives])
            )
        if tick.swinging is not None and before is None:
            self.motion.clear()
        if tick.landed is not None:
            feet = self.walker.feet
            self._landed.append((tick, feet[tick.landed], feet[tick.landed.other]))
        return tick

    def touchdowns(self) -> list[tuple[Tick, FootPose, FootPose]]:
        return self._landed

    def progress(self) -> float:
        half = self.walker.half_step
        return half.swing_progress if half is not None else 0.0

    def to_touchdown(self, gait: Gait) -> tuple[Tick, FootPose, FootPose]:
        """Walks on until the foot in the air has landed; the tick, the foot that landed, the other."""
        number = len(self._landed)
        while len(self._landed) == number:
            self.tick(gait)
        return self._landed[-1]


@cache
def _walked(progress: float) -> Bench:
    bench = Bench()
    while bench.progress() < progress:
        bench.tick(AHEAD)
    return bench


def in_the_first_swing(progress: float) -> Bench:
    """A walk whose first swing has come so far."""
    return copy.deepcopy(_walked(progress))


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("progress", [0.1, 0.6])
def test_a_change_during_the_swing_makes_no_jump(change: str, progress: float) -> None:
    bench = in_the_first_swing(progress)
    bench.to_touchdown(CHANGES[change])
    motion = np.array(bench.motion)  # (T, derivative, x y z yaw pitch)
    position, velocity, acceleration = (motion[:, k] for k in range(3))
    np.testing.assert_allclose(
        np.diff(position, axis=0), 0.5 * DT * (velocity[1:] + velocity[:-1]), atol=2e-6
    )
    np.testing.assert_allclose(
        np.diff(velocity, axis=0), 0.5 * DT * (acceleration[1:] + acceleration[:-1]), atol=5e-4
    )
    # An acceleration that jumped would change by its own size within one tick.
    assert np.abs(np.diff(acceleration, axis=0)).max() < 0.12 * np.abs(acceleration).max() + 0.02


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_early_in_the_swing_makes_the_step_that_is_asked_for(change: str) -> None:
    gait = CHANGES[change]
    bench = in_the_first_swing(0.3)
    start, left = bench.time, 1.0 - bench.progress()
    tick, landed, stance = bench.to_touchdown(gait)
    length = 0.40 * gait.step_length * math.cos(gait.walk_dir - gait.heading) if gait.walk_speed else 0.0
    assert half_step_length(landed, stance) == pytest.approx(length, abs=1e-9)
    assert landed.yaw == pytest.approx(gait.heading, abs=1e-9)
    # What was left of the swing passes at the new pace.
    pace = gait if gait.walk_speed > 0.0 else AHEAD
    expected = left * 0.613 * 3.1 * pace.step_length / pace.walk_speed
    assert tick.time - start == pytest.approx(expected, abs=3 * DT)
    np.testing.assert_allclose(bench.motion[-1][0, :2], landed.xy, atol=1e-4)
    np.testing.assert_allclose(bench.motion[-1][1], np.zeros(5), atol=1e-3)


def test_height_asked_for_while_the_foot_still_rises_is_reached() -> None:
    for progress in (0.05, 0.25):
        bench = in_the_first_swing(progress)
        bench.to_touchdown(CHANGES["height"])
        assert np.array(bench.motion)[:, 0, 2].max() == pytest.approx(0.10, rel=0.02)


@pytest.mark.parametrize("change", ["length", "direction", "sideways", "stop"])
def test_late_in_the_swing_the_landing_place_is_kept(change: str) -> None:
    bench = in_the_first_swing(FREEZE + 0.02)
    kept = bench.walker.landing
    _, landed, stance = bench.to_touchdown(CHANGES[change])
    assert landed == kept
    assert half_step_length(landed, stance) == pytest.approx(0.40, abs=1e-9)
    # The next step is as asked.
    _, following, other = bench.to_touchdown(CHANGES[change])
    length = {"length": 0.50, "direction": 0.40, "sideways": 0.40 * math.cos(0.4), "stop": 0.0}[change]
    assert half_step_length(following, other) == pytest.approx(length, abs=1e-9)


def test_until_then_it_follows_every_change() -> None:
    bench = in_the_first_swing(FREEZE - 0.02)
    _, landed, stance = bench.to_touchdown(CHANGES["length"])
    assert half_step_length(landed, stance) == pytest.approx(0.50, abs=1e-9)


def test_a_step_that_was_frozen_before_the_stop_counts_and_the_closing_one_does_not() -> None:
    bench = in_the_first_swing(FREEZE + 0.02)
    bench.run(8.0, always(STAND))
    assert [counted for _, counted in bench.walker.taken] == [True, False]
    early = in_the_first_swing(0.6)
    early.run(5.0, always(STAND))
    assert [counted for _, counted in early.walker.taken] == [False]


def test_parameters_that_change_at_every_tick_are_followed() -> None:
    bench = Bench()
    time, landed = np.arange(2000) * DT, 0
    sway = [0.1 * np.sin(2.0 * np.pi * time / period) for period in (0.5, 0.7, 1.1)]
    for speed, length, turn in zip(*sway, strict=True):
        gait = Gait(1.2 + speed, 0.1 + turn, 1.1 + length, 1.0, 0.1 + turn)
        if bench.tick(gait).landed is not None:
            landed += 1
            _, foot, stance = bench.touchdowns()[-1]
            # Between the shortest and the longest that was asked for.
            assert 0.40 <= half_step_length(foot, stance) <= 0.48
            assert bench.walker.taken[-1][1]
    assert landed >= 2
    assert np.abs(np.array(bench.motion)[:, 2]).max() < 10.0


def test_a_loaded_swing_foot_stops_lowering() -> None:
    bench = in_the_first_swing(0.8)
    side = bench.walker.swinging
    assert side is not None
    height = float(bench.motion[-1][0, 2])
    for _ in range(100):
        bench.tick(AHEAD, {side: 100.0, side.other: 600.0})
    assert 0.0 < height - bench.motion[-1][0, 2] < 0.5 * height


@pytest.mark.parametrize("progress", [0.45, 0.47, 0.4775])
def test_height_asked_for_just_before_the_foot_is_up_makes_no_jump(progress: float) -> None:
    bench = in_the_first_swing(progress)
    bench.to_touchdown(CHANGES["height"])
    motion = np.array(bench.motion)
    assert np.abs(motion[:, 1, 2]).max() < 1.0
    assert np.abs(np.diff(motion[:, 0, 2])).max() < 0.005
