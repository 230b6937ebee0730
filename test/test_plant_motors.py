"""Corrected eqs. (12), (13): step response, no-load speed, limits, current, parameter sets."""

import numpy as np
import pytest
from plant_bench import lift, plant_from, robot

from follower_humanoid.core.config import build
from follower_humanoid.plant.motors import PAPER_MOTORS, MotorConfig, Motors

STEP = 0.001
KNEE = robot().joint_index("l_knee")
TOE = robot().joint_index("l_toe_pitch")


def motors(step=STEP, **values):
    return Motors(build(MotorConfig, values), robot(), step)


def spin(motor, voltage, inertia, seconds, step=STEP):
    """Speeds of 45 free flywheels of some inertia [kg·m²] on the output side."""
    speed, history = np.zeros(45), []
    for _ in range(round(seconds / step)):
        torque = np.zeros(45)
        motor.begin(np.full(45, voltage), speed, torque)
        acceleration = torque / (inertia + motor.inertia + step * motor.damping)
        torque = motor.finish(acceleration, speed)
        speed = speed + step * acceleration
        assert torque == pytest.approx(inertia * acceleration)  # what reaches the flywheel turns it
        history.append(speed.copy())
    return np.array(history)


def begin(motor, voltage):
    """A step at rest."""
    motor.begin(np.full(45, voltage), np.zeros(45), np.zeros(45))


def test_no_load_speed():
    speeds = spin(motors(viscous_loss=0.0), 24.0, 0.0, 1.0)[-1]
    assert speeds[KNEE] == pytest.approx(24.0 / (50 * 0.0934), rel=1e-6)
    assert speeds[TOE] == pytest.approx(24.0 / (20 * 0.0934), rel=1e-6)


def test_step_response_is_the_first_order_lag():
    step, inertia = 1e-4, 0.5
    speeds = spin(motors(step, viscous_loss=0.0, inductance=0.0), 10.0, inertia, 0.1, step)[:, KNEE]
    time = step * np.arange(1, len(speeds) + 1)
    constant = (inertia + 50**2 * 5.36e-5) * 0.608 / (50 * 0.0934) ** 2
    exact = 10.0 / (50 * 0.0934) * (1 - np.exp(-time / constant))
    assert speeds == pytest.approx(exact, abs=0.01 * exact[-1])


def test_current_rises_with_the_electrical_time_constant():
    step, henry = 1e-5, 2.3e-3
    motor = motors(step, inductance=henry)
    currents = []
    for _ in range(1000):
        begin(motor, 6.08)
        motor.finish(np.zeros(45), np.zeros(45))  # stalled
        currents.append(motor.current[KNEE])
    time = step * np.arange(1, 1001)
    assert currents == pytest.approx(10.0 * (1 - np.exp(-time * 0.608 / henry)), abs=0.02)


def test_inductance_matters_only_for_some_milliseconds():
    without = spin(motors(inductance=0.0), 10.0, 0.5, 0.5)[:, KNEE]
    real = spin(motors(), 10.0, 0.5, 0.5)[:, KNEE]
    assert real[-1] == pytest.approx(without[-1], rel=1e-6)
    assert np.abs(real - without).max() < 0.07 * without[-1]


def test_voltage_is_limited():
    motor = motors()
    begin(motor, 1000.0)
    assert motor.voltage == pytest.approx(np.full(45, 48.0))
    begin(motor, -1000.0)
    assert motor.voltage == pytest.approx(np.full(45, -48.0))


def test_stall_torque():
    motor = motors(inductance=0.0)
    begin(motor, 48.0)
    torque = motor.finish(np.zeros(45), np.zeros(45))
    assert torque[KNEE] == pytest.approx(50 * 0.0934 / 0.608 * 48.0)
    assert torque[TOE] == pytest.approx(20 * 0.0934 / 0.608 * 48.0)


def test_rotor_inertia_and_loss_reach_the_joint_squared_by_the_gear():
    motor = motors(viscous_loss=1e-4)
    assert motor.inertia[KNEE] == pytest.approx(0.134)
    impedance = 0.608 + 0.423e-3 / STEP
    assert motor.damping[KNEE] == pytest.approx(2500 * (0.0934**2 / impedance + 1e-4))


def test_the_papers_motors_are_near_velocity_sources():
    motor = motors(named_set="paper")
    assert motor.voltage_limit == PAPER_MOTORS.voltage_limit == 200.0
    assert motor.inertia == pytest.approx(np.full(45, 73.9))
    speeds = spin(motor, 72.2, 1.0, 0.5)
    assert speeds[-1] == pytest.approx(np.full(45, 1.0), rel=1e-3)


@pytest.mark.parametrize("step", [0.0005, 0.004])
@pytest.mark.parametrize("inertia", [0.0, 5.36e-5, 2e-4])
def test_stable_on_a_light_link_with_any_rotor(step, inertia):
    speeds = spin(motors(step, rotor_inertia=inertia, inductance=0.0), 48.0, 2e-4, 0.2, step)[:, KNEE]
    assert np.all(np.diff(speeds) > -1e-9)  # no ringing
    # With inductance a light rotor overshoots, as it would on the bench, and settles.
    speeds = spin(motors(step, rotor_inertia=inertia), 48.0, 2e-4, 0.2, step)[:, KNEE]
    assert speeds.max() < 1.1 * speeds[-1]
    assert speeds[-20:] == pytest.approx(np.full(20, speeds[-1]), rel=1e-3)


def test_a_joint_of_the_robot_reaches_no_load_speed():
    simulator = plant_from({"stops.stiffness": 0.0, "stops.damping": 0.0, "motors.viscous_loss": 0.0})
    lift(simulator)
    joint, voltage = robot().joint_index("l_wrist_yaw"), np.zeros(45)
    voltage[joint] = 4.67
    for _ in range(300):
        simulator.plant.step(voltage)
    assert simulator.plant.v[6 + joint] == pytest.approx(1.0, rel=1e-3)
    assert simulator.plant.effort[joint] == pytest.approx(0.0, abs=0.02)
    simulator.close()
