"""κ and γ of the hand forces: static equilibrium, and nothing that depends on the world's origin."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.balance.hand_forces import HandEffect, hand_effect
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.robot.model import GRAVITY

MASS = 73.0
WEIGHT = MASS * GRAVITY


def random_hands(rng: np.random.Generator) -> list[tuple[Wrench, Array]]:
    return [
        (Wrench(rng.normal(0, 20, 3), rng.normal(0, 3, 3)), np.array([0.3, y, 1.0]) + rng.normal(0, 0.1, 3))
        for y in (0.2, -0.2)
    ]


def test_without_force_nothing_changes() -> None:
    for hands in ([], [(Wrench(np.zeros(3), np.zeros(3)), np.array([0.3, 0.2, 1.0]))]):
        effect = hand_effect(hands, MASS)
        assert effect.kappa == 1.0
        np.testing.assert_array_equal(effect.gamma, np.zeros(2))
        np.testing.assert_array_equal(effect.force, np.zeros(3))
        np.testing.assert_array_equal(effect.resting_com(np.array([0.1, 0.2])), [0.1, 0.2])


def test_a_forward_pull_at_one_metre_wants_the_com_back() -> None:
    effect = hand_effect([(Wrench(np.array([15.0, 0.0, 0.0]), np.zeros(3)), np.array([0.4, 0.0, 1.0]))], MASS)
    assert effect.kappa == 1.0
    np.testing.assert_allclose(effect.gamma, [15.0 / WEIGHT, 0.0])
    np.testing.assert_allclose(effect.resting_com(np.zeros(2)), [-15.0 / WEIGHT, 0.0])


def test_a_load_in_the_hands_wants_the_com_back() -> None:
    effect = hand_effect(
        [(Wrench(np.array([0.0, 0.0, -100.0]), np.zeros(3)), np.array([0.4, 0.0, 1.0]))], MASS
    )
    assert effect.kappa == pytest.approx(1.0 + 100.0 / WEIGHT)
    np.testing.assert_allclose(effect.resting_com(np.zeros(2)), [-0.4 * 100.0 / WEIGHT, 0.0])


def test_moments_of_the_resting_com_balance() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        hands, zmp = random_hands(rng), rng.normal(0, 0.3, 2)
        effect = hand_effect(hands, MASS)
        com = np.append(effect.resting_com(zmp), 0.85)
        total = sum(wrench.force for wrench, _ in hands)
        np.testing.assert_allclose(effect.force, total)
        ground = np.array([0.0, 0.0, WEIGHT]) - total
        moment = np.cross(np.append(zmp, 0.0), ground) + np.cross(com, [0.0, 0.0, -WEIGHT])
        for wrench, place in hands:
            moment += wrench.torque + np.cross(place, wrench.force)
        np.testing.assert_allclose(moment[:2], np.zeros(2), atol=1e-9)


def test_dynamic_moment_balance_is_the_pendulum_with_kappa_and_gamma() -> None:
    # κ p = c − c̈/ω² + γ with the CoM at constant height, from Newton and Euler about the CoM.
    rng = np.random.default_rng(2)
    for _ in range(10):
        hands, com = random_hands(rng), np.append(rng.normal(0, 0.3, 2), 0.85)
        acceleration = np.append(rng.normal(0, 1.0, 2), 0.0)
        total = sum(wrench.force for wrench, _ in hands)
        ground = MASS * (acceleration + np.array([0.0, 0.0, GRAVITY])) - total
        rest = sum(wrench.torque + np.cross(place - com, wrench.force) for wrench, place in hands)
        # (p − c) × F + rest = 0, p on the ground.
        p_x = com[0] + (-com[2] * ground[0] + rest[1]) / ground[2]
        p_y = com[1] + (-com[2] * ground[1] - rest[0]) / ground[2]
        effect, omega2 = hand_effect(hands, MASS), GRAVITY / com[2]
        right = com[:2] - acceleration[:2] / omega2 + effect.gamma
        np.testing.assert_allclose(effect.kappa * np.array([p_x, p_y]), right, atol=1e-12)


def test_what_is_asked_does_not_depend_on_the_worlds_origin() -> None:
    rng = np.random.default_rng(3)
    hands, zmp = random_hands(rng), np.array([0.1, -0.05])
    here = hand_effect(hands, MASS)
    shift = np.array([12.0, -7.0])
    there = hand_effect([(wrench, place + np.append(shift, 0.0)) for wrench, place in hands], MASS)
    assert there.kappa == here.kappa
    np.testing.assert_allclose(there.resting_com(zmp + shift), here.resting_com(zmp) + shift, atol=1e-12)
    velocity, omega = np.array([0.2, 0.1]), 3.4

    def dcm(effect: HandEffect, com: Array) -> Array:
        return np.asarray((com + velocity / omega + effect.gamma) / effect.kappa)

    com = np.array([0.12, 0.01])
    np.testing.assert_allclose(dcm(there, com + shift), dcm(here, com) + shift, atol=1e-12)


def test_a_pull_told_at_another_point_with_its_moment_is_the_same_pull() -> None:
    wrench, place = (
        Wrench(np.array([10.0, -4.0, -20.0]), np.array([1.0, 2.0, 0.5])),
        np.array([0.4, 0.2, 1.0]),
    )
    offset = np.array([0.05, -0.1, 0.2])
    moved = Wrench(wrench.force, wrench.torque - np.cross(offset, wrench.force))
    one, two = hand_effect([(wrench, place)], MASS), hand_effect([(moved, place + offset)], MASS)
    assert one.kappa == two.kappa
    np.testing.assert_allclose(one.gamma, two.gamma, atol=1e-15)


def test_two_hands_add() -> None:
    hands = random_hands(np.random.default_rng(4))
    both, left, right = (hand_effect(h, MASS) for h in (hands, hands[:1], hands[1:]))
    assert both.kappa == pytest.approx(left.kappa + right.kappa - 1.0)
    np.testing.assert_allclose(both.gamma, left.gamma + right.gamma)


def test_left_and_right_are_mirror_images() -> None:
    flip, turn = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    hands = random_hands(np.random.default_rng(5))
    twin = [(Wrench(w.force * flip, w.torque * turn), place * flip) for w, place in hands]
    one, two = hand_effect(hands, MASS), hand_effect(twin, MASS)
    np.testing.assert_allclose(two.gamma, one.gamma * flip[:2], atol=1e-15)
    assert two.kappa == pytest.approx(one.kappa)
