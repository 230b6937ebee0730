"""Walking parameters from the pull: eqs. (19), (20), start and stop, turning."""

from __future__ import annotations

import math

import numpy as np
import pytest

from follower_humanoid.control.arm_modes import COMPENSATION, IMPEDANCE
from follower_humanoid.core.samples import Gait, PrimitiveStates, Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.gait.mapping import GaitMapping, GaitMappingConfig, intensity_factor, shortest_turn
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.robot.model import RobotModel

PERIOD = 0.01
HALF_STEP = 3.1
ZERO = Wrench(np.zeros(3), np.zeros(3))


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def pull(x: float, y: float, z: float = -10.0) -> Wrench:
    return Wrench(np.array([x, y, z]), np.zeros(3))


def run(mapping: GaitMapping, seconds: float, left: Wrench, right: Wrench = ZERO) -> list[Gait]:
    updates = round(seconds / PERIOD)
    return [mapping.step(GaitMapping.Inputs(left, right), k * PERIOD).gait for k in range(updates)]


def mapping(robot: RobotModel, **values: float) -> GaitMapping:
    return GaitMapping(GaitMappingConfig(**values), robot, PERIOD)


@pytest.mark.parametrize(("force", "factor"), [(0, 1.0), (1, 1.05), (3, 1.15), (5, 1.25), (40, 1.25)])
def test_equation_20(force: float, factor: float) -> None:
    assert intensity_factor(force, 5.0, 20.0) == pytest.approx(factor)


@pytest.mark.parametrize(
    ("force", "degrees"),
    [((5, 0), 0.0), ((4, 3), 36.87), ((0, 5), 90.0), ((-5, 0), 180.0), ((-3, -4), -126.87)],
)
def test_equation_19_direction_is_reached_in_world_axes(
    robot: RobotModel, force: tuple[float, float], degrees: float
) -> None:
    gait = run(mapping(robot), 40.0, pull(*force))[-1]
    difference = shortest_turn(gait.walk_dir, math.radians(degrees))
    assert abs(difference) < 1e-4
    assert gait.heading == gait.walk_dir


def test_zero_force_holds_the_last_direction_and_stands(robot: RobotModel) -> None:
    component = mapping(robot)
    turned = run(component, 12.0, pull(4, 3))[-1].walk_dir
    gaits = run(component, 5.0, ZERO)
    assert turned == pytest.approx(math.atan2(3, 4), abs=1e-9)
    assert gaits[-1].walk_speed == 0.0
    assert gaits[-1].walk_dir == pytest.approx(turned, abs=1e-9)


def test_hands_that_were_not_measured_for_a_while_must_call_anew(robot: RobotModel) -> None:
    component = mapping(robot)
    nothing = GaitMapping.Inputs(None, None)
    assert run(component, 2.0, pull(5, 0))[-1].walk_speed > 0.0
    assert component.step(nothing, 0.0).gait.walk_speed == 0.0
    assert run(component, PERIOD, pull(5, 0))[0].walk_speed > 0.0  # one message was lost
    for _ in range(round(GaitMappingConfig().stop_time / PERIOD)):
        component.step(nothing, 0.0)
    assert {gait.walk_speed for gait in run(component, 5.0, ZERO)} == {0.0}
    assert run(component, PERIOD, pull(5, 0))[0].walk_speed == 0.0


def test_starts_after_the_start_time_and_within_400_ms(robot: RobotModel) -> None:
    for newton in (1.0, 3.0, 5.0):
        component = mapping(robot)
        run(component, 0.5, ZERO)
        gaits = run(component, 1.0, pull(newton, 0))
        begin = next(k for k, gait in enumerate(gaits) if gait.walk_speed > 0) * PERIOD
        assert 0.2 <= begin <= 0.4


def test_full_speed_soon_after_the_start(robot: RobotModel) -> None:
    component = mapping(robot)
    run(component, 0.5, ZERO)
    gaits = run(component, 1.0, pull(5, 0))
    assert gaits[60].walk_speed == pytest.approx(1.25, abs=0.002)
    assert gaits[60].step_length == gaits[60].walk_speed


def test_short_pull_and_short_pause_change_nothing(robot: RobotModel) -> None:
    component = mapping(robot, filter_time=0.0)
    assert all(g.walk_speed == 0 for g in run(component, 0.19, pull(5, 0)) + run(component, 1.0, ZERO))
    assert run(component, 0.3, pull(5, 0))[-1].walk_speed > 0
    assert all(g.walk_speed > 0 for g in run(component, 0.49, ZERO))
    assert all(g.walk_speed > 0 for g in run(component, 1.0, pull(5, 0)))


def test_between_the_thresholds_the_state_stays(robot: RobotModel) -> None:
    component = mapping(robot)
    assert all(gait.walk_speed == 0 for gait in run(component, 3.0, pull(0.55, 0)))
    run(component, 1.0, pull(3, 0))
    assert run(component, 3.0, pull(0.55, 0))[-1].walk_speed > 0


def test_stops_after_the_stop_time_and_starts_again(robot: RobotModel) -> None:
    component = mapping(robot, filter_time=0.0)
    run(component, 2.0, pull(5, 0))
    gaits = run(component, 1.0, ZERO)
    stop = next(k for k, gait in enumerate(gaits) if gait.walk_speed == 0) * PERIOD
    assert stop == pytest.approx(0.5, abs=2 * PERIOD)
    assert run(component, 1.0, pull(5, 0))[-1].walk_speed > 0


def test_two_hands_add_as_vectors_and_z_is_left_out(robot: RobotModel) -> None:
    both = run(mapping(robot), 2.0, pull(1, 0.5, -100), pull(1, -0.5, 50))[-1]
    one = run(mapping(robot), 2.0, pull(2, 0, 0))[-1]
    assert both == one
    other = run(mapping(robot), 2.0, ZERO, pull(2, 0, 0))[-1]
    assert other == one


def test_direction_moves_in_fixed_steps_and_snaps(robot: RobotModel) -> None:
    component = mapping(robot, filter_time=0.0)
    gaits = run(component, 12.0, pull(4, 3))
    walking = [gait.walk_dir for gait in gaits if gait.walk_speed > 0]
    steps = np.diff(walking)
    moving = steps[: int(np.argmax(steps < 8.9e-4))]
    np.testing.assert_allclose(moving, 0.09 * PERIOD, rtol=1e-9)
    assert walking[-1] == math.atan2(3, 4)
    assert walking.count(walking[-1]) > 100


def test_figure_5_turns_within_three_half_steps_and_gently(robot: RobotModel) -> None:
    component = mapping(robot)
    run(component, 6.6, pull(5, 0))
    directions = [gait.walk_dir for gait in run(component, 3 * HALF_STEP, pull(4, 3))]
    assert directions[-1] == pytest.approx(math.radians(36.87), abs=1e-4)
    half_step = round(3.3 / PERIOD)
    assert max(np.array(directions[half_step:]) - np.array(directions[:-half_step])) <= 0.3


def test_turns_the_shortest_way_across_pi(robot: RobotModel) -> None:
    component = mapping(robot, initial_direction=3.0)
    directions = [gait.walk_dir for gait in run(component, 6.0, pull(5 * math.cos(-3.0), 5 * math.sin(-3.0)))]
    assert all(abs(direction) >= 3.0 - 1e-9 for direction in directions)
    assert directions[-1] == pytest.approx(-3.0, abs=1e-4)
    assert shortest_turn(0.0, -math.pi) == math.pi == shortest_turn(0.0, math.pi)


def test_noise_on_a_backward_pull_does_not_turn_to_and_fro(robot: RobotModel) -> None:
    component = mapping(robot, filter_time=0.0)
    rng = np.random.default_rng(3)
    turned = []
    for k in range(1000):
        gait = component.step(GaitMapping.Inputs(pull(-5, rng.normal(0, 0.1)), ZERO), k * PERIOD).gait
        turned.append(abs(gait.walk_dir))
    assert turned[-1] == pytest.approx(0.09 * 9.8, abs=0.01)
    assert np.all(np.diff(turned) >= 0)


def test_without_both_wrenches_the_robot_stands(robot: RobotModel) -> None:
    component = mapping(robot)
    for k in range(100):
        gait = component.step(GaitMapping.Inputs(None, pull(5, 0)), k * PERIOD).gait
        assert gait.walk_speed == 0.0


def test_thresholds_without_a_gap_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"stop_force = 0\.8: needs to be below start_force = 0\.7"):
        GaitMappingConfig(stop_force=0.8)


def modes(left: str, right: str) -> PrimitiveStates:
    return PrimitiveStates((f"left_hand/{left}", f"right_hand/{right}"), (1.0, 1.0))


@pytest.mark.parametrize(
    ("arms", "walks"),
    [
        (None, True),
        (modes(IMPEDANCE, IMPEDANCE), True),
        (modes(COMPENSATION, IMPEDANCE), False),
        (modes(IMPEDANCE, COMPENSATION), True),
        (modes(COMPENSATION, COMPENSATION), False),
    ],
)
def test_a_hand_that_is_led_does_not_call_for_a_walk(
    robot: RobotModel, arms: PrimitiveStates | None, walks: bool
) -> None:
    component = mapping(robot)
    gaits = [component.step(GaitMapping.Inputs(pull(5, 2), ZERO, arms), k * PERIOD).gait for k in range(300)]
    assert (gaits[-1].walk_speed > 0.0) == walks


def test_leading_a_hand_sideways_moves_the_hand_and_not_the_feet() -> None:
    lead = Wrench(np.array([0.0, 9.0, 0.0]), np.zeros(3))

    def led(topic: str, tick: int, sample: object) -> object:
        return lead if topic == "leader/left_hand/wrench" and tick >= 100 else sample

    steps = {}
    for mode in (IMPEDANCE, COMPENSATION):
        run = simulate("fig4", 1.6, {"arm_controller": {"mode": mode}}, interference=led)
        steps[mode] = max(run["gait"].walk_speed)
    assert steps[IMPEDANCE] > 0.0
    assert steps[COMPENSATION] == 0.0
