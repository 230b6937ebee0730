"""Differential IK: feet, CoM and pelvis move as asked, and near the limits nothing runs away."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import robot, standing_configuration

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig

DT = 0.002


@pytest.fixture
def ik() -> DifferentialIk:
    return DifferentialIk(robot(), IkConfig(), standing_configuration())


def holding(ik: DifferentialIk) -> tuple[dict[Side, FootTask], BodyTask]:
    """Tasks that ask for what is."""
    feet = {
        side: FootTask(ik.soles[side][3].copy(), ik.soles[side][:3].T.copy(), np.zeros(3), np.zeros(3))
        for side in SIDES
    }
    rotation = ik.base[:3].T.copy()
    return feet, BodyTask(ik.com[:2], np.zeros(2), float(ik.q[2]), 0.0, rotation, np.zeros(3))


def moving(
    ik: DifferentialIk, rng: np.random.Generator, scale: float = 1.0
) -> tuple[dict[Side, FootTask], BodyTask]:
    """Tasks at the present place with random velocities."""
    feet, body = holding(ik)
    feet = {
        side: FootTask(
            task.position, task.rotation, scale * rng.normal(0, 0.2, 3), scale * rng.normal(0, 0.3, 3)
        )
        for side, task in feet.items()
    }
    com, lift, turn = rng.normal(0, 0.1, 2), rng.normal(0, 0.1), rng.normal(0, 0.2, 3)
    body = BodyTask(
        body.com, scale * com, body.pelvis_height, scale * lift, body.pelvis_rotation, scale * turn
    )
    return feet, body


def given(rng: np.random.Generator) -> Array:
    """Velocities of all joints; those of the legs must not count."""
    return np.asarray(rng.normal(0, 0.2, 45))


def finite_differences(
    before: Array, after: Array, dt: float
) -> tuple[dict[Side, Array], Array, float, Array]:
    """Sole twists in world, CoM velocity, pelvis climb and pelvis rate by forward kinematics."""
    model, poses = robot().pin_model, []
    for q in (before, after):
        data = model.createData()
        com = pin.centerOfMass(model, data, q).copy()
        pin.updateFramePlacements(model, data)
        soles = {side: data.oMf[robot().frame_id(f"{side.prefix}_sole")].copy() for side in SIDES}
        poses.append((soles, com, pin.Quaternion(q[3:7]).matrix()))
    (soles0, com0, pelvis0), (soles1, com1, pelvis1) = poses
    twists = {}
    for side in SIDES:
        turn = pin.log3(soles1[side].rotation @ soles0[side].rotation.T)
        twists[side] = np.concatenate((soles1[side].translation - soles0[side].translation, turn)) / dt
    return twists, (com1 - com0)[:2] / dt, (after[2] - before[2]) / dt, pin.log3(pelvis1 @ pelvis0.T) / dt


@pytest.mark.parametrize("seed", range(4))
def test_feet_com_and_pelvis_move_as_asked(ik: DifferentialIk, seed: int) -> None:
    rng, dt = np.random.default_rng(seed), 1e-6
    feet, body = moving(ik, rng)
    before = ik.q.copy()
    ik.advance(feet, body, given(rng), dt)
    twists, com, climb, turn = finite_differences(before, ik.q, dt)
    for side in SIDES:
        asked = np.concatenate((feet[side].linear_velocity, feet[side].angular_velocity))
        np.testing.assert_allclose(twists[side], asked, atol=1e-4)
    np.testing.assert_allclose(com, body.com_velocity, atol=1e-4)
    assert climb == pytest.approx(body.pelvis_height_velocity, abs=1e-4)
    np.testing.assert_allclose(turn, body.pelvis_angular_velocity, atol=1e-4)


def test_upper_body_and_toes_move_as_given_and_legs_as_solved(ik: DifferentialIk) -> None:
    rng = np.random.default_rng(7)
    feet, body = holding(ik)
    wanted = given(rng)
    ik.advance(feet, body, wanted, DT)
    legs = np.concatenate([robot().groups.leg(side)[:6] for side in SIDES])
    others = np.setdiff1d(np.arange(45), legs)
    np.testing.assert_array_equal(ik.v[6 + others], wanted[others])
    changed = wanted.copy()
    changed[legs] += 1.0
    again = DifferentialIk(robot(), IkConfig(), standing_configuration())
    again.advance(feet, body, changed, DT)
    np.testing.assert_array_equal(again.v, ik.v)


def test_asked_for_what_is_it_stays_exactly(ik: DifferentialIk) -> None:
    feet, body = holding(ik)
    before = ik.q.copy()
    for _ in range(10):
        ik.advance(feet, body, np.zeros(45), DT)
    np.testing.assert_allclose(ik.q, before, atol=1e-12)


def test_configuration_is_the_integral_of_velocity(ik: DifferentialIk) -> None:
    rng = np.random.default_rng(8)
    feet, body = moving(ik, rng)
    before = ik.q.copy()
    ik.advance(feet, body, given(rng), DT)
    np.testing.assert_allclose(pin.integrate(robot().pin_model, before, ik.v * DT), ik.q, atol=1e-14)


def test_forward_then_inverse_kinematics_returns_the_posture(ik: DifferentialIk) -> None:
    rng = np.random.default_rng(9)
    legs = np.concatenate([robot().groups.leg(side)[:6] for side in SIDES])
    target = standing_configuration().copy()
    target[:2] += rng.normal(0, 0.02, 2)
    target[2] -= 0.04
    turn = pin.exp3(rng.normal(0, 0.05, 3))
    target[3:7] = pin.Quaternion(turn).coeffs()
    target[7 + legs] += rng.normal(0, 0.06, 12)
    feet, body = holding(DifferentialIk(robot(), IkConfig(), target))
    for _ in range(2000):
        ik.advance(feet, body, np.zeros(45), DT)
    np.testing.assert_allclose(ik.q, target, atol=1e-5)


def test_errors_of_place_decay_at_the_chosen_gain() -> None:
    config = IkConfig(foot_gain=5.0, com_gain=3.0, pelvis_gain=2.0)
    ik = DifferentialIk(robot(), config, standing_configuration())
    feet, body = holding(ik)
    left, height, com = feet[Side.LEFT], body.pelvis_height - 0.02, body.com + np.array([0.01, 0.0])
    feet[Side.LEFT] = FootTask(
        left.position + np.array([0.0, 0.0, 0.02]), left.rotation, np.zeros(3), np.zeros(3)
    )
    body = BodyTask(com, np.zeros(2), height, 0.0, body.pelvis_rotation, np.zeros(3))
    for _ in range(250):
        ik.advance(feet, body, np.zeros(45), DT)
    t = 0.5
    assert feet[Side.LEFT].position[2] - ik.soles[Side.LEFT][3][2] == pytest.approx(
        0.02 * np.exp(-5.0 * t), rel=0.05
    )
    assert ik.q[2] - height == pytest.approx(0.02 * np.exp(-2.0 * t), rel=0.05)
    assert com[0] - ik.com[0] == pytest.approx(0.01 * np.exp(-3.0 * t), rel=0.05)


def test_correction_speed_of_a_foot_is_bounded(ik: DifferentialIk) -> None:
    feet, body = holding(ik)
    far = feet[Side.RIGHT]
    feet[Side.RIGHT] = FootTask(
        far.position + np.array([0.0, 0.0, 0.2]), far.rotation, np.zeros(3), np.zeros(3)
    )
    before = ik.soles[Side.RIGHT][3].copy()
    ik.advance(feet, body, np.zeros(45), DT)
    speed = (ik.soles[Side.RIGHT][3] - before) / DT
    assert speed[2] == pytest.approx(IkConfig().foot_speed, rel=0.02)


def raised(body: BodyTask, height: float) -> BodyTask:
    return body._replace(pelvis_height=height)


def knees(ik: DifferentialIk) -> Array:
    return ik.q[7 + np.array([robot().joint_index(f"{prefix}_knee") for prefix in "lr"])]


def test_nearly_stretched_legs_are_moved_gently(ik: DifferentialIk) -> None:
    # 2 cm above what the pelvis rule allows, 1 cm below the straight leg.
    feet, body = holding(ik)
    for _ in range(750):
        ik.advance(feet, raised(body, 0.90), np.zeros(45), DT)
        assert np.abs(ik.v).max() < 5.0
        assert knees(ik).min() > 0.2


def test_with_more_damping_even_an_impossible_height_does_no_harm() -> None:
    ik = DifferentialIk(robot(), IkConfig(damping=1e-2), standing_configuration())
    feet, body = holding(ik)
    for _ in range(1000):
        ik.advance(feet, raised(body, 0.95), np.zeros(45), DT)
        assert np.abs(ik.v).max() < 20.0
        assert knees(ik).min() > 0.0


def test_left_and_right_are_mirror_images(ik: DifferentialIk) -> None:
    feet, body = holding(ik)
    flip, turn = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    linear, angular = np.array([0.2, 0.05, 0.1]), np.array([0.1, -0.2, 0.3])
    left = dict(feet)
    left[Side.LEFT] = FootTask(feet[Side.LEFT].position, feet[Side.LEFT].rotation, linear, angular)
    right = dict(feet)
    right[Side.RIGHT] = FootTask(
        feet[Side.RIGHT].position, feet[Side.RIGHT].rotation, flip * linear, turn * angular
    )
    other = DifferentialIk(robot(), IkConfig(), standing_configuration())
    ik.advance(left, body, np.zeros(45), DT)
    other.advance(right, body, np.zeros(45), DT)
    for index, name in enumerate(robot().joint_names):
        if name[:2] not in ("l_", "r_") or index in robot().groups.arms:
            continue
        twin = robot().joint_index(f"{'r' if name[0] == 'l' else 'l'}_{name[2:]}")
        sign = -1.0 if name.endswith(("_yaw", "_roll")) else 1.0
        assert other.v[6 + twin] == pytest.approx(sign * ik.v[6 + index], abs=1e-6)
