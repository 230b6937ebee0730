"""A walk without a body: phases in order, what a swing foot guarantees, starting and stopping."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, GaitPlan, Tick, WalkerBench, always, mirrored_gait, until

from follower_humanoid.core.samples import SIDES, Array, Gait, Side
from follower_humanoid.gait.feet import half_step_length
from follower_humanoid.gait.sequence import load_sequence
from follower_humanoid.gait.walk_plan import WalkerConfig

WAYS = {
    "nominal": AHEAD,
    "pulled hard": Gait(1.25, 0.0, 1.25, 1.0, 0.0),
    "quick": Gait(3.0, 0.0, 1.0, 1.0, 0.0),
    "high": Gait(1.0, 0.0, 0.8, 2.0, 0.0),
    "turning left": Gait(1.0, 0.35, 1.0, 1.0, 0.35),
    "backward": Gait(1.0, math.pi, 0.5, 1.0, 0.0),
    "sideways": Gait(1.0, math.pi / 2, 0.4, 1.0, 0.0),
}


def walk(gait: Gait, seconds: float = 8.0, dt: float = 0.01) -> WalkerBench:
    bench = WalkerBench(dt=dt)
    bench.run(seconds, always(gait))
    return bench


def path(ticks: list[Tick], side: Side) -> Array:
    """x, y, z, yaw, pitch of a sole, shape (T, 5)."""
    return np.array([tick.place[side] for tick in ticks])


def half_step_time(gait: Gait, config: WalkerConfig) -> float:
    return config.half_step_time * gait.step_length / gait.walk_speed


def test_both_feet_carry_before_one_swings_and_the_feet_take_turns() -> None:
    bench = walk(AHEAD, 10.0)
    sides = [swing[0].swinging for swing in bench.swings()]
    assert sides[:3] == [Side.RIGHT, Side.LEFT, Side.RIGHT]
    assert [tick.landed for tick in bench.landings()] == sides[: len(bench.landings())]
    kinds = [tick.swinging is not None for tick in bench.history]
    lifts = np.flatnonzero(np.diff(np.array(kinds, dtype=int)) == 1)
    touchdowns = np.flatnonzero(np.diff(np.array(kinds, dtype=int)) == -1)
    transfer = (lifts[1:] - touchdowns[: len(lifts) - 1]) * bench.dt
    np.testing.assert_allclose(transfer, 0.387 * 3.1, atol=0.02)


def test_primitives_run_in_the_order_of_the_sequence() -> None:
    bench = walk(AHEAD, 3.2)
    seen: list[str] = []
    for tick in bench.history:
        seen += [name for name in tick.primitives if name not in seen]
    assert seen == ["lean", "incline", "bend", "stretch", "level", "toe", "lower"]
    for tick in bench.history:
        assert ("lean" in tick.primitives) == (tick.swinging is None or "incline" not in tick.primitives)
        assert not {"bend", "lower"} <= set(tick.primitives)


@pytest.mark.parametrize("way", WAYS)
def test_a_swing_foot_reaches_its_height_lands_at_rest_in_its_place_and_in_time(way: str) -> None:
    gait = WAYS[way]
    bench = WalkerBench()
    landings = []
    ticks = 0
    while len(landings) < 3:
        tick = bench.tick(gait)
        ticks += 1
        if tick.landed is not None:
            landings.append((tick, bench.walker.feet[tick.landed]))
    expected = max(half_step_time(gait, bench.config), bench.config.shortest_half_step)
    times = np.array([tick.time for tick, _ in landings])
    np.testing.assert_allclose(np.diff(times), expected, atol=3 * bench.dt)
    for swing, (tick, foot) in zip(bench.swings(), landings, strict=False):
        sole = path(swing, tick.landed)
        # Reaches step_height, over the ground all the way, and no higher.
        peak = gait.step_height * bench.config.swing_height
        assert sole[:, 2].max() == pytest.approx(peak, rel=0.01)
        assert sole[:, 2].min() >= -1e-12
        # Clears the ground: most of the way it is well up.
        way_gone = np.linalg.norm(sole[:, :2] - sole[0, :2], axis=1)
        underway = (way_gone > 0.2 * way_gone[-1]) & (way_gone < 0.8 * way_gone[-1])
        assert sole[underway, 2].min() > 0.4 * peak
        # At rest where it was sent, before the foot counts as landed.
        np.testing.assert_allclose(sole[-2], [foot.x, foot.y, 0.0, foot.yaw, 0.0], atol=1e-6)
        assert np.abs(np.diff(sole[-4:], axis=0)).max() / bench.dt < 0.01


@pytest.mark.parametrize("way", WAYS)
def test_swings_are_smooth(way: str) -> None:
    gait = WAYS[way]
    bench = walk(gait, 2.2 * half_step_time(gait, WalkerConfig()), dt=0.005)
    for side in SIDES:
        sole = path(bench.history, side)
        velocity = np.diff(sole, axis=0) / bench.dt
        acceleration = np.diff(velocity, axis=0) / bench.dt
        swing = half_step_time(gait, bench.config) * 0.613
        # The quintic of least jerk over the shorter windows; anything that jumps is far beyond.
        assert np.abs(acceleration[:, :2]).max() < 8.0 * 0.9 * gait.step_length / swing**2 + 0.1
        assert np.abs(acceleration[:, 2]).max() < 8.0 * bench.config.swing_height * gait.step_height / (
            (0.4 * swing) ** 2
        )


def test_the_stance_foot_does_not_move() -> None:
    bench = walk(replace(AHEAD, heading=0.2, walk_dir=0.2), 7.0)
    for swing in bench.swings():
        stance = swing[0].swinging.other
        assert np.ptp(path(swing, stance), axis=0).max() == 0.0


@pytest.mark.parametrize("way", WAYS)
def test_lengths_are_those_asked_for(way: str) -> None:
    gait = WAYS[way]
    bench = WalkerBench()
    lengths = []
    while len(lengths) < 4:
        if (landed := bench.tick(gait).landed) is not None:
            feet = bench.walker.feet
            lengths.append(half_step_length(feet[landed], feet[landed.other]))
    travel = gait.walk_dir - gait.heading
    np.testing.assert_allclose(lengths, 0.40 * gait.step_length * math.cos(travel), atol=1e-9)


@pytest.mark.parametrize(
    ("gait", "first"),
    [
        (AHEAD, Side.RIGHT),
        (WAYS["turning left"], Side.LEFT),
        (mirrored_gait(WAYS["turning left"]), Side.RIGHT),
        (WAYS["sideways"], Side.LEFT),
        (mirrored_gait(WAYS["sideways"]), Side.RIGHT),
    ],
)
def test_the_first_swing_is_on_the_side_of_travel_or_turn(gait: Gait, first: Side) -> None:
    assert walk(gait, 3.0).swings()[0][0].swinging is first


@pytest.mark.parametrize("way", ["turning left", "sideways"])
def test_a_mirrored_walk_is_the_mirror_image(way: str) -> None:
    def track(gait: Gait) -> tuple[WalkerBench, GaitPlan]:
        return WalkerBench(), until(6.0, gait)

    bench, plan = track(WAYS[way])
    twin, twin_plan = track(mirrored_gait(WAYS[way]))
    bench.run(12.0, plan)
    twin.run(12.0, twin_plan)
    flip = np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    for side in SIDES:
        np.testing.assert_allclose(
            path(twin.history, side.other), path(bench.history, side) * flip, atol=1e-9
        )
    zmp, other = (np.array([tick.zmp for tick in b.history]) for b in (bench, twin))
    np.testing.assert_allclose(other, zmp * flip[:2], atol=1e-9)


def test_standing_does_nothing() -> None:
    bench = WalkerBench()
    bench.run(2.0, always(STAND))
    assert not bench.landings()
    assert not bench.swings()
    assert all(tick.shares == dict.fromkeys(SIDES, 1.0) for tick in bench.history)
    np.testing.assert_allclose(bench.history[-1].zmp, [bench.config.stand_forward, 0.0], atol=1e-12)


@pytest.mark.parametrize("stop", [1.7, 2.9, 4.9, 7.0])
def test_asked_to_stop_it_brings_the_feet_together_and_stands(stop: float) -> None:
    bench = WalkerBench()
    bench.run(stop + 9.5, until(stop, AHEAD))
    counted = [kind for _, kind in bench.walker.taken]
    assert counted[-1] is False
    assert all(counted[:-1])
    assert bench.walker.half_step is None
    left, right = bench.walker.feet[Side.LEFT], bench.walker.feet[Side.RIGHT]
    assert half_step_length(left, right) == pytest.approx(0.0, abs=1e-9)
    assert math.hypot(left.x - right.x, left.y - right.y) == pytest.approx(bench.footsteps.stance_width)
    np.testing.assert_allclose(
        bench.walker.zmp.position, [left.x + bench.config.stand_forward, 0.0], atol=1e-9
    )
    assert bench.walker.shares == dict.fromkeys(SIDES, 1.0)
    # Stopping takes what is left of the step in the making and one more at most.
    assert bench.landings()[-1].time <= stop + 2 * 3.1 + 0.1


def test_asked_to_stop_before_the_first_lift_off_it_stays() -> None:
    bench = WalkerBench()
    bench.run(4.0, until(0.6, AHEAD))
    assert not bench.swings()
    assert bench.walker.taken == []
    zmp = np.array([tick.zmp for tick in bench.history])
    assert np.linalg.norm(np.diff(zmp, axis=0), axis=1).max() < 0.2 * bench.dt
    np.testing.assert_allclose(zmp[-1], [bench.config.stand_forward, 0.0], atol=1e-9)


def test_it_starts_again_after_a_stop() -> None:
    bench = WalkerBench()
    bench.run(22.0, lambda t: AHEAD if t < 3.5 or t > 12.0 else STAND)
    counted = [kind for _, kind in bench.walker.taken]
    assert counted == [True, False, True, True, True]


def test_a_walk_wanted_again_during_the_closing_step_goes_on() -> None:
    bench = WalkerBench()
    bench.run(10.0, lambda t: STAND if 4.0 < t < 4.8 else AHEAD)
    assert all(kind for _, kind in bench.walker.taken)
    lengths = np.diff([0.0] + [foot.x for foot, _ in bench.walker.taken])
    np.testing.assert_allclose(lengths, 0.40, atol=1e-9)


def test_a_foot_takes_and_leaves_its_load_gradually_and_has_none_in_the_air() -> None:
    bench = walk(AHEAD, 8.0, dt=0.005)
    for side in SIDES:
        share = np.array([tick.shares[side] for tick in bench.history])
        air = np.array([tick.swinging is side for tick in bench.history])
        assert np.all(share[air] == 0.0)
        assert np.all((share >= 0.0) & (share <= 1.0))
        slope = np.abs(np.diff(share)) / bench.dt
        assert slope.max() <= 1.0 / bench.config.load_time + 1e-6
    both = np.array([tick.shares[Side.LEFT] + tick.shares[Side.RIGHT] for tick in bench.history])
    assert both.min() >= 1.0


def test_in_single_support_the_zmp_stays_on_the_stance_sole_and_never_jumps() -> None:
    bench = walk(WAYS["turning left"], 8.0)
    for swing in bench.swings():
        side = swing[0].swinging.other
        for tick in swing:
            x, y, _, yaw, _ = tick.place[side]
            away = tick.zmp - np.array([x, y])
            forward = math.cos(yaw) * away[0] + math.sin(yaw) * away[1]
            aside = -math.sin(yaw) * away[0] + math.cos(yaw) * away[1]
            assert -0.06 < forward < 0.14
            assert abs(aside) < 1e-9
    zmp = np.array([tick.zmp for tick in bench.history])
    assert np.linalg.norm(np.diff(zmp, axis=0), axis=1).max() < 0.6 * bench.dt


def test_a_foot_waits_on_the_ground_while_the_dcm_is_off_but_not_for_ever() -> None:
    def lift_off(steady_from: float) -> float:
        bench = WalkerBench()
        while bench.walker.swinging is None:
            steady = bench.time >= steady_from
            bench.tick(AHEAD, steady=steady)
            if not steady and bench.walker.swinging is None and bench.time < 1.3:
                assert min(bench.history[-1].shares.values()) > 0.8
        return bench.time

    usual = lift_off(0.0)
    waited = usual + 0.15
    assert lift_off(0.5 * usual) == usual
    assert waited < lift_off(waited) < waited + 2 * WalkerConfig().load_time
    longest = lift_off(99.0)
    assert waited < longest < usual + 2.0
    assert lift_off(98.0) == longest


def test_a_foot_that_bounces_after_touching_down_is_not_sent_down_anew() -> None:
    bench = WalkerBench(dt=0.002)
    while bench.walker.half_step is None or bench.walker.half_step.swing_progress < 0.955:
        bench.tick(AHEAD)
    side = bench.walker.swinging
    assert side is not None
    touching, bouncing = {side: 100.0, side.other: 600.0}, {side: 0.0, side.other: 700.0}
    speeds = []
    for n in range(20):
        bench.tick(AHEAD, loads=touching if n == 0 else bouncing)
        assert bench.walker.half_step is not None
        speeds.append(float(bench.walker.half_step.swing.height.velocity[0]))
    assert np.abs(np.diff(speeds)).max() < 0.1 * max(abs(speeds[0]), 0.01)
    assert abs(speeds[-1]) < abs(speeds[0])


@pytest.mark.parametrize("first_transfer", [0.0, 0.05, 0.9])
def test_asked_to_stop_in_the_first_double_support_no_foot_leaves_the_ground(first_transfer: float) -> None:
    bench = WalkerBench(WalkerConfig(first_transfer=first_transfer))
    bench.run(0.2, always(AHEAD))
    assert bench.walker.half_step is not None
    bench.run(6.0, always(STAND))
    assert bench.swings() == []
    assert bench.walker.half_step is None


@pytest.mark.parametrize("parts", [(1.0,), (0.5, 0.5)])
def test_double_support_in_two_phases_commits_like_one(parts: tuple[float, ...]) -> None:
    whole = load_sequence()
    first = whole.phases[0]
    halves = tuple(replace(first, share=first.share * part) for part in parts)
    bench = WalkerBench(sequence=replace(whole, phases=(*halves, *whole.phases[1:])))
    transfer = max(WalkerConfig().first_transfer, whole.double_share * WalkerConfig().half_step_time)
    bench.run(0.85 * transfer, always(AHEAD))
    assert bench.walker.swinging is None
    bench.run(8.0, always(STAND))
    assert len(bench.landings()) > 0  # too late to turn back
