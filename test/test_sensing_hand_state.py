"""The compiled arithmetic of the wrench sensing against Pinocchio's spatial algebra and closed forms."""

import numpy as np
import pinocchio as pin
import pytest

from follower_humanoid.robot.model import GRAVITY
from follower_humanoid.sensing.hand_state import SHAPE, external_wrench, follow_hands, hand_state

PERIOD = 0.002


@pytest.fixture
def random():
    return np.random.default_rng(17)


def table(pose):
    return np.vstack((pose.rotation.T, pose.translation))


class Hand:
    """A hand with its wrist frame and gripper somewhere in the joint's frame."""

    def __init__(self, random):
        self.inertia, self.wrist, self.gripper = pin.Inertia.Random(), pin.SE3.Random(), random.normal(size=3)

    def state(self, pose, twist):
        state, inertia = np.zeros(SHAPE), np.ascontiguousarray(self.inertia.inertia)
        hand_state(
            table(pose), twist.vector, self.inertia.mass, self.inertia.lever, inertia,
            table(self.wrist), self.gripper, state,
        )  # fmt: skip
        return state


def test_the_state_holds_wrist_frame_momentum_com_and_gripper_in_world(random):
    hand, pose, twist = Hand(random), pin.SE3.Random(), pin.Motion.Random()
    state = hand.state(pose, twist)
    assert state[:4] == pytest.approx(table(pose * hand.wrist), abs=1e-14)
    assert state[6] == pytest.approx(pose.act(hand.inertia.lever), abs=1e-14)
    assert state[7] == pytest.approx(pose.act(hand.gripper), abs=1e-14)
    about_com = pin.SE3(pose.rotation, pose.translation - state[6]).act(hand.inertia * twist)
    assert np.r_[state[4], state[5]] == pytest.approx(about_com.vector, abs=1e-14)


def test_of_a_resting_hand_only_what_is_not_its_weight_is_external(random):
    hand, pose = Hand(random), pin.SE3.Random()
    pull, moment, found = random.normal(size=3), random.normal(size=3), np.zeros(6)
    state = hand.state(pose, pin.Motion.Zero())
    weight = hand.inertia.mass * GRAVITY
    # At rest, the forearm carries the pull and the weight.
    down, at_wrist = np.array([0.0, 0.0, -weight]), pin.SE3(state[:3].T, state[3] - state[7])
    carried = pin.Force(pull + down, moment + np.cross(state[6] - state[7], down))
    reading = at_wrist.actInv(carried).vector
    external_wrench(state, state, reading, weight, PERIOD, found)
    assert found == pytest.approx(np.r_[pull, moment], abs=1e-13)


def test_a_thrown_hand_feels_nothing(random):
    """No force through the wrist: the momentum changes by the weight alone, for any spin of a ball."""
    hand, found = Hand(random), np.zeros(6)
    hand.inertia = pin.Inertia(2.0, random.normal(size=3), 0.01 * np.eye(3))
    velocity, spin, turn = random.normal(size=3), random.normal(size=3), pin.SE3.Random().rotation
    later = velocity - np.array([0.0, 0.0, GRAVITY * PERIOD])
    states = []
    for time, speed in ((0.0, velocity), (PERIOD, later)):
        center = time * (velocity + later) / 2  # the mean speed is that of the parabola
        rotation = pin.exp3(time * spin) @ turn
        pose = pin.SE3(rotation, center - rotation @ hand.inertia.lever)
        linear = speed - np.cross(spin, rotation @ hand.inertia.lever)
        states.append(hand.state(pose, pin.Motion(rotation.T @ linear, rotation.T @ spin)))
    external_wrench(*states, np.zeros(6), 2.0 * GRAVITY, PERIOD, found)
    assert found[:3] == pytest.approx(np.zeros(3), abs=1e-10)
    # Moments are about the mean place of the gripper: exact only up to Δt².
    assert found[3:] == pytest.approx(np.zeros(3), abs=20.0 * PERIOD**2)


def test_the_wrench_of_a_tick_is_the_mean_of_transports_at_both_ends(random):
    hand, found = Hand(random), np.zeros(6)
    poses, twists = [pin.SE3.Random(), pin.SE3.Random()], [pin.Motion.Random(), pin.Motion.Random()]
    before, now = (hand.state(pose, twist) for pose, twist in zip(poses, twists, strict=True))
    reference, reading, weight = (before[7] + now[7]) / 2, pin.Force.Random(), 7.0
    expected = np.zeros(6)
    for pose, twist, rate in zip(poses, twists, (-1.0 / PERIOD, 1.0 / PERIOD), strict=True):
        to_reference = pin.SE3(pose.rotation, pose.translation - reference)
        arm = to_reference.act(hand.inertia.lever)
        up = np.array([0.0, 0.0, weight])
        expected += rate * to_reference.act(hand.inertia * twist).vector
        expected += (to_reference * hand.wrist).act(reading).vector / 2
        expected += np.r_[up, np.cross(arm, up)] / 2
    external_wrench(before, now, reading.vector, weight, PERIOD, found)
    assert found == pytest.approx(expected, rel=1e-10)


def test_both_hands_follow_tick_by_tick_from_rest_and_through_the_filter(random):
    hands, joints, share, weights = [Hand(random), Hand(random)], np.array([3, 1]), 0.3, []
    for hand in hands:
        hand.constants = (hand.inertia.mass, hand.inertia.lever, hand.inertia.inertia, table(hand.wrist))
        weights.append(hand.inertia.mass * GRAVITY)
    constants = [np.array(values) for values in zip(*(hand.constants for hand in hands), strict=True)]
    grippers = np.array([hand.gripper for hand in hands])
    states, filtered = np.full((2, *SHAPE), np.nan), np.full((2, 6), np.nan)
    before, expected = None, None
    for tick in range(4):
        poses, twists = [pin.SE3.Random() for _ in range(5)], [pin.Motion.Random(), pin.Motion.Random()]
        readings = random.normal(size=(4, 3))
        now = [h.state(poses[j], twist) for h, j, twist in zip(hands, joints, twists, strict=True)]
        sample = np.zeros((2, 6))
        for n, reading in enumerate(readings.reshape(2, 6)):
            external_wrench((before or now)[n], now[n], reading, weights[n], PERIOD, sample[n])
        expected = sample if expected is None else expected + share * (sample - expected)
        before = now
        follow_hands(
            np.array([table(pose) for pose in poses]), joints, twists[0].vector, twists[1].vector,
            *constants, grippers, *readings, GRAVITY, PERIOD, share, tick == 0, states, filtered,
        )  # fmt: skip
        np.testing.assert_array_equal(states, now)
        np.testing.assert_array_equal(filtered, expected)
