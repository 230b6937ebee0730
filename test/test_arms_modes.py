"""Who yields when, blending, and what the controller wants of a hand that was led away."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from follower_humanoid.control.arm_config import ArmControllerConfig
from follower_humanoid.control.arm_modes import AUTO, COMPENSATION, IMPEDANCE, Blend, ModeSwitch
from follower_humanoid.control.hand_reference import GlideLimits, HandReference
from follower_humanoid.core.config import build
from follower_humanoid.core.samples import Odometry
from follower_humanoid.errors import ConfigurationError

TICK = 0.002
NOBODY, LEFT = np.array([False, False]), np.array([True, False])


def pull(newton: float) -> np.ndarray:
    return np.array([[0.0, 0.0, -newton], [0.0, 0.0, 0.0]])


def automatic(switch: ModeSwitch, newton: float, ticks: int = 1) -> list[bool]:
    for _ in range(ticks):
        switch.step(AUTO, pull(newton), 4.0, 1.5, 0.1)
    return [bool(yields) for yields in switch.yielding]


def test_a_mode_holds_for_both_hands():
    switch = ModeSwitch(TICK)
    for mode, newton, changes, yields in (
        (IMPEDANCE, 9.0, False, False),
        (COMPENSATION, 0.0, True, True),
        (COMPENSATION, 0.0, False, True),
        (COMPENSATION, 0.0, False, True),
        (IMPEDANCE, 9.0, True, False),
        (IMPEDANCE, 9.0, False, False),
    ):
        switch.step(mode, pull(newton), 4.0, 1.5, 0.1)
        assert (switch.switched, switch.anybody) == (changes, yields)
        assert list(switch.changed) == [changes] * 2
        assert list(switch.yielding) == [yields] * 2


def test_auto_has_hysteresis_in_force_and_time_and_knows_the_hands_apart():
    switch = ModeSwitch(TICK)
    assert automatic(switch, 3.9, 50) == [False, False]
    assert automatic(switch, 4.1) == [True, False]
    assert automatic(switch, 1.6, 500) == [True, False], "between the two forces nothing changes"
    assert automatic(switch, 1.4, 49) == [True, False]
    assert automatic(switch, 1.6) == [True, False]
    assert automatic(switch, 1.4, 49) == [True, False], "the time starts anew"
    assert automatic(switch, 1.4, 2) == [False, False]


def test_force_noise_around_a_threshold_does_not_make_it_chatter():
    switch, rng = ModeSwitch(TICK), np.random.default_rng(0)
    changes = 0
    for _ in range(2000):
        switch.step(AUTO, pull(4.0 + rng.normal(scale=0.5)), 4.0, 1.5, 0.1)
        changes += switch.switched
    assert changes == 1


def test_blending_takes_the_last_command_over_and_lets_it_fade():
    blend = Blend(0.2, TICK)
    before = blend.step(np.full((2, 7), 5.0), None)
    found = [blend.step(np.full((2, 7), -3.0), LEFT)]
    found += [blend.step(np.full((2, 7), -3.0), None) for _ in range(120)]
    np.testing.assert_allclose(found[0][0], before[0])
    np.testing.assert_allclose(found[0][1], -3.0)
    steps = np.abs(np.diff([command[0, 0] for command in found]))
    assert steps.max() <= 8.0 * TICK / 0.2 + 1e-12
    np.testing.assert_allclose(found[-1], -3.0)


def reference() -> HandReference:
    return HandReference(
        np.array([[0.3, 0.2, 0.1], [0.3, -0.2, 0.1]]), np.zeros((2, 7)), GlideLimits(0.1, 0.5, 0.5), TICK
    )


def target(place, velocity=(0.0, 0.0, 0.0)) -> tuple[Odometry, None]:
    level = np.array([0.0, 0.0, 0.0, 1.0])
    return Odometry(np.array(place), level, np.array(velocity), np.zeros(3)), None


def test_a_moving_target_is_followed_exactly_and_takes_the_springs_along():
    wanted = reference()
    wanted.virtual = wanted.virtual + 0.01
    for tick in range(1, 200):
        wanted.receive(target((0.3 + 0.05 * TICK * tick, 0.2, 0.1), (0.05, 0.0, 0.0)))
        wanted.glide(NOBODY)
        np.testing.assert_allclose(wanted.place[0], (0.3 + 0.05 * TICK * tick, 0.2, 0.1))
        np.testing.assert_allclose(wanted.virtual[0] - wanted.place[0], 0.01)
        np.testing.assert_allclose(wanted.rate[0], (0.05, 0.0, 0.0))
    np.testing.assert_array_equal(wanted.place[1], (0.3, -0.2, 0.1))


SPEED = np.array((0.05, -0.03, 0.1))


def moving_target(time: float) -> tuple[Odometry, None]:
    return target(np.array((0.3, 0.2, 0.1)) + SPEED * time, SPEED)


def rates_of(wanted: HandReference, targets) -> np.ndarray:
    rates = []
    for sent in targets:
        wanted.receive(sent)
        wanted.glide(NOBODY)
        rates.append(wanted.rate[0])
    return np.array(rates)


@pytest.mark.parametrize("again", [False, True], ids=["silent", "the same again and again"])
def test_a_target_that_moves_on_no_more_comes_to_rest_whatever_it_says(again):
    wanted = reference()
    wanted.virtual = wanted.virtual + 0.01
    rates_of(wanted, (moving_target(TICK * tick) for tick in range(1, 101)))
    sent = moving_target(TICK * 100)
    np.testing.assert_array_equal(wanted.rate[0], SPEED)
    rates = rates_of(wanted, [sent if again else (None, None)] * 150)
    np.testing.assert_array_equal(rates[-1], 0.0)
    assert np.abs(np.diff([SPEED, *rates], axis=0)).max() < 0.02 * 0.1, "no step"
    np.testing.assert_array_equal(wanted.place[0], sent[0].position)
    np.testing.assert_allclose(wanted.virtual[0] - wanted.place[0], 0.01)
    rates_of(wanted, [moving_target(TICK * 101)])
    np.testing.assert_array_equal(wanted.rate[0], SPEED, err_msg="it is believed again at once")


def test_a_target_that_is_missing_once_or_comes_slowly_keeps_most_of_its_velocity():
    sent = [moving_target(TICK * tick) for tick in range(1, 101)]
    sent[50] = (None, None)
    np.testing.assert_allclose(rates_of(reference(), sent), np.tile(SPEED, (100, 1)), rtol=0.02)
    slow = [moving_target(TICK * (tick - tick % 5)) for tick in range(5, 100)]
    np.testing.assert_allclose(rates_of(reference(), slow), np.tile(SPEED, (95, 1)), rtol=0.05)


def test_a_target_that_jumps_is_glided_to():
    wanted, places = reference(), []
    for _ in range(3000):
        wanted.receive(target((0.5, 0.2, 0.1)))
        wanted.glide(NOBODY)
        places.append(wanted.place[0, 0])
    assert np.abs(np.diff([0.3, *places])).max() <= 0.1 * TICK + 1e-12
    assert np.diff(places, 2).max() < 1.1 * TICK * TICK * 0.1 / 0.5, "no jump of its speed"
    assert places[-1] == pytest.approx(0.5, abs=1e-4)


def test_a_hand_that_is_led_is_wanted_where_it_is_and_glides_home_afterwards():
    wanted = reference()
    led = SimpleNamespace(place=np.array([[0.4, 0.1, 0.0], [9.0, 9.0, 9.0]]))
    wanted.follow(LEFT, led, np.full((2, 7), 0.3))
    np.testing.assert_array_equal(wanted.place[0], led.place[0])
    np.testing.assert_array_equal(wanted.virtual[0], led.place[0])
    np.testing.assert_array_equal(wanted.posture, [[0.3] * 7, [0.0] * 7])
    np.testing.assert_array_equal(wanted.place[1], (0.3, -0.2, 0.1))
    places, postures = [wanted.place[0]], [wanted.posture[0]]
    for _ in range(4000):
        wanted.glide(NOBODY)
        places.append(wanted.place[0])
        postures.append(wanted.posture[0])
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / TICK
    assert speed.max() <= 0.1 + 1e-9
    assert (np.linalg.norm(np.diff(postures, axis=0), axis=1) / TICK).max() <= 0.5 + 1e-9
    np.testing.assert_allclose(places[-1], (0.3, 0.2, 0.1), atol=1e-4)
    np.testing.assert_allclose(postures[-1], np.zeros(7), atol=1e-3)


def test_only_the_mode_and_what_decides_about_it_may_change_while_it_runs():
    from follower_humanoid.core.config import parameters_of

    adjustable = {info.name for info in parameters_of(ArmControllerConfig) if not info.read_only}
    assert adjustable == {"mode", "payload", "auto_pulled", "auto_released", "auto_delay"}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"mode": "gravity"}, "mode = 'gravity': valid: impedance, gravity_compensation, auto"),
        ({"stiffness": [100.0, -1.0, 100.0]}, "stiffness = -1.0: valid: 1.0 to 20000.0 N/m"),
        ({"auto_pulled": 1.0}, "auto_released = 1.5 N: valid: below auto_pulled = 1.0 N"),
    ],
)
def test_bad_values_are_refused_with_what_is_valid(values, words):
    with pytest.raises(ConfigurationError, match=words):
        build(ArmControllerConfig, values, "arm_controller")
