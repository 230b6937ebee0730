"""Hard stops: hold the range against full voltage and impact, push only, end where they should."""

import numpy as np
import pytest
from plant_bench import lift, plant_from, robot


@pytest.fixture
def simulator():
    simulator = plant_from({})
    lift(simulator)
    yield simulator
    simulator.close()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_full_voltage_everywhere_stays_in_the_range(simulator, sign):
    plant, worst = simulator.plant, 0.0
    for _ in range(1500):
        plant.step(np.full(45, 48.0 * sign))
        beyond = np.maximum(plant.q[7:] - robot().upper, robot().lower - plant.q[7:]).max()
        worst = max(worst, beyond)
    assert worst < 0.025
    end = robot().upper if sign > 0 else robot().lower
    toe = robot().joint_index("l_toe_pitch")
    assert plant.q[7 + toe] == pytest.approx(end[toe], abs=5e-3)


def test_rests_on_the_stop_as_deep_as_the_motor_pushes(simulator):
    plant, joint = simulator.plant, robot().joint_index("l_wrist_yaw")
    voltage = np.zeros(45)
    voltage[joint] = 20.0
    for _ in range(1500):
        plant.step(voltage)
    stall = 50 * 0.0934 / 0.608 * 20.0
    assert plant.q[7 + joint] - robot().upper[joint] == pytest.approx(stall / 1.0e5, rel=0.02)
    assert plant.stops.torque[joint] == pytest.approx(-stall, rel=0.02)


def test_lets_go_without_pulling(simulator):
    plant, joint = simulator.plant, robot().joint_index("l_wrist_yaw")
    voltage = np.zeros(45)
    for sign in (1.0, -1.0):
        voltage[joint] = 30.0 * sign
        for _ in range(800):
            plant.step(voltage)
            if plant.stops.active:
                torque = plant.stops.torque[joint]
                assert torque <= 0.0 if plant.q[7 + joint] > 0 else torque >= 0.0
        end = robot().upper if sign > 0 else robot().lower
        assert plant.q[7 + joint] == pytest.approx(end[joint], abs=0.01)


def test_no_torque_inside_the_range():
    simulator = plant_from({})
    for _ in range(20):
        simulator.advance(simulator.Inputs())
    assert not simulator.plant.stops.active
    simulator.close()
