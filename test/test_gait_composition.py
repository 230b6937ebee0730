"""The whole reference motion on an ideal body: what the plan says is what the joints do."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import (
    AHEAD,
    STAND,
    IdealRobot,
    always,
    configuration_of,
    robot,
    until,
    velocity_of,
    yaw_of,
)

from follower_humanoid.core.samples import SIDES, Array, Footstep, Gait, Side
from follower_humanoid.gait.feet import FootPose, half_step_length
from follower_humanoid.gait.pelvis_height import PelvisConfig
from follower_humanoid.gait.pendulum import natural_frequency

# Name → (gait, seconds of it, seconds of standing after it)
WALKS = {
    "ahead": (AHEAD, 7.5, 7.0),
    "pulled hard": (Gait(1.25, 0.0, 1.25, 1.0, 0.0), 7.5, 7.0),
    "turning left": (Gait(1.0, 0.3, 1.0, 1.0, 0.3), 7.5, 7.0),
    "turning right": (Gait(1.0, -0.3, 1.0, 1.0, -0.3), 7.5, 7.0),
    "backward": (Gait(0.5, math.pi, 0.5, 1.0, 0.0), 7.5, 7.0),
    "sideways": (Gait(0.4, math.pi / 2, 0.4, 1.0, 0.0), 7.5, 7.0),
}
DT = 0.01


class Walked:
    """An ideal robot's walk with what forward kinematics says of it."""

    def __init__(self, name: str) -> None:
        gait, walking, standing = WALKS[name]
        self.gait = gait
        self.robot = IdealRobot(dt=DT)
        self.robot.run(walking + standing, until(walking, gait))
        self.outputs = self.robot.outputs
        self.q = np.array([configuration_of(out) for out in self.outputs])
        self.v = np.array([velocity_of(out) for out in self.outputs])
        self.com, self.sole, self.rotation = self._kinematics()

    def _kinematics(self) -> tuple[Array, dict[Side, Array], dict[Side, Array]]:
        model, data = robot().pin_model, robot().pin_model.createData()
        frames = {side: robot().frame_id(f"{side.prefix}_sole") for side in SIDES}
        com, sole, rotation = [], {side: [] for side in SIDES}, {side: [] for side in SIDES}
        for q in self.q:
            com.append(pin.centerOfMass(model, data, q).copy())
            for side, frame in frames.items():
                place = pin.updateFramePlacement(model, data, frame)
                sole[side].append(place.translation.copy())
                rotation[side].append(place.rotation.copy())
        stacked = ({side: np.array(rows[side]) for side in SIDES} for rows in (sole, rotation))
        return np.array(com), *stacked

    @property
    def steps(self) -> list[Footstep]:
        return self.robot.steps()

    def column(self, name: str) -> Array:
        return np.array([getattr(out, name).xyz[:2] for out in self.outputs])


@cache
def walked(name: str) -> Walked:
    return Walked(name)


every_walk = pytest.mark.parametrize("name", WALKS)


def test_com_of_the_joints_is_the_com_of_the_pendulum() -> None:
    # The pendulum's CoM follows its published DCM by ċ = ω(ξ − c), solved here for a linear ξ.
    ideal = IdealRobot(dt=0.002)
    ideal.run(4.0, always(WALKS["turning left"][0]))
    model, data = robot().pin_model, robot().pin_model.createData()
    com = pin.centerOfMass(model, data, configuration_of(ideal.outputs[0])).copy()
    plan, away = com[:2], []
    for last, out in pairwise(ideal.outputs):
        omega = natural_frequency(float(com[2]))
        before, dcm = last.dcm_reference.xyz[:2], out.dcm_reference.xyz[:2]
        lag = (dcm - before) / (ideal.dt * omega)
        plan = dcm - lag + (plan - before + lag) * math.exp(-omega * ideal.dt)
        com = pin.centerOfMass(model, data, configuration_of(out)).copy()
        away.append(float(np.linalg.norm(com[:2] - plan)))
    assert max(away) < 1e-3
    assert np.linalg.norm(com[:2]) > 0.1


@every_walk
def test_joint_positions_are_the_integral_of_joint_velocities(name: str) -> None:
    walk = walked(name)
    joints, rates = walk.q[:, 7:], walk.v[:, 6:]
    np.testing.assert_allclose(np.diff(joints, axis=0), DT * rates[1:], atol=1e-12)
    for before, after, v in zip(walk.q[:-1:50], walk.q[1::50], walk.v[1::50], strict=False):
        np.testing.assert_allclose(pin.integrate(robot().pin_model, before, v * DT), after, atol=1e-12)


@every_walk
def test_joints_stay_inside_their_ranges_and_legs_bent(name: str) -> None:
    joints = walked(name).q[:, 7:]
    assert np.all(joints > robot().lower)
    assert np.all(joints < robot().upper)
    knees = joints[:, [robot().joint_index(f"{prefix}_knee") for prefix in "lr"]]
    assert knees.min() > 0.1
    assert np.abs(walked(name).v[:, 6:]).max() < 8.0


@every_walk
def test_legs_are_never_asked_for_more_than_their_reach(name: str) -> None:
    model, data = robot().pin_model, robot().pin_model.createData()
    longest = 0.0
    for q in walked(name).q[::5]:
        pin.forwardKinematics(model, data, q)
        for prefix in "lr":
            hip = data.oMi[model.getJointId(f"{prefix}_hip_pitch")].translation
            ankle = data.oMi[model.getJointId(f"{prefix}_ankle_pitch")].translation
            longest = max(longest, float(np.linalg.norm(hip - ankle)))
    assert longest < PelvisConfig().leg_reach + 0.015


@every_walk
def test_the_stance_foot_stands_flat_and_still(name: str) -> None:
    walk = walked(name)
    for side in SIDES:
        share = np.array([getattr(out.contacts, side.value) for out in walk.outputs])
        carrying = share > 0.5
        assert np.abs(walk.sole[side][carrying, 2]).max() < 1.5e-3
        assert walk.rotation[side][carrying, 2, 2].min() > math.cos(0.01)
        both = carrying[1:] & carrying[:-1]
        speed = np.linalg.norm(np.diff(walk.sole[side], axis=0), axis=1)[both] / DT
        assert speed.max() < 0.03


@every_walk
def test_the_planned_zmp_lies_under_the_feet_that_carry(name: str) -> None:
    walk = walked(name)
    zmp = walk.column("zmp_reference")
    for row, out in enumerate(walk.outputs):
        on = [side for side in SIDES if getattr(out.contacts, side.value) > 0.5]
        if len(on) == 1:
            away = walk.rotation[on[0]][row].T @ np.append(zmp[row] - walk.sole[on[0]][row, :2], 0.0)
            assert -0.07 < away[0] < 0.19
            assert abs(away[1]) < 0.05


@every_walk
def test_steps_have_the_length_and_direction_asked_for(name: str) -> None:
    walk = walked(name)
    gait, steps = walk.gait, walk.steps
    travel = gait.walk_dir - gait.heading
    feet = {side: FootPose(side, 0.0, side.sign * 0.09, 0.0) for side in SIDES}
    lengths = []
    for step in steps:
        feet[step.side] = FootPose(step.side, float(step.position[0]), float(step.position[1]), step.yaw)
        lengths.append(half_step_length(feet[step.side], feet[step.side.other]))
        if step.counted:
            assert lengths[-1] == pytest.approx(0.40 * gait.step_length * math.cos(travel), abs=3e-3)
            assert step.yaw == pytest.approx(gait.heading, abs=0.06)
    assert [step.counted for step in steps] == [True] * (len(steps) - 1) + [False]
    assert lengths[-1] == pytest.approx(0.0, abs=3e-3)
    going = np.array([math.cos(gait.walk_dir), math.sin(gait.walk_dir)])
    start = {side: np.array([0.0, side.sign * 0.09]) for side in SIDES}
    for side in SIDES:
        assert (feet[side].xy - start[side]) @ going > 0.1


@every_walk
def test_feet_do_not_cross_and_keep_apart(name: str) -> None:
    walk = walked(name)
    left, right = walk.sole[Side.LEFT], walk.sole[Side.RIGHT]
    heading = np.array([yaw_of(pin.Quaternion(q[3:7]).matrix()) for q in walk.q])
    across = -np.sin(heading) * (left - right)[:, 0] + np.cos(heading) * (left - right)[:, 1]
    assert across.min() > 0.15


@every_walk
def test_it_ends_standing_at_rest_with_the_feet_together(name: str) -> None:
    walk = walked(name)
    last = walk.outputs[-1]
    assert last.contacts.left == last.contacts.right == 1.0
    assert last.primitives.names == ()
    # But for the pelvis, which rises by a centimetre a second.
    assert np.abs(last.reference.velocity).max() < 0.08
    feet = 0.5 * (walk.sole[Side.LEFT][-1] + walk.sole[Side.RIGHT][-1])
    c, s = math.cos(walk.gait.heading), math.sin(walk.gait.heading)
    rest = feet[:2] + 0.03 * np.array([c, s])
    np.testing.assert_allclose(walk.com[-1, :2], rest, atol=3e-3)
    np.testing.assert_allclose(last.zmp_reference.xyz[:2], rest, atol=3e-3)
    assert np.linalg.norm(walk.sole[Side.LEFT][-1] - walk.sole[Side.RIGHT][-1]) == pytest.approx(
        0.18, abs=3e-3
    )


@every_walk
def test_the_pelvis_turns_with_the_feet_and_stays_upright(name: str) -> None:
    walk = walked(name)
    for row in range(0, len(walk.q), 10):
        pelvis = pin.Quaternion(walk.q[row, 3:7]).matrix()
        assert pelvis[2, 2] > math.cos(0.01)
        between = 0.5 * sum(yaw_of(walk.rotation[side][row]) for side in SIDES)
        assert yaw_of(pelvis) == pytest.approx(between, abs=0.02)


def test_the_height_of_the_swing_is_reached_by_the_joints() -> None:
    walk = walked("ahead")
    for side in SIDES:
        assert walk.sole[side][:, 2].max() == pytest.approx(0.05, abs=2e-3)


def test_left_and_right_turns_are_mirror_images() -> None:
    left, right = walked("turning left"), walked("turning right")
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(right.com, left.com * flip, atol=1e-6)
    for side in SIDES:
        np.testing.assert_allclose(right.sole[side.other], left.sole[side] * flip, atol=1e-6)
    signs, twin = np.ones(45), np.arange(45)
    for index, name in enumerate(robot().joint_names):
        if name[:2] in ("l_", "r_"):
            twin[index] = robot().joint_index(f"{'r' if name[0] == 'l' else 'l'}_{name[2:]}")
        if name.endswith(("_yaw", "_roll", "_x", "_z")):
            signs[index] = -1.0
    legs = np.concatenate((robot().groups.left_leg, robot().groups.right_leg))
    mirrored = (left.q[:, 7:] * signs)[:, twin]
    np.testing.assert_allclose(right.q[:, 7:][:, legs], mirrored[:, legs], atol=1e-5)


def test_footsteps_are_published_when_they_change_and_not_more() -> None:
    walk = walked("ahead")
    published = [out.footsteps for out in walk.outputs if out.footsteps is not None]
    assert 4 <= len(published) <= 20
    planned = next(f for f in published if any(not step.taken for step in f.steps))
    assert all(step.counted for step in planned.steps if not step.taken)
    assert [step.side for step in planned.steps[:2]] == [Side.RIGHT, Side.LEFT]
    final = published[-1].steps
    assert all(step.taken for step in final)
    for steps in (f.steps for f in published):
        flags = [step.taken for step in steps]
        assert flags == sorted(flags, reverse=True)  # taken first, in the order of walking
        for step in steps:
            assert step.position.shape == (3,)


def test_a_planned_closing_step_is_published_as_one() -> None:
    published = [out.footsteps.steps for out in walked("ahead").outputs if out.footsteps is not None]
    counted = []
    for before, after in pairwise(published):
        next_one = sum(step.taken for step in before)
        if after[next_one:] and after[next_one].taken:
            assert before[next_one].counted == after[next_one].counted
            counted.append(after[next_one].counted)
    assert counted == [True, True, False]


@pytest.mark.parametrize("heading", [0.0, -math.pi / 4])
def test_what_was_published_last_is_where_the_foot_goes(heading: float) -> None:
    ideal = IdealRobot()
    slow = Gait(1.0, heading, 0.8, 1.0, heading)
    ideal.run(24.0, always(slow))
    walker = ideal.composition._motion.walker
    while not 0.1 < (walker.half_step.swing_progress if walker.half_step else 0.0) < 0.3:
        ideal.tick(slow)
    ideal.run(0.5, always(replace(slow, step_length=1.0)))
    last = next(out.footsteps for out in reversed(ideal.outputs) if out.footsteps is not None)
    planned = next(step for step in last.steps if not step.taken)
    np.testing.assert_allclose(planned.position[:2], walker.landing.xy, atol=1e-3)


def test_the_first_outputs_hold_the_measured_posture() -> None:
    ideal = IdealRobot()
    start = ideal.joints.position.copy()
    for gait in (None, STAND):
        out = ideal.tick(gait)
        np.testing.assert_allclose(out.reference.position, start, atol=2e-3)
    ideal.run(2.0, always(STAND))
    assert np.abs(ideal.outputs[-1].reference.velocity).max() < 0.01
    assert ideal.steps() == []


@pytest.mark.parametrize("change", ["walk_speed", "step_length", "step_height", "walk_dir"])
def test_parameters_changed_in_mid_swing_keep_joint_velocities_continuous(change: str) -> None:
    ideal = copy.deepcopy(_in_mid_swing())
    values = {
        "walk_speed": {"walk_speed": 1.25},
        "step_length": {"step_length": 1.25},
        "step_height": {"step_height": 1.6},
        "walk_dir": {"walk_dir": 0.2, "heading": 0.2},
    }[change]
    before = len(ideal.outputs)
    ideal.run(0.5, always(replace(AHEAD, **values)))
    rates = np.array([out.reference.velocity for out in ideal.outputs[before - 2 :]])
    smooth = np.array([out.reference.velocity for out in ideal.outputs[before - 30 : before]])
    usual = np.abs(np.diff(smooth, axis=0)).max()
    assert np.abs(np.diff(rates, axis=0)).max() < 3.0 * usual + 0.06


@cache
def _in_mid_swing() -> IdealRobot:
    ideal = IdealRobot(dt=DT)
    ideal.run(1.6, always(AHEAD))
    return ideal
