"""Foot wrenches, wrist sensors, IMU: they balance the motion; errors are seeded."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import (
    GRAVITY_VECTOR,
    RIGID,
    Holding,
    center_of_mass,
    commands,
    in_world,
    plant_from,
    plant_mass,
    robot,
)  # fmt: skip

from follower_humanoid.core.samples import Wrench
from follower_humanoid.plant.sensor_errors import SensorConfig, SensorErrors
from follower_humanoid.robot.model import GRAVITY


def shaken(simulator, ticks, **wrenches):
    """Ticks of a robot that stands and is shaken by its own motors; yields after each tick."""
    holding, random = Holding(simulator, 200.0, 5.0), np.random.default_rng(1)
    voltage = random.normal(0.0, 4.0, 45)
    for n in range(ticks):
        inputs = commands(
            holding.voltage(simulator.observe()) + voltage * np.sin(0.05 * n), **wrenches
        )
        simulator.advance(inputs)
        yield simulator.observe()


def feet_in_world(simulator, state):
    """Total foot force and moment about the world origin, both from the published wrenches."""
    data = simulator.plant.model.createData()
    pin.framesForwardKinematics(simulator.plant.model, data, simulator.plant.q)
    force, moment = np.zeros(3), np.zeros(3)
    for prefix, wrench in (("l", state.left_foot), ("r", state.right_foot)):
        pose = data.oMf[robot().frame_id(f"{prefix}_sole")]
        pushed = pose.rotation @ wrench.force
        force += pushed
        moment += pose.rotation @ wrench.torque + np.cross(pose.translation, pushed)
    return force, moment


def test_linear_momentum_balances_every_tick():
    simulator = plant_from({})
    pull = Wrench(np.array([15.0, 5.0, -10.0]), np.zeros(3))
    mass = plant_mass(simulator)
    _, before = center_of_mass(simulator)
    errors = []
    push = Wrench(np.array([0.0, 8.0, 0.0]), np.zeros(3))
    for state in shaken(simulator, 200, leader_left=pull, push=push):
        _, after = center_of_mass(simulator)
        force, _ = feet_in_world(simulator, state)
        force += state.left_applied.force + state.right_applied.force + state.base_applied.force
        errors.append(mass * ((after - before) / 0.002 - GRAVITY_VECTOR) - force)
        before = after
    assert np.sqrt(np.mean(np.square(errors))) < 0.3
    assert np.abs(np.mean(errors, axis=0)).max() < 0.05
    simulator.close()


def test_angular_momentum_balances():
    simulator = plant_from({})
    model = simulator.plant.model
    data = model.createData()

    def angular():
        pin.computeCentroidalMomentum(model, data, simulator.plant.q, simulator.plant.v)
        return data.hg.angular + np.cross(data.com[0], data.hg.linear), data.com[0].copy()

    before, _ = angular()
    errors = []
    for state in shaken(simulator, 200):
        after, center = angular()
        _, moment = feet_in_world(simulator, state)
        gravity = np.cross(center, plant_mass(simulator) * GRAVITY_VECTOR)
        errors.append((after - before) / 0.002 - moment - gravity)
        before = after
    assert np.sqrt(np.mean(np.square(errors))) < 0.5
    assert np.abs(np.mean(errors, axis=0)).max() < 0.1
    simulator.close()


@pytest.mark.parametrize("load", [0.0, 3.0])
def test_wrist_sensor_at_rest_reads_the_hands_weight(load):
    simulator = plant_from({"body.left_hand_load": load})
    state = simulator.observe()
    mass = robot().pin_model.inertias[robot().pin_model.getJointId("l_wrist_roll")].mass + load
    force = in_world(simulator, "l_wrist", state.left_wrist.force)
    assert force == pytest.approx([0.0, 0.0, -mass * GRAVITY], abs=1e-9)
    # Held forward, the hand's weight turns it nose down: about +y.
    lever = 0.06 if load == 0.0 else (0.06 * (mass - load) + 0.09 * load) / mass
    moment = in_world(simulator, "l_wrist", state.left_wrist.torque)
    horizontal = np.cos(0.07) * lever
    assert moment[1] == pytest.approx(mass * GRAVITY * horizontal, rel=1e-2)
    simulator.close()


@pytest.mark.parametrize(("side", "prefix"), [("left", "l"), ("right", "r")])
def test_wrist_sensor_reads_what_pulls_the_hand(side, prefix):
    simulator = plant_from(RIGID)
    rest = getattr(simulator.observe(), f"{side}_wrist")
    pull = Wrench(np.array([6.0, -3.0, -10.0]), np.array([0.2, 0.5, -0.1]))
    voltage = simulator.plant.motors.voltage.copy()
    for _ in range(1000):
        simulator.advance(commands(voltage, **{f"leader_{side}": pull}))
    state = getattr(simulator.observe(), f"{side}_wrist")
    force = in_world(simulator, f"{prefix}_wrist", state.force - rest.force)
    assert force == pytest.approx(pull.force, abs=0.02)
    data = simulator.plant.model.createData()
    pin.framesForwardKinematics(simulator.plant.model, data, simulator.plant.q)
    wrist, gripper = (data.oMf[robot().frame_id(f"{prefix}_{n}")].translation for n in ("wrist", "gripper"))
    moment = in_world(simulator, f"{prefix}_wrist", state.torque - rest.torque)
    assert moment == pytest.approx(pull.torque + np.cross(gripper - wrist, pull.force), abs=0.01)
    simulator.close()


def test_wrist_sensor_feels_the_hands_inertia():
    """In motion the sensor is weight and inertia of the hand: m (g − c̈)."""
    simulator = plant_from({})
    model = simulator.plant.model
    joint = model.getJointId("l_wrist_roll")
    mass, lever = model.inertias[joint].mass, model.inertias[joint].lever
    data = model.createData()

    def hand_velocity():
        pin.forwardKinematics(model, data, simulator.plant.q, simulator.plant.v)
        velocity = data.oMi[joint].act(data.v[joint])  # at the world origin
        place = data.oMi[joint].act(lever)
        return velocity.linear + np.cross(velocity.angular, place)

    before, errors, sizes = hand_velocity(), [], []
    for state in shaken(simulator, 150):
        after = hand_velocity()
        expected = mass * (GRAVITY_VECTOR - (after - before) / 0.002)
        errors.append(in_world(simulator, "l_wrist", state.left_wrist.force) - expected)
        sizes.append(expected - mass * GRAVITY_VECTOR)
        before = after
    assert np.sqrt(np.mean(np.square(errors))) < 0.02 * np.sqrt(np.mean(np.square(sizes))) + 0.01
    simulator.close()


def test_imu_reads_specific_force_and_spin():
    simulator = plant_from({})
    before = simulator.plant.bullet.base_velocity
    for state in shaken(simulator, 100):
        after = simulator.plant.bullet.base_velocity
        acceleration = in_world(simulator, "base_link", state.imu.linear_acceleration) + GRAVITY_VECTOR
        assert acceleration == pytest.approx((after - before) / 0.002, abs=0.1)
        assert state.imu.angular_velocity == pytest.approx(state.odometry.angular_velocity)
        before = after
    simulator.close()


def test_odometry_is_the_link_frame_not_its_center_of_mass():
    simulator = plant_from({})
    for state in shaken(simulator, 50):
        plant = simulator.plant
        assert state.odometry.position == pytest.approx(plant.q[:3])
        data = plant.model.createData()
        pin.forwardKinematics(plant.model, data, plant.q, plant.v)
        assert state.odometry.linear_velocity == pytest.approx(data.v[1].linear, abs=1e-12)
        assert state.odometry.angular_velocity == pytest.approx(data.v[1].angular, abs=1e-12)
    simulator.close()


NOISY = {
    "sensors.position_noise": 1e-4, "sensors.wrist_force_noise": 0.5, "sensors.foot_force_noise": 2.0,
    "sensors.accelerometer_noise": 0.1, "sensors.gyro_noise": 0.01, "sensors.velocity_noise": 0.01,
    "sensors.odometry_position_noise": 1e-3, "sensors.odometry_velocity_noise": 1e-3,
}  # fmt: skip


def noisy_readings(seed):
    simulator = plant_from({**NOISY, "sensors.seed": seed})
    readings = []
    for _ in range(300):
        simulator.advance(simulator.Inputs())
        readings.append(simulator.observe().left_wrist.force)
    simulator.close()
    return np.array(readings)


def test_noise_is_seeded_and_as_large_as_asked():
    first, again, other = noisy_readings(1), noisy_readings(1), noisy_readings(2)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert first.std(axis=0) == pytest.approx(np.full(3, 0.5), rel=0.15)


def test_observing_twice_is_observing_once():
    simulator = plant_from(NOISY)
    simulator.advance(simulator.Inputs())
    first, second = simulator.observe(), simulator.observe()
    assert np.array_equal(first.joints.position, second.joints.position)
    assert np.array_equal(first.left_wrist.force, second.left_wrist.force)
    simulator.close()


def test_biases_add_to_the_truth():
    plain = plant_from({}).observe()
    biased = plant_from(
        {"sensors.left_wrist_bias": (1.0, -2.0, 0.5), "sensors.accelerometer_bias": (0.1, 0.0, 0.0)}
    ).observe()
    assert biased.left_wrist.force - plain.left_wrist.force == pytest.approx([1.0, -2.0, 0.5])
    assert biased.right_wrist.force == pytest.approx(plain.right_wrist.force)
    assert biased.imu.linear_acceleration[0] - plain.imu.linear_acceleration[0] == pytest.approx(0.1)


def test_sensors_are_exact_until_any_of_their_errors_is_asked_for():
    assert not SensorErrors(SensorConfig(seed=5)).any
    for error in (entry.name for entry in dataclasses.fields(SensorConfig) if entry.name != "seed"):
        size = (0.0, 0.0, 1e-3) if error.endswith("_bias") else 1e-3
        assert SensorErrors(SensorConfig(**{error: size})).any, error


def test_an_error_that_nobody_asked_for_leaves_a_reading_as_it_is():
    """Only one hand has a bias: every other reading goes through the errors unchanged, bit for bit."""
    plain = plant_from({}).observe()
    biased = plant_from({"sensors.left_wrist_bias": (1.0, 0.0, 0.0)}).observe()
    for name in ("joints", "odometry", "imu", "left_foot", "right_foot", "right_wrist"):
        exact, found = getattr(plain, name), getattr(biased, name)
        for entry in dataclasses.fields(exact):
            assert np.array_equal(getattr(exact, entry.name), getattr(found, entry.name)), (name, entry.name)


def test_only_the_plant_knows_its_own_masses():
    simulator = plant_from({"body.mass_scale": 1.1, "body.right_hand_load": 2.0})
    assert plant_mass(simulator) == pytest.approx(1.1 * robot().mass + 2.0)
    state = simulator.observe()
    total = state.left_foot.force[2] + state.right_foot.force[2]
    assert total == pytest.approx(plant_mass(simulator) * GRAVITY, rel=1e-4)
    simulator.close()
