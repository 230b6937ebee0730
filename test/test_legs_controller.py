"""The leg controller: the closed loop accelerates the legs as the sliding mode asks, in volts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import inputs_of, odometry_of, robot, standing_configuration, vertical

from follower_humanoid.control.legs import FIRST_REFERENCE, LegConfig, LegController
from follower_humanoid.control.motor_inverse import MotorInverse, MotorModel
from follower_humanoid.control.sliding_mode import SlidingModeConfig
from follower_humanoid.core.samples import Array, Joints, Odometry, Wrench
from follower_humanoid.robot.model import ACTUATED, GRAVITY

DT = 0.002
GROUPS = robot().groups
LEGS, ARMS = GROUPS.legs, GROUPS.arms
TOES = np.array([robot().joint_index(f"{prefix}_toe_pitch") for prefix in "lr"])
HALF = 0.5 * robot().mass * GRAVITY
FEET = {"left_foot_reference": vertical(HALF), "right_foot_reference": vertical(HALF)}


def known(q: Array, v: Array, **changes: Any) -> dict[str, Any]:
    values = {
        "joints": Joints(q[7:].copy(), v[6:].copy(), np.zeros(ACTUATED)),
        "odometry": odometry_of(q, v[:6]),
        "left_foot": vertical(HALF),
        "right_foot": vertical(HALF),
    }
    return {**values, **changes}


def standing(**changes: Any) -> dict[str, Any]:
    return known(standing_configuration(), np.zeros(51), **changes)


def hold(q: Array | None = None) -> Joints:
    q = standing_configuration() if q is None else q
    return Joints(q[7:].copy(), np.zeros(ACTUATED), np.zeros(ACTUATED))


def controller(**values: Any) -> LegController:
    return LegController(LegConfig(**values), robot(), DT)


def step(legs: LegController, values: dict[str, Any]) -> Joints:
    command = legs.step(inputs_of(LegController, **values), 0.0).command
    assert command is not None
    return command


def row_of(joint: int) -> int:
    """Where a joint stands in the command."""
    return LEGS.tolist().index(joint)


def random_state(rng: np.random.Generator) -> tuple[Array, Array]:
    model = robot().pin_model
    q = pin.integrate(model, standing_configuration(), rng.normal(0, 0.1, model.nv))
    return np.array(q), rng.normal(0, 0.3, model.nv)


def accelerations(q: Array, v: Array, volts: Array, external: Array, toes: Array) -> Array:
    """Joint accelerations under the voltages of legs, trunk and neck; arms at rest, toes as given."""
    model, data = robot().pin_model, robot().pin_model.createData()
    upper = np.triu(pin.crba(model, data, q))
    mass = upper + np.triu(upper, 1).T
    bias = pin.nonLinearEffects(model, data, q, v)
    motors = MotorInverse(MotorModel(), robot())
    mass[np.arange(6, 51), np.arange(6, 51)] += motors.rotor_inertia
    torque = np.zeros(51)
    full = np.zeros(ACTUATED)
    full[LEGS] = volts
    torque[6:] = motors.motor_torque(full, v[6:])
    given = np.zeros(51)
    given[6 + TOES] = toes
    fixed = np.concatenate((6 + ARMS, 6 + TOES))
    free = np.setdiff1d(np.arange(51), fixed)
    right = (torque + external - bias - mass @ given)[free]
    given[free] = np.linalg.solve(mass[np.ix_(free, free)], right)
    return given[6:]


def generalised(q: Array, frame: str, wrench: Wrench, axes: pin.ReferenceFrame) -> Array:
    model, data = robot().pin_model, robot().pin_model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    jacobian = pin.getFrameJacobian(model, data, robot().frame_id(frame), axes)
    return np.asarray(jacobian.T @ np.concatenate((wrench.force, wrench.torque)))


@pytest.mark.parametrize("seed", range(3))
def test_the_legs_accelerate_as_the_sliding_mode_asks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, v = random_state(rng)
    wanted = Joints(q[7:] + rng.normal(0, 0.002, 45), v[6:] + rng.normal(0, 0.02, 45), np.zeros(45))
    feet = [Wrench(rng.normal(0, 20, 3) + np.array([0, 0, HALF]), rng.normal(0, 10, 3)) for _ in range(2)]
    hands = [Wrench(rng.normal(0, 10, 3), rng.normal(0, 2, 3)) for _ in range(2)]
    legs = controller(motor=MotorModel(voltage_limit=500.0))
    values = known(
        q, v, reference=wanted, left_foot_reference=feet[0], right_foot_reference=feet[1],
        left_hand=hands[0], right_hand=hands[1],
    )  # fmt: skip
    step(legs, values)
    command = step(legs, values)  # the reference velocity stays: no feed-forward acceleration
    external = sum(
        generalised(q, f"{p}_sole", w, pin.ReferenceFrame.LOCAL) for p, w in zip("lr", feet, strict=True)
    ) + sum(
        generalised(q, f"{p}_gripper", w, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        for p, w in zip("lr", hands, strict=True)
    )
    found = accelerations(q, v, command.effort, external, np.zeros(2))
    config = SlidingModeConfig()
    error, rate = wanted.position - q[7:], wanted.velocity - v[6:]
    s = rate + config.slope * error
    asked = config.slope * rate + config.reaching * s + config.switching * np.clip(s / config.boundary, -1, 1)
    asked += np.clip(2 * DT * config.estimator * s, -config.estimate_limit, config.estimate_limit)
    weight = np.ones(45)
    weight[GROUPS.neck] = 0.2
    weight[[robot().joint_index(f"{p}_ankle_{axis}") for p in "lr" for axis in ("pitch", "roll")]] = 0.1
    driven = np.setdiff1d(LEGS, TOES)
    np.testing.assert_allclose(found[driven], (weight * asked)[driven], atol=1e-6)


def test_a_reference_that_speeds_up_is_fed_forward() -> None:
    q = standing_configuration()
    legs, speed = controller(), np.zeros(45)
    knee = robot().joint_index("l_knee")
    step(legs, standing(reference=hold()))
    still = step(legs, standing(reference=hold()))
    speed[knee] = 0.004  # within one tick: 2 rad/s²
    moving = step(legs, standing(reference=Joints(q[7:], speed, np.zeros(45))))
    row = row_of(knee)
    assert (moving.effort - still.effort)[row] > 0.0
    np.testing.assert_array_equal(moving.velocity, speed[LEGS])
    np.testing.assert_array_equal(moving.position, q[7:][LEGS])


def test_a_joint_behind_its_reference_is_driven_forward() -> None:
    for name in ("l_knee", "r_hip_roll", "neck_yaw"):
        index = robot().joint_index(name)
        ahead = hold()
        ahead.position[index] += 0.01
        base, more = (step(controller(), standing(reference=r)) for r in (hold(), ahead))
        row = row_of(index)
        assert (more.effort - base.effort)[row] > 0.0


def test_toes_are_springs() -> None:
    row = [row_of(toe) for toe in TOES]
    bent = standing_configuration().copy()
    bent[7 + TOES] -= 0.1
    command = step(controller(), known(bent, np.zeros(51), reference=hold()))
    motors = MotorInverse(MotorModel(), robot())
    np.testing.assert_allclose(command.effort[row] * motors.torque_per_volt[TOES], 60.0 * 0.1)


def test_before_a_reference_it_holds_the_first_posture() -> None:
    legs = controller()
    first = step(legs, standing())
    np.testing.assert_array_equal(first.position, standing_configuration()[7:][LEGS])
    np.testing.assert_array_equal(first.velocity, np.zeros(len(LEGS)))
    moved = standing_configuration().copy()
    moved[7 + robot().joint_index("l_knee")] += 0.01
    second = step(legs, known(moved, np.zeros(51)))
    np.testing.assert_array_equal(second.position, first.position)
    # Both feet carry by measurement: nearly no voltage is spent but for gravity.
    assert np.abs(first.effort).max() < 20.0


def test_it_waits_for_the_first_reference_for_a_moment_only() -> None:
    legs = controller()
    commands = [legs.step(inputs_of(LegController, **standing()), 0.0).command for _ in range(100)]
    there = [command is not None for command in commands]
    assert sum(there) == pytest.approx(FIRST_REFERENCE / DT, abs=1)
    assert there == sorted(there, reverse=True)


def test_when_the_reference_falls_silent_the_drives_hold_and_it_goes_on_without_a_jerk() -> None:
    legs, fresh = controller(), controller()
    moving = hold()
    moving.velocity[LEGS] = 0.5
    step(legs, standing(reference=hold(), **FEET))
    assert legs.step(inputs_of(LegController, **standing()), 0.0).command is None
    again = step(legs, standing(reference=moving, **FEET))
    step(fresh, standing(reference=moving, **FEET))
    steady = step(fresh, standing(reference=moving, **FEET))
    np.testing.assert_allclose(again.effort, steady.effort, atol=1.0)


def test_hand_wrenches_that_have_not_come_are_left_out() -> None:
    none = Wrench(np.zeros(3), np.zeros(3))
    one, two = (step(controller(), standing(left_hand=w, right_hand=w)) for w in (None, none))
    np.testing.assert_array_equal(one.effort, two.effort)


def test_desired_foot_wrenches_take_the_place_of_measured_ones() -> None:
    asked = {"left_foot_reference": vertical(HALF), "right_foot_reference": vertical(HALF)}
    one = step(controller(), standing(**asked))
    two = step(
        controller(), standing(**asked, left_foot=vertical(HALF + 100), right_foot=vertical(HALF - 100))
    )
    np.testing.assert_allclose(one.effort, two.effort, atol=1e-12)
    other = step(controller(), standing(left_foot=vertical(HALF + 100), right_foot=vertical(HALF - 100)))
    assert np.abs(other.effort - one.effort).max() > 0.1


def test_ankles_of_a_foot_in_the_air_follow_the_reference_more_stiffly() -> None:
    ankle = robot().joint_index("l_ankle_pitch")
    row = row_of(ankle)
    ahead = hold()
    ahead.position[ankle] += 0.01
    gained = []
    for load in (HALF, 50.0, 0.0):
        feet = {"left_foot": vertical(load), "right_foot": vertical(HALF)}
        same = {"left_foot_reference": vertical(HALF), "right_foot_reference": vertical(HALF)}
        base, more = (step(controller(), standing(reference=r, **feet, **same)) for r in (hold(), ahead))
        gained.append(float((more.effort - base.effort)[row]))
    assert gained[0] < gained[1] < gained[2]
    assert gained[2] == pytest.approx(5.0 * gained[0], rel=1e-6)


def test_voltages_are_cut_at_the_limit_and_the_estimate_rests_there() -> None:
    knee = robot().joint_index("l_knee")
    far = hold()
    far.position[knee] -= 0.1
    late = []
    for limit in (8.0, 48.0):
        legs = controller(motor=MotorModel(voltage_limit=limit))
        for _ in range(50):
            command = step(legs, standing(reference=far, **FEET))
        cut = np.abs(command.effort).max() == limit
        assert cut == (limit == 8.0)
        shown = legs.diagnostics()
        assert shown["saturated_ticks"] == (50 if cut else 0)
        assert shown["peak_voltage [V]"] == pytest.approx(np.abs(command.effort).max(), rel=0.2)
        # Back at the reference: what is left is what the estimate has taken up.
        late.append(step(legs, standing(reference=hold(), **FEET)).effort[row_of(knee)])
    base = step(controller(), standing(reference=hold(), **FEET)).effort[row_of(knee)]
    assert abs(late[0] - base) < 0.1 * abs(late[1] - base)


def mirror(joints: Array) -> Array:
    """The posture reflected in the plane y = 0."""
    twin, signs = np.arange(45), np.ones(45)
    for index, name in enumerate(robot().joint_names):
        if name[:2] in ("l_", "r_"):
            twin[index] = robot().joint_index(f"{'r' if name[0] == 'l' else 'l'}_{name[2:]}")
        signs[index] = 1.0 if robot().pin_model.joints[index + 2].shortname().endswith("RY") else -1.0
    return np.asarray((signs * joints)[twin])


def mirrored_odometry(base: Odometry) -> Odometry:
    flip, turn = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    x, y, z, w = base.quat_xyzw
    return Odometry(
        base.position * flip,
        np.array([-x, y, -z, w]),
        base.linear_velocity * flip,
        base.angular_velocity * turn,
    )


def test_left_and_right_are_mirror_images() -> None:
    rng = np.random.default_rng(6)
    q, v = random_state(rng)
    reference = hold(q)
    reference.position[:] += rng.normal(0, 0.005, 45)
    flip, turn = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    feet = [Wrench(rng.normal(0, 20, 3) + np.array([0, 0, HALF]), rng.normal(0, 5, 3)) for _ in range(2)]
    hands = [Wrench(rng.normal(0, 10, 3), rng.normal(0, 2, 3)) for _ in range(2)]
    values = known(
        q,
        v,
        reference=reference,
        left_foot=feet[0],
        right_foot=feet[1],
        left_hand=hands[0],
        right_hand=hands[1],
    )

    def reflect(wrench: Wrench) -> Wrench:
        return replace(wrench, force=wrench.force * flip, torque=wrench.torque * turn)

    joints, base = values["joints"], values["odometry"]
    twin = {
        "joints": Joints(mirror(joints.position), mirror(joints.velocity), np.zeros(45)),
        "odometry": mirrored_odometry(base),
        "reference": Joints(mirror(reference.position), mirror(reference.velocity), np.zeros(45)),
        "left_foot": reflect(feet[1]), "right_foot": reflect(feet[0]),
        "left_hand": reflect(hands[1]), "right_hand": reflect(hands[0]),
    }  # fmt: skip
    one, two = step(controller(), values), step(controller(), twin)
    full = np.zeros(45)
    full[LEGS] = one.effort
    np.testing.assert_allclose(two.effort, mirror(full)[LEGS], atol=1e-6)


def test_without_desired_foot_wrenches_the_joints_are_stiff_about_the_reference() -> None:
    rng = np.random.default_rng(11)
    q, v = random_state(rng)
    error, rate = rng.normal(0, 0.002, 45), rng.normal(0, 0.02, 45)
    wanted = Joints(q[7:] + error, v[6:] + rate, np.zeros(45))
    legs = controller(stiffness=5000.0, damping=70.0)
    command = step(legs, known(q, v, reference=wanted))
    torque = MotorInverse(MotorModel(), robot(), LEGS).motor_torque(command.effort, v[6 + LEGS])
    driven = ~np.isin(LEGS, TOES)
    np.testing.assert_allclose(torque[driven], (5000.0 * error + 70.0 * rate)[LEGS][driven], atol=1e-9)
