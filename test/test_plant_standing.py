"""Time 0 is static equilibrium; what happens with and without commands."""

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import Holding, center_of_mass, commands, plant_from, plant_mass, robot

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.robot.model import GRAVITY


def drift(simulator, start):
    return np.abs(pin.difference(simulator.plant.model, start, simulator.plant.q)).max()


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"standing.hip_height": 0.78, "standing.com_ahead": 0.0},
        {"standing.com_ahead": 0.06, "standing.elbow": -1.2},
        {"body.mass_scale": 1.1},
        {"body.left_hand_load": 5.0, "body.right_hand_load": 1.0},
        {"motors.named_set": "paper"},
    ],
)
def test_held_voltages_and_a_stiff_loop_do_not_move_it(values):
    simulator = plant_from(values)
    start, holding = simulator.plant.q.copy(), Holding(simulator)
    for _ in range(500):
        simulator.advance(holding.inputs(simulator.observe()))
    assert drift(simulator, start) < 1e-6
    assert simulator.fall is None
    simulator.close()


def test_posture_is_as_configured():
    simulator = plant_from({"standing.hip_height": 0.82, "standing.com_ahead": 0.02})
    plant = simulator.plant
    center, speed = center_of_mass(simulator)
    data = plant.model.createData()
    pin.framesForwardKinematics(plant.model, data, plant.q)
    ankles = [data.oMf[robot().frame_id(f"{p}_sole")].translation for p in "lr"]
    assert plant.q[2] == pytest.approx(0.82, abs=1e-9)
    assert plant.rotation == pytest.approx(np.eye(3), abs=1e-12)
    assert center[0] - np.mean([a[0] for a in ankles]) == pytest.approx(0.02, abs=1e-6)
    assert center[1] == pytest.approx(0.0, abs=1e-9)
    assert [a[1] for a in ankles] == pytest.approx([0.09, -0.09], abs=1e-9)
    assert np.abs(speed).max() == 0.0
    lower, upper = robot().lower, robot().upper
    assert np.all((plant.q[7:] > lower - 1e-12) & (plant.q[7:] < upper + 1e-12))
    simulator.close()


def test_first_outputs_are_in_equilibrium():
    simulator = plant_from({})
    state = simulator.observe()
    weight = plant_mass(simulator) * GRAVITY
    assert state.left_foot.force[2] + state.right_foot.force[2] == pytest.approx(weight, rel=1e-4)
    assert state.left_foot.force == pytest.approx(state.right_foot.force, abs=1e-6)
    assert state.imu.linear_acceleration == pytest.approx([0.0, 0.0, GRAVITY], abs=1e-9)
    # Effort holds the robot: the residual of its static equations is zero.
    plant = simulator.plant
    static = pin.rnea(plant.model, plant.data, plant.q, np.zeros(51), np.zeros(51))
    arms = robot().groups.arms
    assert state.joints.effort[arms] == pytest.approx(static[6 + arms], abs=1e-9)
    simulator.close()


def test_voltage_that_holds_follows_from_the_observed_effort():
    simulator = plant_from({})
    gear = np.where(["toe" in name for name in robot().joint_names], 20.0, 50.0)
    voltage = simulator.observe().joints.effort * 0.608 / (gear * 0.0934)
    start = simulator.plant.q.copy()
    simulator.advance(commands(voltage))
    assert drift(simulator, start) < 1e-12
    simulator.close()


def held_ticks(simulator):
    """Ticks of both groups of drives without a usable command."""
    told = simulator.diagnostics()
    return told["legs_held_ticks"] + told["arms_held_ticks"]


def test_drives_hold_when_commands_stop():
    simulator = plant_from({})
    holding = Holding(simulator)
    for _ in range(50):
        simulator.advance(holding.inputs(simulator.observe()))
    assert held_ticks(simulator) == 0
    start = simulator.plant.q.copy()
    for _ in range(500):
        simulator.advance(simulator.Inputs())
    assert held_ticks(simulator) == 2 * 500
    assert drift(simulator, start) < 1e-3
    simulator.close()


def test_a_command_that_is_no_number_is_no_command():
    simulator = plant_from({})
    voltage = simulator.plant.motors.voltage.copy()
    voltage[3] = np.nan
    start = simulator.plant.q.copy()
    for _ in range(20):
        simulator.advance(commands(voltage))
    assert held_ticks(simulator) == 20  # the legs' only
    assert drift(simulator, start) < 1e-3
    simulator.close()


def test_without_references_the_drives_hold_what_they_find():
    simulator = plant_from({})
    holding, unknown = Holding(simulator), np.full(45, np.nan)
    for _ in range(50):
        voltage = holding.voltage(simulator.observe())
        simulator.advance(commands(voltage, unknown, unknown))
    start = simulator.plant.q.copy()
    for _ in range(200):
        simulator.advance(simulator.Inputs())
    assert held_ticks(simulator) == 2 * 200
    assert drift(simulator, start) < 1e-3
    simulator.close()


def test_reset_puts_it_back_and_time_goes_on():
    simulator = plant_from({})
    start = simulator.plant.q.copy()
    for _ in range(300):
        simulator.advance(commands(np.zeros(45)))
    assert drift(simulator, start) > 0.1
    simulator.reset()
    assert drift(simulator, start) < 1e-12
    assert simulator.tick == 301  # the reset took one
    assert simulator.time == pytest.approx(0.602)
    for _ in range(100):
        simulator.advance(simulator.Inputs())
    assert drift(simulator, start) < 1e-6
    simulator.close()


@pytest.mark.parametrize("period", [0.0015, 0.0004])
def test_tick_must_be_whole_physics_steps(period):
    with pytest.raises(ConfigurationError, match=r"physics_step = 0\.001"):
        plant_from({}, period=period)


@pytest.mark.parametrize(
    ("height", "ahead", "message"),
    [(0.95, 0.03, "legs cannot reach the ground"), (0.5, 0.09, "puts l_ankle_pitch at")],
)
def test_an_impossible_posture_is_refused(height, ahead, message):
    with pytest.raises(ConfigurationError, match=message):
        plant_from({"standing.hip_height": height, "standing.com_ahead": ahead})


def test_out_of_range_parameter_is_refused():
    with pytest.raises(ConfigurationError, match=r"soles\.stiffness"):
        plant_from({"soles.stiffness": -1.0})
