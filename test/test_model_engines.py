"""PyBullet and Pinocchio compute the same robot: mass matrix and forward dynamics to 1e-8."""

import numpy as np
import pinocchio as pin
import pybullet
import pytest
from bullet_reference import Reference
from plant_bench import HIGH_UP, plant_from, robot

from follower_humanoid.plant.pulls import Pull
from follower_humanoid.plant.simulator import Simulator
from follower_humanoid.robot.model import RobotModel

SEEDS = range(4)


@pytest.fixture(scope="module")
def simulator():
    simulator = plant_from({"motors.rotor_inertia": 0.0})
    yield simulator
    simulator.close()


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    loaded = Reference(tmp_path_factory.mktemp("urdf"))
    yield loaded
    loaded.close()


def random_state(simulator, seed, speed=1.0):
    random = np.random.default_rng(seed)
    q = simulator.plant.q.copy()
    q[:3] = random.normal(0.0, 1.0, 3)
    q[2] += HIGH_UP
    q[3:7] = pin.Quaternion(pin.exp3(random.normal(0.0, 1.0, 3))).coeffs()
    q[7:] = random.uniform(-1.0, 1.0, 45)
    return q, speed * random.normal(0.0, 1.0, 51), random


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrices_agree(simulator, loaded, seed):
    plant = simulator.plant
    q, v, _ = random_state(simulator, seed, 0.0)
    plant.bullet.place(q, v)
    order = np.argsort(np.argsort(loaded.joints))
    joints = np.empty(45)
    joints[order] = q[7:]
    found = pybullet.calculateMassMatrix(loaded.body, joints.tolist(), physicsClientId=loaded.client)
    found = np.array(found)
    model, data = plant.model.copy(), plant.model.createData()
    model.armature = np.zeros(51)
    expected = pin.crba(model, data, q)
    expected = np.triu(expected) + np.triu(expected, 1).T
    # PyBullet: base angular, then linear; joints in the order of its links.
    assert found[np.ix_(6 + order, 6 + order)] == pytest.approx(expected[6:, 6:], rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_forward_dynamics_agree(simulator, seed):
    """Acceleration from one tiny Bullet step against Pinocchio's articulated-body algorithm."""
    plant = simulator.plant
    q, v, random = random_state(simulator, seed)
    torque = random.normal(0.0, 30.0, 45)
    plant.bullet.place(q, v)
    before, rotation = plant.v.copy(), plant.bullet.rotation
    speed = plant.bullet.base_velocity
    plant.bullet.drive(torque)
    plant.world.step()
    plant.bullet.read()
    h = plant.world.step_length
    model, data = plant.model.copy(), plant.model.createData()
    model.armature = np.zeros(51)
    expected = pin.aba(model, data, q, v, np.concatenate((np.zeros(6), torque)))
    found = (plant.v - before) / h
    assert found[6:] == pytest.approx(expected[6:], rel=1e-8, abs=1e-7)
    spin = (plant.bullet.rotation @ plant.v[3:6] - rotation @ v[3:6]) / h
    assert rotation.T @ spin == pytest.approx(expected[3:6], rel=1e-8, abs=1e-7)
    # Bullet steps the velocity of the base's CoM; that of base_link follows from it.
    center = plant.bullet.center_in_base
    expected_com = rotation @ (
        expected[:3] + np.cross(v[3:6], v[:3])
        + np.cross(expected[3:6], center) + np.cross(v[3:6], np.cross(v[3:6], center))
    )  # fmt: skip
    after = plant.bullet.base_velocity + np.cross(
        plant.bullet.rotation @ plant.v[3:6], plant.bullet.rotation @ center
    )
    start = speed + np.cross(rotation @ v[3:6], rotation @ center)
    assert (after - start) / h == pytest.approx(expected_com, rel=1e-8, abs=1e-7)


def test_same_mass_in_both(simulator, loaded):
    plant = simulator.plant
    links = range(-1, pybullet.getNumJoints(loaded.body, physicsClientId=loaded.client))
    masses = [pybullet.getDynamicsInfo(loaded.body, n, physicsClientId=loaded.client)[0] for n in links]
    assert sum(masses) == pytest.approx(sum(i.mass for i in plant.model.inertias), rel=1e-12)


@pytest.mark.parametrize("turned", [False, True])
def test_prediction_is_what_bullet_does(turned, tmp_path):
    """With soles, motors, pulls and torques at once, the solution is the engine's acceleration.

    Turned: a URDF whose base has its principal axes elsewhere, as PyBullet's base frame then has.
    """
    path = tmp_path / "turned.urdf"
    rpy = 'rpy="0.3 -0.2 0.5"' if turned else 'rpy="0 0 0"'
    path.write_text(robot().urdf.replace('rpy="0 0 0"', rpy, 1), encoding="utf-8")
    simulator = Simulator(Simulator.Config(), RobotModel(str(path)), 0.002)
    plant = simulator.plant
    frames = [plant.robot.frame_id(name) for name in ("l_gripper", "r_gripper", "base_link")]
    random = np.random.default_rng(5)
    voltage = plant.motors.voltage.copy()
    largest = 0.0
    for n in range(150):
        pulls = tuple(Pull(f, random.normal(0, 20, 3), random.normal(0, 4, 3)) for f in frames)
        before, turn = plant.v.copy(), plant.rotation
        plant.step(voltage + 3.0 * np.sin(0.02 * n), pulls)
        if plant.settled:
            joints = (plant.v[6:] - before[6:]) / plant.world.step_length
            spin = (plant.rotation @ plant.v[3:6] - turn @ before[3:6]) / plant.world.step_length
            largest = max(largest, np.abs(joints - plant.acceleration[6:]).max())
            largest = max(largest, np.abs(spin - turn @ plant.acceleration[3:6]).max())
    assert largest < 1e-7
    simulator.close()
