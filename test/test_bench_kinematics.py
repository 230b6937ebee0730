"""Distances of the legs and forward kinematics of a recorded run."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import frame_pose, odometry_of, robot, standing_configuration

from follower_humanoid.bench.kinematics import Motion, motion_of, segment_distances
from follower_humanoid.core.samples import SIDES, Array, Joints, Side
from follower_humanoid.graph.record import RunRecorder

TICK = 0.002


def brute_force(p1: Array, q1: Array, p2: Array, q2: Array) -> float:
    """Least distance over a fine grid of both segments, refined once."""
    low, high = np.zeros(2), np.ones(2)
    best = np.zeros(2)
    for _ in range(4):
        s, t = (np.linspace(low[k], high[k], 41) for k in range(2))
        one = p1 + s[:, None] * (q1 - p1)
        two = p2 + t[:, None] * (q2 - p2)
        distance = np.linalg.norm(one[:, None] - two[None], axis=2)
        i, j = np.unravel_index(np.argmin(distance), distance.shape)
        best = np.array([s[i], t[j]])
        span = 2.0 * (high - low) / 40
        low, high = np.maximum(best - span, 0.0), np.minimum(best + span, 1.0)
    return float(distance.min())


def test_segment_distances_agree_with_brute_force() -> None:
    rng = np.random.default_rng(1)
    ends = [rng.normal(size=(200, 3)) for _ in range(4)]
    found = segment_distances(*ends)
    expected = [brute_force(*(end[k] for end in ends)) for k in range(200)]
    np.testing.assert_allclose(found, expected, atol=1e-3)


@pytest.mark.parametrize(
    ("p1", "q1", "p2", "q2", "distance"),
    [
        ((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), 1.0),  # parallel, side by side
        ((0, 0, 0), (1, 0, 0), (3, 0, 0), (4, 0, 0), 2.0),  # in line
        ((0, 0, 0), (1, 0, 0), (2, 1, 0), (3, 1, 0), np.sqrt(2)),  # parallel, past each other
        ((0, 0, 0), (1, 0, 0), (3, 1, 0), (0.5, 1, 0), 1.0),  # antiparallel, overlapping
        ((0, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 0), 0.0),  # crossing
        ((0, 0, 0), (1, 0, 0), (0.5, 0.5, -1), (0.5, 0.5, 1), 0.5),  # skew
        ((0, 0, 0), (1, 0, 0), (0.5, 0.3, 0), (0.5, 2, 0), 0.3),  # end over middle
        ((0, 0, 0), (1, 0, 0), (2, 1, 1), (3, 3, 3), np.sqrt(3)),  # end to end
    ],
)
def test_segment_distances_by_hand(
    p1: tuple[float, ...],
    q1: tuple[float, ...],
    p2: tuple[float, ...],
    q2: tuple[float, ...],
    distance: float,
) -> None:
    one = [np.array([end], dtype=float) for end in (p1, q1, p2, q2)]
    assert segment_distances(*one)[0] == pytest.approx(distance, abs=1e-9)
    assert segment_distances(one[2], one[3], one[0], one[1])[0] == pytest.approx(distance, abs=1e-9)
    assert segment_distances(one[1], one[0], one[3], one[2])[0] == pytest.approx(distance, abs=1e-9)


def recorded(rows: list[tuple[Array, Array]]) -> Motion:
    recorder = RunRecorder(TICK, robot().joint_names, robot().urdf)
    for tick, (q, v) in enumerate(rows):
        recorder.add("joint_states", tick, Joints(q[7:], v[6:], np.zeros(45)))
        recorder.add("odom", tick, odometry_of(q, v))
    return motion_of(recorder.finish(), robot=robot())


def test_motion_is_the_forward_kinematics_of_what_was_recorded() -> None:
    rng = np.random.default_rng(2)
    model = robot().pin_model
    rows = []
    for _ in range(3):
        q = pin.integrate(model, standing_configuration(), rng.normal(0, 0.1, model.nv))
        rows.append((np.array(q), rng.normal(0, 0.3, model.nv)))
    motion = recorded(rows)
    np.testing.assert_allclose(motion.times, [0.0, TICK, 2 * TICK])
    for row, (q, v) in enumerate(rows):
        data = model.createData()
        pin.centerOfMass(model, data, q, v)
        np.testing.assert_allclose(motion.com[row], data.com[0], atol=1e-12)
        np.testing.assert_allclose(motion.momentum[row, :3], robot().mass * data.vcom[0], atol=1e-9)
        for side in SIDES:
            sole = frame_pose(q, f"{side.prefix}_sole")
            np.testing.assert_allclose(motion.sole[side][row], sole.translation, atol=1e-12)
            np.testing.assert_allclose(motion.sole_rotation[side][row], sole.rotation, atol=1e-12)
            grip = frame_pose(q, f"{side.prefix}_gripper").translation
            np.testing.assert_allclose(motion.gripper[side][row], grip, atol=1e-12)
            away = pin.rpy.rpyToMatrix(0.0, 0.0, -motion.pelvis_yaw[row]) @ (grip - q[:3])
            np.testing.assert_allclose(motion.hand[side][row], away, atol=1e-12)
        for number in range(6):
            for k, prefix in enumerate("lr"):
                place = frame_pose(q, f"{prefix}_contact_{number + 1}").translation
                np.testing.assert_allclose(motion.contacts[row, 6 * k + number], place, atol=1e-12)


def test_angular_momentum_is_about_the_com() -> None:
    # A robot that spins as one rigid body about its CoM has no linear momentum.
    q = standing_configuration()
    data = robot().pin_model.createData()
    com = pin.centerOfMass(robot().pin_model, data, q).copy()
    turn = np.array([0.0, 0.0, 2.0])
    v = np.zeros(51)
    v[3:6] = turn
    v[:3] = np.cross(turn, q[:3] - com)
    motion = recorded([(q, v), (q, v)])
    np.testing.assert_allclose(motion.momentum[0, :3], np.zeros(3), atol=1e-9)
    inertia = pin.ccrba(robot().pin_model, data, q, v)[3:6, 5]
    np.testing.assert_allclose(motion.momentum[0, 3:], 2.0 * inertia, atol=1e-9)
    assert motion.momentum[0, 5] > 0.0


def test_legs_that_come_together_come_near() -> None:
    apart = standing_configuration()
    near = apart.copy()
    for prefix, sign in (("l", -1.0), ("r", 1.0)):
        near[7 + robot().joint_index(f"{prefix}_hip_roll")] = 0.05 * sign
    crossed = apart.copy()
    for prefix, sign in (("l", -1.0), ("r", 1.0)):
        crossed[7 + robot().joint_index(f"{prefix}_hip_roll")] = 0.12 * sign
    gaps = recorded([(q, np.zeros(51)) for q in (apart, near, crossed)]).leg_gap
    # Thighs of 6.5 cm radius, 18 cm apart; soles 10 cm wide.
    assert 0.03 < gaps[0] < 0.09
    assert gaps[0] > gaps[1] > gaps[2]
    assert gaps[2] < 0.0


def test_every_so_many_ticks() -> None:
    q, v = standing_configuration(), np.zeros(51)
    recorder = RunRecorder(TICK, robot().joint_names, robot().urdf)
    for tick in range(11):
        recorder.add("joint_states", tick, Joints(q[7:], v[6:], np.zeros(45)))
        recorder.add("odom", tick, odometry_of(q, v))
    motion = motion_of(recorder.finish(), every=4, robot=robot())
    np.testing.assert_allclose(motion.times, [0.0, 4 * TICK, 8 * TICK])
    assert len(motion.sole[Side.LEFT]) == 3
