"""ZMP balance as a whole: what it measures, what it asks of the feet, how it corrects the reference."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import frame_at, frame_pose, inputs_of, odometry_of, robot, standing_configuration, vertical

from follower_humanoid.balance.balance import BalanceOutputs, ZmpBalance
from follower_humanoid.balance.com_offset import ComOffset, OffsetConfig
from follower_humanoid.balance.hand_forces import hand_effect
from follower_humanoid.balance.shifted_reference import SOLES
from follower_humanoid.balance.zmp import measured_zmp, moved_to_origin
from follower_humanoid.core.samples import SIDES, Array, ContactPlan, Joints, Point, Wrench
from follower_humanoid.robot.body_state import BodyState
from follower_humanoid.robot.model import GRAVITY

DT = 0.002
SLOW = 0.01  # [s], where only the end counts
NO_HANDS = Wrench(np.zeros(3), np.zeros(3))
WEIGHT = robot().mass * GRAVITY


def com_of(q: Array) -> Array:
    return np.array(pin.centerOfMass(robot().pin_model, robot().pin_model.createData(), q))


def known(q: Array | None = None, **changes: Any) -> dict[str, Any]:
    """Standing still on both feet as the reference has it, CoM over the planned ZMP."""
    standing = standing_configuration()
    q = standing if q is None else q
    com = com_of(standing)
    ground = Point(np.array([com[0], com[1], 0.0]))
    values = {
        "joints": Joints(q[7:].copy(), np.zeros(45), np.zeros(45)),
        "odometry": odometry_of(q),
        "left_foot": vertical(WEIGHT / 2),
        "right_foot": vertical(WEIGHT / 2),
        "left_hand": NO_HANDS,
        "right_hand": NO_HANDS,
        "reference": Joints(standing[7:].copy(), np.zeros(45), np.zeros(45)),
        "base": odometry_of(standing),
        "zmp_reference": ground,
        "dcm_reference": ground,
        "contacts": ContactPlan(1.0, 1.0),
    }
    return {**values, **changes}


def step(balance: ZmpBalance | None = None, **values: Any) -> BalanceOutputs:
    balance = balance or ZmpBalance(ZmpBalance.Config(), robot(), DT)
    out: BalanceOutputs = balance.step(inputs_of(ZmpBalance, **values), 0.0)
    return out


def total(out: BalanceOutputs, q: Array) -> tuple[Array, Array]:
    """Force and moment about the world origin of both desired foot wrenches."""
    force, moment = np.zeros(3), np.zeros(3)
    for side, wrench in zip(SIDES, (out.left_foot_reference, out.right_foot_reference), strict=True):
        assert wrench is not None
        sole = frame_pose(q, f"{side.prefix}_sole")
        f, m = moved_to_origin(wrench.force, wrench.torque, frame_at(sole.translation, sole.rotation))
        force, moment = force + f, moment + m
    return force, moment


def test_standing_as_planned_the_feet_carry_the_weight_at_the_planned_zmp() -> None:
    out = step(**known())
    q = standing_configuration()
    force, moment = total(out, q)
    np.testing.assert_allclose(force, [0.0, 0.0, WEIGHT], atol=1e-6)
    com = com_of(q)
    np.testing.assert_allclose([-moment[1] / force[2], moment[0] / force[2]], com[:2], atol=1e-9)
    np.testing.assert_allclose(out.com.xyz, com, atol=1e-12)
    assert out.zmp_command is not None
    assert out.dcm is not None
    np.testing.assert_allclose(out.zmp_command.xyz, [*com[:2], 0.0], atol=1e-9)
    np.testing.assert_allclose(out.dcm.xyz, [*com[:2], 0.0], atol=1e-9)
    assert out.reference is not None
    np.testing.assert_allclose(out.reference.position, q[7:], atol=1e-9)
    np.testing.assert_allclose(out.reference.velocity, np.zeros(45), atol=1e-9)


def test_zmp_and_polygon_are_what_the_feet_measure() -> None:
    out = step(**known(left_foot=vertical(500.0), right_foot=vertical(200.0)))
    q = standing_configuration()
    places = [
        frame_at(pose.translation, pose.rotation) for pose in (frame_pose(q, f"{p}_sole") for p in "lr")
    ]
    expected = measured_zmp(vertical(500.0), vertical(200.0), *places, 50.0)
    assert expected is not None
    assert out.zmp is not None
    assert out.support_polygon is not None
    np.testing.assert_allclose(out.zmp.xyz, [*expected, 0.0], atol=1e-12)
    corners = {tuple(np.round(vertex, 9)) for vertex in out.support_polygon.vertices}
    points = {
        tuple(np.round([*frame_pose(q, f"{p}_contact_{k}").translation[:2], 0.0], 9))
        for p in "lr"
        for k in range(1, 7)
    }
    assert corners <= points
    assert len(corners) >= 4


def test_a_foot_without_load_is_no_part_of_the_polygon() -> None:
    out = step(**known(right_foot=vertical(10.0)))
    assert out.support_polygon is not None
    assert out.support_polygon.vertices[:, 1].min() > 0.0
    nothing = step(**known(left_foot=vertical(15.0), right_foot=vertical(15.0)))
    assert nothing.support_polygon is None
    assert nothing.zmp is None


def test_points_in_the_air_are_no_part_of_the_polygon() -> None:
    q = standing_configuration().copy()
    q[7 + robot().joint_index("l_ankle_pitch")] -= 0.1  # toes up
    flat, raised = step(**known()), step(**known(q=q))
    assert flat.support_polygon is not None
    assert raised.support_polygon is not None
    assert len(raised.support_polygon.vertices) >= 3
    left = flat.support_polygon.vertices[flat.support_polygon.vertices[:, 1] > 0]
    after = raised.support_polygon.vertices[raised.support_polygon.vertices[:, 1] > 0]
    assert after[:, 0].max() < left[:, 0].max() - 0.05


@pytest.mark.parametrize("missing", ["reference", "base", "zmp_reference", "dcm_reference", "contacts"])
def test_without_a_complete_reference_it_measures_and_asks_for_nothing(missing: str) -> None:
    out = step(**known(**{missing: None}))
    assert out.zmp is not None
    assert out.support_polygon is not None
    for name in ("reference", "left_foot_reference", "right_foot_reference", "zmp_command"):
        assert getattr(out, name) is None


def test_hands_not_sensed_yet_are_no_obstacle() -> None:
    out = step(**known(left_hand=None, right_hand=None))
    force, _ = total(out, standing_configuration())
    np.testing.assert_allclose(force, [0.0, 0.0, WEIGHT], atol=1e-6)


@pytest.mark.parametrize("error", [(0.01, 0.0), (0.0, 0.015), (-0.01, -0.01)])
def test_a_com_off_its_plan_asks_for_a_zmp_beyond_it(error: tuple[float, float]) -> None:
    q = standing_configuration().copy()
    q[:2] += error
    out = step(**known(q=q))
    assert out.zmp_command is not None
    away = out.zmp_command.xyz[:2] - com_of(standing_configuration())[:2]
    omega = np.sqrt(GRAVITY / com_of(q)[2])
    np.testing.assert_allclose(away, (1.0 + 3.0 / omega) * np.array(error), atol=1e-6)
    force, _ = total(out, q)
    # The ground pushes the body back.
    np.testing.assert_allclose(force[:2], -robot().mass * omega * 3.0 * np.array(error), rtol=1e-6, atol=1e-6)


def test_a_com_far_off_asks_for_no_more_than_the_soles_can_do() -> None:
    q = standing_configuration().copy()
    q[0] += 0.4
    out = step(**known(q=q))
    assert out.zmp_command is not None
    soles = frame_pose(q, "l_sole").translation[0]
    assert out.zmp_command.xyz[0] <= soles + 0.14 + 1e-9


@pytest.mark.parametrize("roll", [0.1, -0.1])
def test_at_the_edge_of_the_soles_the_dcm_goes_before_the_attitude(roll: float) -> None:
    # The reference leans, so that the attitude asks for a ZMP 3 cm to one side.
    leaning = standing_configuration().copy()
    leaning[3:7] = [np.sin(roll / 2), 0.0, 0.0, np.cos(roll / 2)]
    com = com_of(standing_configuration())

    def zmp(dcm_error: float, base: Array) -> float:
        dcm = Point(np.array([com[0], com[1] - dcm_error, 0.0]))
        out = step(**known(dcm_reference=dcm, base=odometry_of(base)))
        assert out.zmp_command is not None
        return float(out.zmp_command.xyz[1])

    upright = standing_configuration()
    assert abs(zmp(0.0, leaning) - zmp(0.0, upright)) > 0.02
    for away in (0.3, -0.3):
        assert zmp(away, leaning) == pytest.approx(zmp(away, upright), abs=1e-3)


def test_a_swing_foot_is_asked_for_nothing() -> None:
    out = step(**known(contacts=ContactPlan(0.0, 1.0)))
    assert out.left_foot_reference is not None
    np.testing.assert_allclose(out.left_foot_reference.force, np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(out.left_foot_reference.torque, np.zeros(3), atol=1e-12)


def test_a_pull_is_met_by_ground_force_and_com() -> None:
    pull = Wrench(np.array([15.0, 0.0, -20.0]), np.zeros(3))
    balance = ZmpBalance(ZmpBalance.Config(), robot(), SLOW)
    out = step(balance, **known(left_hand=pull, right_hand=pull))
    force, _ = total(out, standing_configuration())
    assert force[2] == pytest.approx(WEIGHT + 40.0)
    for _ in range(200):
        out = step(balance, **known(left_hand=pull, right_hand=pull))
    q = np.concatenate((standing_configuration()[:7], out.reference.position))
    assert com_of(q)[0] - frame_pose(q, "l_sole").translation[0] < com_of(standing_configuration())[0] - 0.02


def test_without_feedback_the_feet_push_as_planned_wherever_the_robot_is() -> None:
    off = ZmpBalance.Config(feedback=False)
    q = standing_configuration().copy()
    q[:2] += 0.01
    there = step(ZmpBalance(off, robot(), DT), **known(q=q))
    force, _ = total(there, q)
    np.testing.assert_allclose(force, [0.0, 0.0, WEIGHT], atol=1e-6)
    np.testing.assert_allclose(there.zmp_command.xyz, known()["zmp_reference"].xyz, atol=1e-9)
    # It is measured nevertheless.
    np.testing.assert_allclose(there.dcm.xyz[:2] - com_of(standing_configuration())[:2], 0.01, atol=1e-9)


def test_hand_forces_can_be_left_out() -> None:
    pull = Wrench(np.array([15.0, 0.0, -20.0]), np.zeros(3))
    out = step(ZmpBalance(ZmpBalance.Config(hand_forces=False), robot(), DT), **known(left_hand=pull))
    force, _ = total(out, standing_configuration())
    np.testing.assert_allclose(force, [0.0, 0.0, WEIGHT], atol=1e-6)


def offset_for(wrench: Wrench, seconds: float = 3.0, **values: Any) -> tuple[Array, Array, Array]:
    """CoM relative to the left sole before and after; how far the right sole has moved against the left."""
    q = standing_configuration()
    wanted = BodyState(robot(), SOLES)
    wanted.update(q, np.zeros(51))
    offset = ComOffset(OffsetConfig(**values), robot(), wanted)
    hand = frame_pose(q, "l_gripper").translation
    hands = hand_effect([(wrench, hand)], robot().mass)
    before = com_of(q) - frame_pose(q, "l_sole").translation
    for _ in range(round(seconds / SLOW)):
        after = offset.step(q, np.zeros(51), hands, SLOW)
    moved = np.concatenate((q[:7], after.position))
    left, right = frame_pose(moved, "l_sole"), frame_pose(moved, "r_sole")
    com = left.rotation.T @ (com_of(moved) - left.translation)
    return (
        before,
        com,
        left.actInv(right).homogeneous
        - np.block([[np.eye(3), np.array([[0.0], [-0.18], [0.0]])], [np.zeros((1, 3)), np.ones((1, 1))]]),
    )


def test_the_com_goes_where_it_rests_against_the_hands_and_the_feet_stay() -> None:
    pull = Wrench(np.array([15.0, 4.0, -10.0]), np.zeros(3))
    q = standing_configuration()
    effect = hand_effect([(pull, frame_pose(q, "l_gripper").translation)], robot().mass)
    wanted = effect.resting_com(com_of(q)[:2]) - com_of(q)[:2]
    before, after, feet = offset_for(pull)
    np.testing.assert_allclose((after - before)[:2], wanted, atol=5e-4)
    assert np.linalg.norm(wanted) > 0.01
    np.testing.assert_allclose(feet, np.zeros((4, 4)), atol=2e-4)


def test_the_offset_is_limited_and_can_be_switched_off() -> None:
    hard = Wrench(np.array([150.0, 0.0, 0.0]), np.zeros(3))
    before, after, feet = offset_for(hard, limit=0.03)
    assert (before - after)[0] == pytest.approx(0.03, abs=5e-4)
    np.testing.assert_allclose(feet, np.zeros((4, 4)), atol=2e-4)
    switched_off = ZmpBalance(ZmpBalance.Config(offset=OffsetConfig(enabled=False)), robot(), DT)
    for _ in range(10):
        out = step(switched_off, **known(left_hand=hard))
    np.testing.assert_array_equal(out.reference.position, standing_configuration()[7:])


def test_the_offset_follows_gradually() -> None:
    pull = Wrench(np.array([15.0, 0.0, 0.0]), np.zeros(3))
    before, early, _ = offset_for(pull, 0.1)
    _, late, _ = offset_for(pull)
    share = (early - before)[0] / (late - before)[0]
    assert share == pytest.approx(1.0 - np.exp(-2.0 * 0.1), abs=0.05)


def test_diagnostics_tell_the_margin_now_and_at_its_smallest() -> None:
    balance = ZmpBalance(ZmpBalance.Config(), robot(), DT)
    assert balance.diagnostics() == {"zmp_margin [m]": "no ZMP"}
    step(balance, **known())
    middle = balance.diagnostics()["zmp_margin [m]"]
    step(balance, **known(right_foot=replace(vertical(WEIGHT / 2), torque=np.array([0.0, 40.0, 0.0]))))
    shown = balance.diagnostics()
    assert shown["zmp_margin [m]"] < middle
    step(balance, **known())
    assert balance.diagnostics()["smallest_zmp_margin [m]"] == shown["zmp_margin [m]"]
    assert balance.diagnostics()["zmp_margin [m]"] == pytest.approx(middle)
