"""The paper's balance law: corrects velocities, asks for no foot wrenches, and walks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import frame_pose, inputs_of, robot, standing_configuration, vertical
from test_balance_component import WEIGHT, com_of, known

from follower_humanoid.balance.balance import BalanceOutputs, ZmpBalance
from follower_humanoid.balance.paper_law import PaperConfig
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.graph.simulate import simulate

DT = 0.002
GAINS = PaperConfig()
STILL = 0.5  # time after which filter and ramp have settled [s]


def run(law: ZmpBalance, seconds: float, **changes: Any) -> BalanceOutputs:
    for _ in range(round(seconds / DT)):
        out: BalanceOutputs = law.step(inputs_of(ZmpBalance, **known(**changes)), 0.0)
    return out


def law(feedback: bool = True, hand_forces: bool = True, **gains: float) -> ZmpBalance:
    paper = replace(GAINS, **{"limit": 0.3, **gains})
    config = ZmpBalance.Config(law="paper", feedback=feedback, hand_forces=hand_forces, paper=paper)
    return ZmpBalance(config, robot(), DT)


def sent(out: BalanceOutputs) -> Array:
    """How far the corrected joints have the CoM from where the standing posture has it, shape (2,) [m]."""
    places = []
    assert out.reference is not None
    for joints in (standing_configuration()[7:], out.reference.position):
        q = np.concatenate((standing_configuration()[:7], joints))
        places.append(frame_pose(q, "l_sole").actInv(com_of(q)))
    return np.asarray((places[1] - places[0])[:2])


def zmp_moved(forward: float, left: float) -> dict[str, Wrench]:
    """Foot wrenches whose ZMP is off the CoM of the standing posture by so much."""
    q, foot = standing_configuration(), vertical(WEIGHT / 2)
    centre = com_of(q)[:2] - 0.5 * sum(frame_pose(q, f"{p}_sole").translation[:2] for p in "lr")
    x, y = centre + np.array([forward, left])
    moment = 0.5 * WEIGHT * np.array([y, -x, 0.0])
    return {"left_foot": replace(foot, torque=moment), "right_foot": replace(foot, torque=moment)}


ON_PLAN = zmp_moved(0.0, 0.0)


def test_on_the_plan_nothing_is_corrected_and_no_wrench_is_asked_for() -> None:
    out = run(law(), STILL, **ON_PLAN)
    assert out.left_foot_reference is None
    assert out.right_foot_reference is None
    assert out.dcm is None
    np.testing.assert_allclose(out.reference.position, standing_configuration()[7:], atol=1e-6)
    np.testing.assert_array_equal(out.zmp_command.xyz[:2], com_of(standing_configuration())[:2])


def moves(balance: ZmpBalance, **changes: Any) -> Array:
    """Velocity at which the CoM is sent away once filter and ramp have settled, shape (2,) [m/s]."""
    before = sent(run(balance, STILL, **changes))
    return (sent(run(balance, STILL, **changes)) - before) / STILL


@pytest.mark.parametrize("error", [(0.01, 0.0), (0.0, -0.005)])
def test_a_com_ahead_is_sent_back_at_the_rate_of_its_gain(error: tuple[float, float]) -> None:
    q = standing_configuration().copy()
    q[:2] += error
    velocity = moves(law(zmp=0.0), q=q, **ON_PLAN)
    np.testing.assert_allclose(velocity, -GAINS.pcm * np.array(error), atol=5e-4)


@pytest.mark.parametrize("error", [(0.01, 0.0), (0.0, -0.005)])
def test_a_zmp_ahead_sends_the_com_after_it(error: tuple[float, float]) -> None:
    velocity = moves(law(pcm=0.0), **zmp_moved(*error))
    omega = np.sqrt(9.81 / com_of(standing_configuration())[2])
    np.testing.assert_allclose(velocity, GAINS.zmp * omega * np.array(error), atol=5e-4)


def test_the_shift_is_limited_and_without_feedback_there_is_none() -> None:
    q = standing_configuration().copy()
    q[0] += 0.02
    far = sent(run(law(limit=0.03), 3.0, q=q, **ON_PLAN))
    np.testing.assert_allclose(far, [-0.03, 0.0], atol=5e-4)
    np.testing.assert_allclose(sent(run(law(feedback=False), STILL, q=q)), np.zeros(2), atol=1e-9)


def test_feet_that_do_not_carry_have_no_say_and_gains_grow_with_contact() -> None:
    q, air = standing_configuration().copy(), {"left_foot": vertical(0.0), "right_foot": vertical(0.0)}
    q[0] += 0.01
    balance = law(zmp=0.0, ramp_time=1.0)
    np.testing.assert_allclose(sent(run(balance, STILL, q=q, **air)), np.zeros(2), atol=1e-6)
    early = sent(run(balance, 0.2, q=q, **ON_PLAN))
    # With the gain growing by 1 a second the shift is that of a constant gain times t/2.
    assert early[0] == pytest.approx(-GAINS.pcm * 0.01 * 0.2 * 0.1, rel=0.1)


def test_against_a_pull_the_com_rests_elsewhere_unless_hands_are_left_out() -> None:
    pull = {"left_hand": Wrench(np.array([-10.0, 0.0, 0.0]), np.zeros(3))}
    height = pin.SE3(frame_pose(standing_configuration(), "l_gripper")).translation[2]
    expected = GAINS.pcm * 10.0 * height / WEIGHT
    assert moves(law(zmp=0.0), **pull, **ON_PLAN)[0] == pytest.approx(expected, abs=5e-4)
    assert moves(law(zmp=0.0, hand_forces=False), **pull, **ON_PLAN)[0] == pytest.approx(0.0, abs=1e-6)


def test_it_takes_the_first_step_of_fig_4() -> None:
    run_ = simulate("fig4", 4.6, {"zmp_balance": {"law": "paper"}})
    assert run_["odom"].times[-1] > 4.59
    assert run_["odom"].position[-1, 0] > 0.3
