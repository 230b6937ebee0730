"""Eq. (11): sink, decay and slip of the soles against closed forms."""

import numpy as np
import pytest
from plant_bench import RIGID, center_of_mass, commands, plant_from, plant_mass, scaled, without

from follower_humanoid.core.samples import Wrench
from follower_humanoid.plant.simulator import Simulator
from follower_humanoid.robot.model import GRAVITY

CENTERED = without(RIGID, standing__com_ahead=0.08)  # CoM over the middle of the points: pure heave


def hold_voltage(simulator):
    return simulator.plant.motors.voltage.copy()


def test_static_sink_carries_the_weight():
    simulator = plant_from(CENTERED)
    sink = -simulator.plant.soles.points[:, 2]
    expected = plant_mass(simulator) * GRAVITY / (12 * 1.0e5)
    assert sink == pytest.approx(np.full(12, expected), rel=1e-9)
    simulator.close()


@pytest.mark.parametrize("stiffness", [2.0e4, 1.0e5, 3.0e5])
def test_heave_decays_as_the_implicit_spring_damper(stiffness):
    simulator = plant_from(without(CENTERED, soles__stiffness=stiffness))
    plant, mass, h = simulator.plant, plant_mass(simulator), 0.001
    voltage = hold_voltage(simulator)
    rest = plant.q[2]
    offset, rate = -0.3 * mass * GRAVITY / (12 * stiffness), 0.0
    q = plant.q.copy()
    q[2] += offset
    plant.bullet.place(q, np.zeros(51))
    k, d = 12 * stiffness / mass, 12 * 1000.0 / mass
    for _ in range(100):
        plant.step(voltage)
        rate = (rate - h * k * offset) / (1 + h * d + h * h * k)  # backward Euler, solved by hand
        offset += h * rate
        assert plant.q[2] - rest == pytest.approx(offset, abs=2e-3 * mass * GRAVITY / (12 * stiffness))
    simulator.close()


def test_heave_approaches_the_exact_decay_at_small_steps():
    simulator = plant_from(without(CENTERED, physics_step=1e-4))
    plant, mass = simulator.plant, plant_mass(simulator)
    voltage, rest = hold_voltage(simulator), plant.q[2]
    q = plant.q.copy()
    q[2] -= 2e-4
    plant.bullet.place(q, np.zeros(51))
    omega = np.sqrt(12 * 1e5 / mass)
    zeta = 12 * 1e3 / mass / (2 * omega)
    damped = omega * np.sqrt(1 - zeta**2)
    for n in range(1, 301):
        plant.step(voltage)
        t = n * 1e-4
        shape = np.cos(damped * t) + zeta * omega / damped * np.sin(damped * t)
        exact = -2e-4 * np.exp(-zeta * omega * t) * shape
        assert plant.q[2] - rest == pytest.approx(exact, abs=3e-6)
    simulator.close()


def level_push(simulator, force, friction_force):
    """A horizontal push whose line of action lets the soles' pressure stay as it is."""
    center, _ = center_of_mass(simulator)
    height = center[2] * (1 - friction_force / force)
    return Wrench(
        np.array([force, 0.0, 0.0]), np.array([0.0, (height - simulator.plant.q[2]) * force, 0.0])
    )


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_sticks_below_the_cone_and_gives_like_its_springs(friction):
    simulator = plant_from(without(CENTERED, ground__friction=friction))
    voltage, start = hold_voltage(simulator), simulator.plant.soles.points[:, 0].mean()
    force = 0.95 * friction * plant_mass(simulator) * GRAVITY
    push = Wrench(np.array([force, 0.0, 0.0]), np.array([0.0, -simulator.plant.q[2] * force, 0.0]))
    for n in range(500):
        simulator.advance(commands(voltage, push=scaled(push, min(1.0, n / 100))))
        if n == 300:
            anchors = simulator.plant.soles.points[:, 0].copy()
    # The rigid body still rocks by micrometres on its springs, but no point creeps away.
    assert np.abs(simulator.plant.soles.points[:, 0] - anchors).max() < 5e-6
    assert simulator.plant.soles.force[:, 0].sum() == pytest.approx(-force, rel=5e-3)
    stretch = simulator.plant.soles.points[:, 0].mean() - start
    assert stretch == pytest.approx(force / (12 * 1e5), rel=0.2)
    simulator.close()


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_slips_beyond_the_cone_with_coulomb_friction(friction):
    simulator = plant_from(without(CENTERED, ground__friction=friction))
    voltage, mass = hold_voltage(simulator), plant_mass(simulator)
    limit = friction * mass * GRAVITY
    force = 1.3 * limit
    push = level_push(simulator, force, limit)
    speeds = []
    for _ in range(100):
        simulator.advance(commands(voltage, push=push))
        speeds.append(center_of_mass(simulator)[1][0])
    acceleration = (speeds[-1] - speeds[50]) / (49 * 0.002)
    assert acceleration == pytest.approx((force - limit) / mass, rel=0.01)
    forces = simulator.plant.soles.force
    pull = np.hypot(forces[:, 0], forces[:, 1])
    assert pull == pytest.approx(friction * forces[:, 2], rel=1e-2)
    simulator.close()


def test_forces_stay_inside_the_cone_and_never_pull():
    simulator = plant_from({})
    random = np.random.default_rng(3)
    plant, voltage = simulator.plant, hold_voltage(simulator)
    for n in range(400):
        plant.step(voltage + 10.0 * np.sin(0.03 * n) + random.normal(0.0, 2.0, 45))
        normal = plant.soles.force[:, 2]
        pull = np.hypot(plant.soles.force[:, 0], plant.soles.force[:, 1])
        assert normal.min() >= 0.0
        assert np.all(pull <= 0.8 * normal * 1.01 + 0.2)
    simulator.close()


@pytest.mark.parametrize("step", [0.0005, 0.001, 0.002, 0.004])
@pytest.mark.parametrize("stiffness", [2.0e4, 3.0e5])
def test_stands_for_all_steps_and_stiffnesses(step, stiffness):
    simulator = plant_from({"physics_step": step, "soles.stiffness": stiffness}, period=step)
    plant = simulator.plant
    start = plant.q.copy()
    for _ in range(round(0.4 / step)):
        simulator.advance(Simulator.Inputs())
    assert np.abs(plant.q - start).max() < 1e-6
    simulator.close()


def test_on_a_slope_the_weight_pulls_down_hill_and_the_ground_answers():
    slope = 0.03
    simulator = plant_from(without(CENTERED, ground__slope=slope))
    voltage, weight = hold_voltage(simulator), plant_mass(simulator) * GRAVITY
    forces = []
    for _ in range(200):
        simulator.advance(commands(voltage))
        forces.append(simulator.plant.soles.force.sum(axis=0))
    assert np.mean(forces, axis=0)[0] == pytest.approx(-weight * np.sin(slope), rel=0.1)
    assert np.mean(forces, axis=0)[2] == pytest.approx(weight * np.cos(slope), rel=1e-2)
    simulator.close()
