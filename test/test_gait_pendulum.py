"""The reference pendulum: closed form, consistent CoM, DCM and ZMP, a gap to the plan that decays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.pendulum import ReferencePendulum, momentum_shift, natural_frequency
from follower_humanoid.robot.model import GRAVITY

OMEGA = 3.5
DT = 0.002
CONVERGENCE = 4.0


def step(
    pendulum: ReferencePendulum, zmp: Array, dcm: Array, reach: float = 1.0, dt: float = DT,
    momentum: Array | None = None,
) -> None:  # fmt: skip
    swing = np.zeros(2) if momentum is None else momentum
    pendulum.advance(zmp, dcm, swing, OMEGA, convergence=CONVERGENCE, reach=reach, dt=dt)


def test_natural_frequency() -> None:
    assert natural_frequency(0.981) == pytest.approx(math.sqrt(10.0))


def test_constant_zmp_gives_the_closed_form_of_the_pendulum() -> None:
    # With the planned DCM always at the present one the ZMP stays where the plan has it.
    pendulum = ReferencePendulum(np.zeros(2))
    zmp = np.array([-0.02, 0.01])
    ticks = 400
    for _ in range(ticks):
        step(pendulum, zmp, pendulum.state.dcm)
    t = ticks * DT
    np.testing.assert_allclose(pendulum.state.com, zmp * (1 - math.cosh(OMEGA * t)), rtol=1e-9)
    np.testing.assert_allclose(pendulum.state.com_velocity, -zmp * OMEGA * math.sinh(OMEGA * t), rtol=1e-9)
    np.testing.assert_allclose(pendulum.state.dcm, zmp * (1 - math.exp(OMEGA * t)), rtol=1e-9)


def test_the_state_is_consistent_at_every_tick() -> None:
    rng = np.random.default_rng(4)
    pendulum = ReferencePendulum(np.array([0.1, 0.0]))
    for _ in range(200):
        step(pendulum, rng.normal(0, 0.05, 2), rng.normal(0, 0.05, 2), reach=0.04)
        state = pendulum.state
        np.testing.assert_allclose(state.dcm, state.com + state.com_velocity / OMEGA, atol=1e-12)


def test_com_and_velocity_never_jump_though_the_plan_does() -> None:
    pendulum = ReferencePendulum(np.zeros(2))
    states = []
    for tick in range(600):
        dcm = np.array([0.0, 0.0]) if tick < 200 else np.array([0.02, 0.05])
        step(pendulum, dcm, dcm, reach=0.04)
        states.append(np.concatenate((pendulum.state.com, pendulum.state.com_velocity)))
    steps = np.abs(np.diff(states, axis=0))
    assert steps[:, :2].max() < 0.5 * DT
    assert steps[:, 2:].max() < OMEGA**2 * 0.15 * DT


def test_the_gap_to_the_planned_dcm_decays_at_the_chosen_rate() -> None:
    pendulum = ReferencePendulum(np.array([0.03, -0.02]))
    start = pendulum.state.dcm
    dt = 1e-4
    for _ in range(10_000):
        step(pendulum, np.zeros(2), np.zeros(2), dt=dt)
    np.testing.assert_allclose(pendulum.state.dcm, start * math.exp(-CONVERGENCE), rtol=2e-3)


def test_the_zmp_shift_is_bounded_and_keeps_its_direction() -> None:
    pendulum = ReferencePendulum(np.array([0.3, 0.4]))
    step(pendulum, np.array([0.01, 0.0]), np.zeros(2), reach=0.05)
    np.testing.assert_allclose(pendulum.state.zmp, [0.01 + 0.03, 0.04], atol=1e-12)


def test_on_the_plan_the_zmp_is_the_planned_one() -> None:
    pendulum = ReferencePendulum(np.zeros(2))
    step(pendulum, np.array([0.02, 0.03]), np.zeros(2))
    np.testing.assert_array_equal(pendulum.state.zmp, [0.02, 0.03])


def test_momentum_shift_is_what_angular_momentum_does_to_the_zmp() -> None:
    # A ground force F at p turns the body about its CoM: L̇ = (p − c) × F; the CoM follows m c̈ = F + m g.
    rng = np.random.default_rng(5)
    mass = 70.0
    for _ in range(10):
        com, zmp = np.append(rng.normal(0, 0.1, 2), 0.85), np.append(rng.normal(0, 0.1, 2), 0.0)
        force = np.append(rng.normal(0, 50, 2), mass * GRAVITY)
        momentum_rate = np.cross(zmp - com, force)
        acceleration = force[:2] / mass
        omega = natural_frequency(com[2])
        expected = com[:2] - acceleration / omega**2 - momentum_shift(momentum_rate, mass)
        np.testing.assert_allclose(zmp[:2], expected, atol=1e-12)


def swing_momentum(time: float) -> Array:
    """λ of a swing that begins and ends gently [m·s]."""
    return np.array([0.003, -0.001]) * math.sin(math.pi * time / 0.6) ** 2


def test_com_follows_the_zmp_and_the_angular_momentum() -> None:
    pendulum = ReferencePendulum(np.zeros(2))
    dt = 5e-4
    states = []
    for tick in range(1200):
        step(pendulum, np.zeros(2), np.zeros(2), dt=dt, momentum=swing_momentum(tick * dt))
        states.append(pendulum.state)
    velocity = np.array([state.com_velocity for state in states])
    acceleration = np.diff(velocity, axis=0) / dt
    com, zmp = (np.array([getattr(state, name) for state in states]) for name in ("com", "zmp"))
    # λ̇ comes through a short low-pass.
    times = (np.arange(1200) * dt - 0.010)[:, None]
    h = 1e-5
    rate = np.array([(swing_momentum(t[0] + h) - swing_momentum(t[0] - h)) / (2 * h) for t in times])
    expected = OMEGA**2 * (com - zmp - rate)
    error = np.abs(acceleration - expected[1:])[100:]
    assert error.max() < 0.02 * np.abs(OMEGA**2 * rate).max() + 1e-3


def test_the_gap_to_the_plan_with_angular_momentum_decays_too() -> None:
    pendulum = ReferencePendulum(np.array([0.03, 0.0]))
    dt, seconds = 5e-4, 1.8
    for tick in range(round(seconds / dt)):
        step(pendulum, np.zeros(2), np.zeros(2), dt=dt, momentum=swing_momentum(tick * dt))
    # After whole swings, at rest, the DCM is on its plan again but for what is left of the start.
    left = 0.03 * math.exp(-CONVERGENCE * seconds)
    np.testing.assert_allclose(pendulum.state.dcm, [left, 0.0], atol=2e-4)
