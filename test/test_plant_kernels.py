"""Pulls, sensor sums and the base's state, as compiled, against Pinocchio."""

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import Holding, plant, robot

from follower_humanoid.core.samples import Wrench
from follower_humanoid.plant.bullet_kernels import base_state
from follower_humanoid.plant.pulls import add_in_joint, add_pull, held_point
from follower_humanoid.plant.sensor_sums import add_joint_force, mean_acceleration, seen_from
from follower_humanoid.robot.pose_table import pose_table


@pytest.fixture
def random():
    return np.random.default_rng(9)


class Moving:
    """The robot in a random state: poses, world Jacobian and forces at no acceleration."""

    def __init__(self, random):
        self.model = robot().pin_model
        self.data = self.model.createData()
        self.q = pin.integrate(self.model, pin.neutral(self.model), random.normal(size=51))
        self.v = random.normal(size=51)
        pin.crba(self.model, self.data, self.q, pin.Convention.WORLD)
        pin.nonLinearEffects(self.model, self.data, self.q, self.v)
        self.poses = pose_table(self.data.oMi)


def table(pose):
    return np.vstack((pose.rotation.T, pose.translation))


def test_a_pull_enters_the_generalised_forces_through_the_jacobian_of_its_frame(random):
    moving, frame = Moving(random), robot().frame_id("r_gripper")
    point, place, forces = held_point(moving.model, frame), np.zeros(3), np.ones(51)
    force, torque = random.normal(size=(2, 3))
    pose = moving.poses[point.joint]
    add_pull(pose, point.offset, force, torque, moving.data.J, point.columns, place, forces)
    data = moving.model.createData()
    jacobian = pin.computeFrameJacobian(moving.model, data, moving.q, frame, pin.LOCAL_WORLD_ALIGNED)
    assert forces - 1.0 == pytest.approx(jacobian.T @ np.r_[force, torque], abs=1e-13)
    assert place == pytest.approx(pin.updateFramePlacement(moving.model, data, frame).translation, abs=1e-14)


def test_a_pull_in_its_joint_is_the_same_wrench_transported(random):
    pose, offset, total = pin.SE3.Random(), random.normal(size=3), np.zeros(6)
    force, torque = random.normal(size=(2, 3))
    add_in_joint(table(pose), offset, force, torque, total)
    at_point = pin.SE3(pose.rotation.T, offset)  # from world axes at the point
    assert total == pytest.approx(at_point.act(pin.Force(force, torque)).vector, abs=1e-14)


def test_the_force_through_a_wrist_is_that_of_inverse_dynamics(random):
    moving, acceleration = Moving(random), random.normal(size=51)
    point = held_point(moving.model, robot().frame_id("l_wrist"))
    hand, total = moving.model.inertias[point.joint], np.zeros(6)
    add_joint_force(
        moving.poses[point.joint], moving.data.J, point.columns, acceleration,
        moving.data.f[point.joint].vector, hand.mass, hand.lever, np.ascontiguousarray(hand.inertia), total,
    )  # fmt: skip
    data = moving.model.createData()
    pin.rnea(moving.model, data, moving.q, moving.v, acceleration)
    assert -total == pytest.approx(data.f[point.joint].vector, abs=1e-12)


def test_the_mean_acceleration_is_what_led_from_one_state_to_the_next(random):
    """Base and joints move at constant acceleration in world; the base's axes turn with it."""
    turn, step = pin.exp3(random.normal(size=3)), 1e-6
    velocity, spin, base, spin_rate = random.normal(size=(4, 3))
    (rates, joints), gravity = random.normal(size=(2, 45)), random.normal(size=3)
    later = pin.exp3(step * spin) @ turn
    v = np.r_[turn.T @ velocity, turn.T @ spin, rates]
    end = np.r_[
        later.T @ (velocity + step * base), later.T @ (spin + step * spin_rate), rates + step * joints
    ]
    found, felt = np.zeros(51), np.ones(3)
    twists = np.array([velocity, spin]), np.array([velocity + step * base, spin + step * spin_rate])
    mean_acceleration(v, end, *twists, np.ascontiguousarray(turn), gravity, step, found, felt)
    # By definition v̇ is the change of the components.
    assert found == pytest.approx((end - v) / step, abs=1e-4)
    assert felt - 1.0 == pytest.approx(turn.T @ (base - gravity), abs=1e-7)


def test_a_mean_wrench_is_transported_to_the_frame_of_the_sensor(random):
    pose, frame, total = pin.SE3.Random(), pin.SE3.Random(), random.normal(size=6)
    force, torque = np.zeros((2, 3))
    axes = np.ascontiguousarray(frame.rotation)
    seen_from(table(pose), axes, frame.translation, total, 4.0, force, torque)
    expected = (pose * frame).actInv(pin.Force(total / 4.0)).vector
    assert np.r_[force, torque] == pytest.approx(expected, abs=1e-14)


def test_the_base_is_found_from_the_centre_and_principal_axes_that_bullet_moves(random):
    base, axes, center = pin.SE3.Random(), pin.SE3.Random().rotation, random.normal(size=3)
    spin, velocity = random.normal(size=(2, 3))
    arm = base.rotation @ center
    quat = pin.Quaternion(base.rotation @ axes).coeffs()
    q, v, rotation, twist = (np.zeros(n) for n in (52, 51, (3, 3), (2, 3)))
    base_state(
        tuple(base.translation + arm), tuple(quat), tuple(velocity + np.cross(spin, arm)), tuple(spin),
        center, pin.Quaternion(axes.T).coeffs().copy(), q, v, rotation, twist,
    )  # fmt: skip
    assert rotation == pytest.approx(base.rotation, abs=1e-14)
    assert q[:3] == pytest.approx(base.translation, abs=1e-14)
    assert pin.Quaternion(q[3:7]).toRotationMatrix() == pytest.approx(base.rotation, abs=1e-14)
    assert twist == pytest.approx(np.array([velocity, spin]), abs=1e-14)
    assert v[:6] == pytest.approx(np.r_[base.rotation.T @ velocity, base.rotation.T @ spin], abs=1e-14)


def test_a_wrist_reading_is_the_mean_of_its_readings_at_every_physics_step():
    """A pull that turns with nobody: each step sees it in the axes that the hand has then."""
    fine, coarse = plant(period=0.001), plant(period=0.002)
    pull = Wrench(np.array([30.0, 10.0, 5.0]), np.array([1.0, 2.0, -1.0]))
    inputs = Holding(coarse).inputs(coarse.observe(), leader_left=pull)
    for _ in range(40):
        readings = []
        for _ in range(2):
            fine.advance(inputs)
            readings.append(fine.observe().left_wrist)
        coarse.advance(inputs)
        wrist = coarse.observe().left_wrist
        assert wrist.force == pytest.approx(sum(r.force for r in readings) / 2, abs=1e-9)
        assert wrist.torque == pytest.approx(sum(r.torque for r in readings) / 2, abs=1e-9)
    fine.close()
    coarse.close()
