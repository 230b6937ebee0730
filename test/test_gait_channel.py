"""Channels reach what they are sent to, at rest and in time, and never jump when they are re-aimed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from follower_humanoid.gait.channel import (
    ConstantSpeedChannel,
    MinimumJerkChannel,
    along_quintic,
    constant_speed_tick,
    hardest_to_come,
    least_jerk_tick,
    time_not_beyond,
)

DT = 0.002


def drive(
    channel: MinimumJerkChannel, duration: float, target: Callable[[float], np.ndarray], dt: float = DT
) -> np.ndarray:
    """Position, velocity and acceleration after each tick up to `duration`, shape (T, 3, n)."""
    rows = []
    for tick in range(math.ceil(duration / dt - 1e-9)):
        time = tick * dt
        channel.advance(target(time), duration - time, dt)
        rows.append([channel.position, channel.velocity, channel.acceleration])
    return np.array(rows)


def test_minimum_jerk_follows_the_quintic_of_flash_and_hogan() -> None:
    channel = MinimumJerkChannel(np.array([0.1, -0.3]))
    target = np.array([0.5, 0.2])
    path = drive(channel, 0.8, lambda t: target)
    u = np.arange(1, len(path) + 1)[:, None] * DT / 0.8
    shape = u**3 * (10 - 15 * u + 6 * u**2)
    np.testing.assert_allclose(path[:, 0], np.array([0.1, -0.3]) + shape * np.array([0.4, 0.5]), atol=1e-9)
    peak = np.abs(path[:, 1]).max(axis=0)
    np.testing.assert_allclose(peak, 1.875 * np.array([0.4, 0.5]) / 0.8, rtol=1e-5)


def test_minimum_jerk_ends_on_the_target_at_rest() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        channel = MinimumJerkChannel(rng.normal(size=3))
        channel.velocity, channel.acceleration = rng.normal(size=3), rng.normal(size=3)
        target = rng.normal(size=3)
        path = drive(channel, rng.uniform(0.3, 2.0), lambda t, target=target: target)
        np.testing.assert_allclose(channel.position, target, atol=1e-12)
        np.testing.assert_allclose(channel.velocity, np.zeros(3), atol=1e-9)
        np.testing.assert_allclose(channel.acceleration, np.zeros(3), atol=1e-6)
        # One tick earlier it is already there: the end is no jump.
        assert np.abs(path[-2, 0] - target).max() < 1e-4
        assert np.abs(path[-2, 1]).max() < 0.01


def test_position_velocity_and_acceleration_belong_to_one_motion() -> None:
    rng = np.random.default_rng(2)
    channel = MinimumJerkChannel(np.zeros(2))
    channel.velocity, channel.acceleration = rng.normal(size=2), rng.normal(size=2)
    path = drive(channel, 1.0, lambda t: np.array([1.0, 0.0]))[:-2]
    velocity = (path[2:, 0] - path[:-2, 0]) / (2 * DT)
    acceleration = (path[2:, 1] - path[:-2, 1]) / (2 * DT)
    np.testing.assert_allclose(velocity, path[1:-1, 1], atol=2e-3)
    np.testing.assert_allclose(acceleration, path[1:-1, 2], atol=2e-3)


@pytest.mark.parametrize("change_at", [0.2, 0.5, 0.75])
def test_a_target_that_jumps_makes_no_jump_of_position_velocity_or_acceleration(change_at: float) -> None:
    channel = MinimumJerkChannel(np.zeros(1))
    path = drive(channel, 1.0, lambda t: np.array([0.4 if t < change_at else 0.55]))
    remaining = 1.0 - change_at
    assert channel.position[0] == pytest.approx(0.55, abs=1e-12)
    # Within one tick nothing moves further than its own derivative (and the re-aimed jerk) can take it.
    jerk = 60.0 * 0.4 + 60.0 * 0.15 / remaining**3
    steps = np.abs(np.diff(path[:-1, :, 0], axis=0)).max(axis=0)
    assert steps[0] <= DT * np.abs(path[:, 1]).max() * 1.01
    assert steps[1] <= DT * np.abs(path[:, 2]).max() * 1.01
    assert steps[2] <= DT * jerk * 3.0


def test_a_duration_that_changes_on_the_way_is_kept_without_a_jump() -> None:
    channel = MinimumJerkChannel(np.zeros(1))
    ends = iter(np.where(np.arange(10_000) * DT < 0.4, 1.0, 1.4))
    time, path = 0.0, []
    while not path or time < 1.4 - 1e-9:
        channel.advance(np.array([0.3]), float(next(ends)) - time, DT)
        path.append([channel.position[0], channel.velocity[0], channel.acceleration[0]])
        time += DT
    assert channel.position[0] == pytest.approx(0.3, abs=1e-12)
    assert channel.velocity[0] == pytest.approx(0.0, abs=1e-9)
    before_end = np.array(path[:-1])
    assert np.abs(np.diff(before_end[:, 2])).max() < 0.1


def test_the_same_target_every_tick_is_no_other_motion_than_one_plan() -> None:
    coarse = MinimumJerkChannel(np.zeros(1))
    coarse.advance(np.array([1.0]), 1.0, 0.5)
    fine = MinimumJerkChannel(np.zeros(1))
    for tick in range(250):
        fine.advance(np.array([1.0]), 1.0 - tick * DT, DT)
    assert fine.position[0] == pytest.approx(coarse.position[0], abs=1e-10)
    assert fine.velocity[0] == pytest.approx(coarse.velocity[0], abs=1e-9)
    assert fine.acceleration[0] == pytest.approx(coarse.acceleration[0], abs=1e-8)


def test_hold_lets_speed_fade_and_stays() -> None:
    channel = MinimumJerkChannel(np.zeros(1))
    channel.velocity = np.array([0.2])
    for _ in range(500):
        channel.hold(DT, settling=0.05)
    assert abs(channel.velocity[0]) < 1e-8
    assert 0.0 < channel.position[0] <= 0.2 * 0.05 + 1e-12


def test_constant_speed_is_constant_and_in_time() -> None:
    channel = ConstantSpeedChannel(np.array([0.0, 1.0]))
    speeds = []
    for tick in range(500):
        channel.advance(np.array([0.5, 0.0]), 1.0 - tick * DT, DT)
        speeds.append(channel.velocity)
    np.testing.assert_allclose(speeds[:-1], np.tile([0.5, -1.0], (499, 1)), rtol=1e-9)
    np.testing.assert_allclose(channel.position, [0.5, 0.0], atol=1e-12)


def test_constant_speed_channel_re_aimed_does_not_jump_and_still_arrives_in_time() -> None:
    channel = ConstantSpeedChannel(np.zeros(2))
    positions = []
    for tick in range(500):
        target = np.array([0.5, 0.0]) if tick < 300 else np.array([0.4, 0.3])
        channel.advance(target, 1.0 - tick * DT, DT)
        positions.append(channel.position)
    np.testing.assert_allclose(channel.position, [0.4, 0.3], atol=1e-12)
    assert np.linalg.norm(np.diff(positions, axis=0), axis=1).max() < 1.0 * DT
    channel.hold(DT)
    np.testing.assert_allclose(channel.position, [0.4, 0.3], atol=1e-12)
    np.testing.assert_array_equal(channel.velocity, np.zeros(2))


def test_channels_keep_no_hand_on_the_callers_arrays() -> None:
    start = np.array([1.0])
    for channel in (MinimumJerkChannel(start), ConstantSpeedChannel(start)):
        target = np.array([2.0])
        channel.advance(target, 0.0, DT)
        target[0], start[0] = 9.0, 9.0
        assert channel.position[0] == 2.0


@pytest.mark.parametrize("longer", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("part", [0.2, 0.5, 0.7])
def test_given_more_time_under_way_it_does_not_swing_out_beyond_its_target(
    part: float, longer: float
) -> None:
    channel, target = MinimumJerkChannel(np.zeros(2)), np.array([1.0, 0.1])
    for tick in range(round(part / DT)):
        channel.advance(target, 1.0 - tick * DT, DT)
    path = drive(channel, longer, lambda t: target)
    assert path[:, 0, 0].max() < 1.0 + 1e-9
    np.testing.assert_allclose(channel.position, target, atol=1e-9)
    assert np.abs(path[:, 2]).max() < 7.0  # the whole way in 1 s takes 5.8 m/s²
    assert np.abs(np.diff(path[:, 2], axis=0)).max() < 0.5


def test_sent_back_to_where_it_is_just_passing_it_stops_gently() -> None:
    channel = MinimumJerkChannel(np.zeros(1))
    channel.velocity = np.array([1.0])
    target = np.array([0.001])
    path = drive(channel, 2.0, lambda t: target)
    np.testing.assert_allclose(channel.position, target, atol=1e-9)
    assert np.abs(path[:, 2]).max() < 40.0


def test_a_tick_is_a_piece_of_the_quintic_or_the_arrival() -> None:
    rng = np.random.default_rng(4)
    for _ in range(50):
        way = (*rng.normal(size=(3, 2)), rng.normal(size=2), rng.uniform(0.0, 4.0 * DT))
        time = time_not_beyond(*way)
        rest = np.stack((way[3], np.zeros(2), np.zeros(2)))
        expected = rest if time <= DT else along_quintic(*way[:4], time, DT)
        np.testing.assert_array_equal(least_jerk_tick(*way, DT), expected)


def test_the_hardest_to_come_is_the_largest_of_samples_along_the_quintic() -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        way = (*rng.normal(size=(3, 2)), rng.normal(size=2), rng.uniform(0.1, 2.0))
        time = time_not_beyond(*way)
        samples = [along_quintic(*way[:4], time, time * n / 8)[2] for n in range(1, 8)]
        assert hardest_to_come(*way) == max(math.sqrt(np.sum(a**2)) for a in samples)


def test_a_tick_at_constant_speed_is_part_of_the_way() -> None:
    rng = np.random.default_rng(6)
    position, target = rng.normal(size=(2, 3))
    for remaining in (0.0, DT, 1.5 * DT, 0.7):
        speed = (target - position) / remaining if remaining > DT else np.zeros(3)
        expected = (position + DT * speed, speed) if remaining > DT else (target, speed)
        np.testing.assert_array_equal(constant_speed_tick(position, target, remaining, DT), expected)
