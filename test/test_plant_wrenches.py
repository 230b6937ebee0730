"""What people do to the robot: axes, places, and letting go."""

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import commands, in_world, lift, plant_from, robot

from follower_humanoid.core.samples import Wrench
from follower_humanoid.errors import UnknownNameError
from follower_humanoid.plant.grip import Grip

PLACES = [("leader_left", "left_applied", "l_gripper"), ("leader_right", "right_applied", "r_gripper"),
          ("push", "base_applied", "base_link")]  # fmt: skip


def tilted(simulator):
    """High up and turned about all axes, so that frames differ."""
    lift(simulator)
    q = simulator.plant.q.copy()
    q[3:7] = pin.Quaternion(pin.exp3(np.array([0.4, -0.7, 1.1]))).coeffs()
    simulator.plant.bullet.place(q, np.zeros(51))


def momentum(simulator):
    """Linear momentum, and angular momentum about the world origin, without gravity's share."""
    model = simulator.plant.model
    data = model.createData()
    pin.computeCentroidalMomentum(model, data, simulator.plant.q, simulator.plant.v)
    return data.hg.linear.copy(), data.hg.angular + np.cross(data.com[0], data.hg.linear)


@pytest.mark.parametrize(("name", "applied", "place"), PLACES)
@pytest.mark.parametrize("frame", ["", "world", "base_link", "l_wrist", "torso", "r_sole"])
def test_force_and_torque_act_at_the_place_in_the_named_axes(name, applied, place, frame):
    wrench = Wrench(np.array([20.0, -10.0, 15.0]), np.array([3.0, 2.0, -4.0]), frame)
    changes = []
    for pulled in (True, False):  # the difference leaves gravity out
        simulator = plant_from({"stops.stiffness": 0.0}, period=0.001)
        tilted(simulator)
        place_in_world = place_of(simulator, place)
        turn = np.eye(3) if frame in ("", "world") else rotation_of(simulator, frame)
        inputs = commands(np.zeros(45), **({name: wrench} if pulled else {}))
        simulator.advance(inputs)
        changes.append(momentum(simulator))
        if pulled:
            acted = getattr(simulator.observe(), applied)
            assert acted.force == pytest.approx(turn @ wrench.force, abs=1e-9)
            assert acted.torque == pytest.approx(turn @ wrench.torque, abs=1e-9)
            assert acted.frame in ("", "world")
        simulator.close()
    linear, angular = (pulled - free for pulled, free in zip(*changes, strict=True))
    force, torque = turn @ wrench.force, turn @ wrench.torque
    assert linear / 0.001 == pytest.approx(force, abs=0.05)
    # About the place, so that the long way to the origin does not hide the torque.
    about_place = (angular - np.cross(place_in_world, linear)) / 0.001
    assert about_place == pytest.approx(torque, abs=0.05)


def place_of(simulator, frame):
    data = simulator.plant.model.createData()
    pin.framesForwardKinematics(simulator.plant.model, data, simulator.plant.q)
    return data.oMf[robot().frame_id(frame)].translation.copy()


def rotation_of(simulator, frame):
    return np.array([in_world(simulator, frame, axis) for axis in np.eye(3)]).T


def test_nothing_applied_reads_zero():
    simulator = plant_from({})
    simulator.advance(simulator.Inputs(leader_left=Wrench(np.array([5.0, 0.0, 0.0]), np.zeros(3))))
    assert simulator.observe().left_applied.force == pytest.approx([5.0, 0.0, 0.0])
    simulator.advance(simulator.Inputs())
    for _, applied, _ in PLACES:
        assert not getattr(simulator.observe(), applied).force.any()
    simulator.close()


def test_unknown_axes_are_named():
    simulator = plant_from({})
    assert simulator.knows_frame("l_gripper")
    assert simulator.knows_frame("")
    assert simulator.knows_frame("world")
    assert not simulator.knows_frame("moon")
    with pytest.raises(UnknownNameError, match="moon"):
        simulator.advance(simulator.Inputs(push=Wrench(np.ones(3), np.zeros(3), "moon")))
    simulator.close()


PULL = Wrench(np.array([10.0, 0.0, -2.0]), np.array([0.0, 1.0, 0.0]), "base_link")


def test_grip_starts_empty():
    assert not Grip().at(0.0).force.any()
    assert not Grip().at(100.0).force.any()


def test_grip_takes_the_newest_at_once():
    grip = Grip()
    assert grip.receive(PULL, 1.0)
    assert grip.at(1.0) is PULL
    newer = Wrench(np.array([0.0, 3.0, 0.0]), np.zeros(3))
    assert grip.receive(newer, 1.001)
    assert grip.at(1.001) is newer
    assert grip.received == 2


@pytest.mark.parametrize(
    ("silence", "share"),
    [(0.0, 1.0), (0.5, 1.0), (0.55, 0.75), (0.6, 0.5), (0.69, 0.05), (0.7, 0.0), (9.0, 0.0)],
)
def test_grip_lets_go_after_silence(silence, share):
    grip = Grip()
    grip.receive(PULL, 2.0)
    wrench = grip.at(2.0 + silence)
    assert wrench.force == pytest.approx(share * PULL.force, abs=1e-9)
    assert wrench.torque == pytest.approx(share * PULL.torque, abs=1e-9)


def test_grip_takes_hold_again():
    grip = Grip()
    grip.receive(PULL, 0.0)
    assert not grip.at(1.0).force.any()
    grip.receive(PULL, 1.5)
    assert grip.at(1.5) is PULL


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_grip_refuses_what_is_no_number(value):
    grip = Grip()
    grip.receive(PULL, 0.0)
    assert not grip.receive(Wrench(np.array([value, 0.0, 0.0]), np.zeros(3)), 0.1)
    assert grip.rejected == 1
    assert grip.at(0.1) is PULL
