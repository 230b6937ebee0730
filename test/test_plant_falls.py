"""When the robot counts as fallen, and physics that leaves the numbers."""

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import commands, plant_from

from follower_humanoid.core.samples import Wrench
from follower_humanoid.errors import PhysicsError
from follower_humanoid.plant.falls import FallWatch


@pytest.fixture
def simulator():
    simulator = plant_from({})
    yield simulator
    simulator.close()


def moved(simulator, height=None, turn=None):
    q = simulator.plant.q.copy()
    if height is not None:
        q[2] = height
    if turn is not None:
        q[3:7] = pin.Quaternion(pin.exp3(np.array(turn))).coeffs()
    simulator.plant.bullet.place(q, np.zeros(51))
    simulator.advance(simulator.Inputs())
    return simulator.fall


def test_standing_is_no_fall(simulator):
    assert moved(simulator) is None


def test_too_low(simulator):
    fall = moved(simulator, height=0.45)
    assert "base_link at 0.4" in fall.reason
    assert fall.time == pytest.approx(0.002)
    assert fall.place == pytest.approx(simulator.plant.q[:3])


def test_60_percent_of_the_standing_height_is_the_limit(simulator):
    height = simulator.plant.q[2]
    assert FallWatch(height / 0.61).look(simulator.plant) is None
    assert "below" in FallWatch(height / 0.59).look(simulator.plant).reason


@pytest.mark.parametrize("turn", [(0.9, 0.0, 0.0), (0.0, 0.9, 0.0), (0.0, -0.9, 0.0)])
def test_tilted_too_far(simulator, turn):
    assert "tilted by 52°" in moved(simulator, height=2.0, turn=turn).reason


def test_turned_about_the_vertical_is_no_fall(simulator):
    assert moved(simulator, height=2.0, turn=(0.0, 0.0, 3.0)) is None


def test_a_push_topples_it_and_the_first_fall_is_kept(simulator):
    voltage = simulator.plant.motors.voltage.copy()
    push = Wrench(np.array([300.0, 0.0, 0.0]), np.zeros(3))
    for _ in range(1500):
        simulator.advance(commands(voltage, push=push if simulator.time < 0.3 else None))
        if simulator.fall is not None:
            break
    first = simulator.fall
    assert first is not None
    # Lying on the ground the plant goes on, in finite numbers, and keeps the fall it saw first.
    for _ in range(800):
        simulator.advance(simulator.Inputs())
    assert simulator.fall is first
    assert simulator.plant.world.link_on_ground(simulator.plant.bullet.body) is not None
    lowest = simulator.plant.q[2]
    assert -0.05 < lowest < 0.6


def test_a_hand_on_the_ground_is_a_fall(simulator):
    plant = simulator.plant
    q = pin.neutral(plant.model)  # arms hang straight
    for prefix in "lr":
        q[7 + plant.robot.joint_index(f"{prefix}_hip_pitch")] = -2.0
    q[2] = 0.195  # hands 5 mm in the ground, pelvis above
    plant.bullet.place(q, np.zeros(51))
    watch = FallWatch(0.1)
    assert watch.look(plant) is None
    plant.step(np.zeros(45))
    fall = watch.look(plant)
    assert fall.reason in ("l_wrist on the ground", "r_wrist on the ground")


def test_numbers_that_are_none_name_time_and_place(simulator):
    for _ in range(3):
        simulator.advance(simulator.Inputs())
    simulator.plant.motors.current[5] = np.nan
    with pytest.raises(PhysicsError, match=r"at 0\.007 s, first in: "):
        simulator.advance(simulator.Inputs())
