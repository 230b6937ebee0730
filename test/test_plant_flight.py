"""In the air: free fall, energy, and an independent integration with rotor inertia."""

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import GRAVITY_VECTOR, PASSIVE, center_of_mass, lift, plant_from, without

from follower_humanoid.robot.model import GRAVITY

FREE = {"stops.stiffness": 0.0, "stops.damping": 0.0, "motors.inductance": 0.0}


def tumbling(seed, joints=1.0):
    random = np.random.default_rng(seed)
    return np.concatenate((random.normal(0.0, 0.5, 6), random.uniform(-joints, joints, 45)))


def test_falls_freely():
    simulator = plant_from({})
    lift(simulator)
    start, _ = center_of_mass(simulator)
    joints, h = simulator.plant.q[7:].copy(), 0.001
    for n in range(1, 301):
        simulator.plant.step(np.zeros(45))
        # Bullet's semi-implicit Euler: z = −g h² n (n + 1)/2.
        place, speed = center_of_mass(simulator)
        assert place - start == pytest.approx(0.5 * n * (n + 1) * h * h * GRAVITY_VECTOR, abs=1e-9)
        assert speed == pytest.approx(n * h * GRAVITY_VECTOR, abs=1e-9)
    assert simulator.plant.q[7:] == pytest.approx(joints, abs=1e-9)
    simulator.close()


def test_linear_momentum_in_flight_is_only_gravitys():
    """No phantom damping: the CoM's path does not care what the limbs do."""
    simulator = plant_from(FREE)
    lift(simulator, tumbling(1))
    start, speed = center_of_mass(simulator)
    random = np.random.default_rng(2)
    for _ in range(300):
        simulator.plant.step(random.normal(0.0, 10.0, 45))
    place, end_speed = center_of_mass(simulator)
    assert end_speed == pytest.approx(speed + 0.3 * GRAVITY_VECTOR, abs=2e-3)
    assert place == pytest.approx(start + 0.3 * speed + 0.5 * 0.3**2 * GRAVITY_VECTOR, abs=3e-3)
    simulator.close()


def test_angular_momentum_in_flight_is_kept():
    simulator = plant_from(without(FREE, physics_step=2.5e-4))
    plant = simulator.plant
    lift(simulator, tumbling(3))
    data = plant.model.createData()
    start = pin.computeCentroidalMomentum(plant.model, data, plant.q, plant.v).angular.copy()
    random = np.random.default_rng(4)
    voltage = random.normal(0.0, 10.0, 45)
    for _ in range(800):
        plant.step(voltage)
    end = pin.computeCentroidalMomentum(plant.model, data, plant.q, plant.v).angular
    assert end == pytest.approx(start, abs=0.01 * np.linalg.norm(start) + 0.01)
    simulator.close()


def energy(plant):
    data, model = plant.model.createData(), plant.model
    return pin.computeKineticEnergy(model, data, plant.q, plant.v), pin.computePotentialEnergy(
        model, data, plant.q
    )


def energy_error(step):
    simulator = plant_from(without(PASSIVE, physics_step=step))
    plant = simulator.plant
    lift(simulator, tumbling(5, joints=1.5))
    kinetic, potential = energy(plant)
    for _ in range(round(0.2 / step)):
        plant.step(np.zeros(45))
    end_kinetic, end_potential = energy(plant)
    simulator.close()
    return (end_kinetic + end_potential - kinetic - potential) / kinetic


def test_passive_motion_keeps_its_energy():
    """The error is the integrator's own: it halves with the step."""
    coarse, fine = energy_error(4e-4), energy_error(2e-4)
    assert abs(fine) < 0.01
    assert fine / coarse == pytest.approx(0.5, abs=0.1)


def reference_motion(simulator, voltage, duration, step):
    """Pinocchio with armature, Runge–Kutta 4 in the tangent space: no part of the plant's code."""
    motors, model = simulator.plant.motors, simulator.plant.model.copy()
    model.armature = np.concatenate((np.zeros(6), motors.inertia))
    data = model.createData()
    gear = np.where(["toe" in name for name in simulator.plant.robot.joint_names], 20.0, 50.0)
    drive = gear * 0.0934 / 0.608 * voltage
    damping = gear**2 * (0.0934**2 / 0.608 + 1e-5)

    def rates(q, v):
        torque = np.concatenate((np.zeros(6), drive - damping * v[6:]))
        return v, pin.aba(model, data, q, v, torque)

    q, v = simulator.plant.q.copy(), simulator.plant.v.copy()
    for _ in range(round(duration / step)):
        v1, a1 = rates(q, v)
        v2, a2 = rates(pin.integrate(model, q, step / 2 * v1), v + step / 2 * a1)
        v3, a3 = rates(pin.integrate(model, q, step / 2 * v2), v + step / 2 * a2)
        v4, a4 = rates(pin.integrate(model, q, step * v3), v + step * a3)
        q = pin.integrate(model, q, step / 6 * (v1 + 2 * v2 + 2 * v3 + v4))
        v = v + step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q, v


def driven_motion_error(step):
    simulator = plant_from(without(FREE, physics_step=step))
    lift(simulator, tumbling(6))
    voltage = np.random.default_rng(7).normal(0.0, 8.0, 45)
    q, _ = reference_motion(simulator, voltage, 0.15, 5e-4)
    for _ in range(round(0.15 / step)):
        simulator.plant.step(voltage)
    error = pin.difference(simulator.plant.model, q, simulator.plant.q)
    simulator.close()
    return error


def test_agrees_with_an_independent_integration_with_rotor_inertia():
    coarse, fine = driven_motion_error(1e-3), driven_motion_error(5e-4)
    assert np.abs(coarse).max() < 0.01
    # First order, and what remains at step 0 is nothing but its second-order share.
    assert np.abs(fine).max() / np.abs(coarse).max() == pytest.approx(0.5, abs=0.08)
    assert np.abs(2 * fine - coarse).max() < 5e-4


def test_weightless_where_it_falls():
    simulator = plant_from({})
    lift(simulator)
    simulator.advance(simulator.Inputs())
    simulator.plant.motors.hold(np.zeros(45))
    assert np.linalg.norm(simulator.observe().imu.linear_acceleration) < 0.5 * GRAVITY
    assert simulator.observe().left_foot.force == pytest.approx(np.zeros(3))
    simulator.close()
