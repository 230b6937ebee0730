"""Target points: lines, being led away, the workspace, and the command line of the experiments."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.arm_experiment.plan import make_arm_plan
from follower_humanoid.arm_experiment.simulate import simulate_arm
from follower_humanoid.arm_experiment.target_points import Leading, Line, TargetPlanner, TargetPoint
from follower_humanoid.arm_experiment.tasks import ArmTaskConfig
from follower_humanoid.errors import ConfigurationError

TICK = 0.002
BEGIN, GOAL = np.array([0.3, 0.2, 0.1]), np.array([0.4, 0.2, 0.3])


def planner(*points: TargetPoint) -> TargetPlanner:
    return TargetPlanner(BEGIN, points or (TargetPoint(GOAL, 0.2),), Leading(0.02, 0.01, 0.5), TICK)


def test_a_line_is_straight_smooth_and_no_faster_than_asked():
    line = Line.towards(BEGIN, TargetPoint(GOAL, 0.2))
    times = np.linspace(0.0, line.duration, 2001)
    places, rates = (np.array(column) for column in zip(*map(line.at, times), strict=True))
    way = (GOAL - BEGIN) / np.linalg.norm(GOAL - BEGIN)
    aside = (places - BEGIN) - np.outer((places - BEGIN) @ way, way)
    assert np.abs(aside).max() < 1e-12
    assert np.linalg.norm(rates, axis=1).max() == pytest.approx(0.2, rel=1e-4)
    np.testing.assert_allclose(np.gradient(places, times, axis=0)[1:-1], rates[1:-1], atol=1e-5)
    for end in (0, -1):
        np.testing.assert_allclose(rates[end], 0.0, atol=1e-12)
    np.testing.assert_allclose(places[[0, -1]], [BEGIN, GOAL])


def test_points_are_visited_in_order_with_their_rests():
    corner = np.array([0.3, 0.3, 0.1])
    plan = planner(TargetPoint(corner, 0.2, 0.3), TargetPoint(GOAL, 0.1))
    place, seen = BEGIN, []
    while not plan.done and len(seen) < 5000:
        place, _ = plan.step(place, 0.0)
        seen.append(place)
    resting = np.count_nonzero((np.array(seen) == corner).all(axis=1)) * TICK
    assert resting == pytest.approx(0.3, abs=0.01)
    np.testing.assert_allclose(seen[-1], GOAL)


def test_a_hand_that_is_led_is_followed_and_then_goes_on_from_where_it_rests():
    plan = planner()
    for _ in range(300):
        place, _ = plan.step(plan._line.at(plan._elapsed)[0], 0.1)
    away = place + np.array([0.0, 0.0, -0.1])
    for _ in range(100):
        followed, velocity = plan.step(away, 0.1)
        np.testing.assert_array_equal(followed, away)
        np.testing.assert_array_equal(velocity, 0.0)
    assert plan.led
    found = [plan.step(away, 0.001)[0] for _ in range(250)]
    np.testing.assert_array_equal(found[-2], away)
    assert not plan.led
    place = away
    for _ in range(3000):
        place, _ = plan.step(place, 0.1)
    np.testing.assert_allclose(place, GOAL)
    assert plan.done


def test_a_hand_that_stops_on_its_line_is_wanted_where_it_stopped():
    plan, stopped = planner(), BEGIN + 0.6 * (GOAL - BEGIN)
    hand, wanted, led = BEGIN, [BEGIN], []
    for _ in range(3000):
        planned, velocity = plan.step(hand, 0.0)
        wanted.append(planned)
        led.append(plan.led)
        if plan.led:
            np.testing.assert_array_equal(planned, stopped)
            np.testing.assert_array_equal(velocity, 0.0)
        hand = planned if (planned - stopped) @ (GOAL - BEGIN) < 0.0 else stopped
    again = np.flatnonzero(np.diff(np.array(led, dtype=int)) == -1)
    assert len(again) > 1, "it goes on from there, and is stopped again"
    jumps = np.linalg.norm(np.diff(wanted, axis=0), axis=1)
    assert jumps.max() < 0.02 + 0.2 * TICK, "the leash, and what a line travels in a tick"


def test_a_hand_that_is_pushed_off_its_last_point_ever_so_slowly_is_followed():
    plan, place = planner(), BEGIN
    while not plan.done:
        place, _ = plan.step(place, 0.0)
    for _ in range(2000):
        place = place + np.array([0.0, 0.005 * TICK, 0.0])
        wanted, _ = plan.step(place, 0.005)
        assert np.linalg.norm(wanted - place) < 0.0201


def test_the_square_has_its_side_and_lies_behind_the_surface():
    config = ArmTaskConfig(task="board")
    places = np.array([point.place for point in config.points(BEGIN)])
    pressed = places[places[:, 0] > config.board.distance]
    np.testing.assert_allclose(pressed[:, 0] - config.board.distance, 0.005)
    np.testing.assert_allclose(np.linalg.norm(np.diff(pressed, axis=0), axis=1), 0.12)
    np.testing.assert_array_equal(pressed[0], pressed[-1])
    np.testing.assert_array_equal(places[-1], BEGIN)


def refused(*args: str) -> str:
    with pytest.raises(ConfigurationError) as error:
        make_arm_plan([*args, "--bag", "none"] if "--bag" not in args else list(args))
    assert "\n" not in str(error.value)
    return str(error.value)


def given(name: str, value: str) -> tuple[str, ...]:
    return ("--ros-args", "-p", f"{name}:={value}", "--")


@pytest.mark.parametrize("name", ["board", "compliance"])
def test_an_experiment_runs_its_nodes_and_no_other(name):
    plan = make_arm_plan([name, "--bag", "none"])
    expected = {"simulator", "wrench_sensing", "arm_controller", "arm_task"}
    assert set(plan.nodes) == expected | ({"leader"} if name == "compliance" else set())
    for node in plan.nodes:
        assert set(plan.parameters[node]["nodes"].split(",")) == set(plan.nodes)
    assert plan.parameters["simulator"]["fixed_trunk"] is True
    assert plan.parameters["arm_task"]["task"] == name
    assert plan.about["command"].startswith("arm_experiment")


def test_duration_pace_and_files_are_passed_on(tmp_path):
    file = tmp_path / "slow.yaml"
    file.write_text("arm_task: {ros__parameters: {speed: 0.05}}\n")
    plan = make_arm_plan(["board", "--duration", "3", "--realtime", "--params", str(file), "--bag", "none"])
    assert plan.parameters["simulator"]["duration"] == 3.0
    assert plan.parameters["simulator"]["realtime"] is True
    assert plan.parameters["arm_task"]["speed"] == 0.05


@pytest.mark.parametrize(
    "target", ["[0.9, 0.2, 0.4]", "[-0.5, 0.2, 0.3]", "[0.3, -0.5, 0.2]", "[0.1, 0.2, 1.3]"]
)
def test_an_unreachable_target_is_refused(target):
    text = refused("compliance", *given("arm_task:compliance.target", target))
    assert text.startswith("target at (") and "out of reach" in text and "valid" in text


def test_a_square_outside_the_workspace_is_refused():
    assert "out of reach" in refused("board", *given("arm_task:board.side", "0.5"))
    assert "out of reach" in refused("board", *given("arm_task:board.center", "[0.9, 0.3]"))


@pytest.mark.parametrize("stiffness", ["[0.0, 100.0, 100.0]", "[100.0, -5.0, 100.0]", "[100.0, .nan, 100.0]"])
def test_a_stiffness_that_is_not_positive_is_refused(stiffness):
    assert "stiffness" in refused("board", *given("arm_controller:stiffness", stiffness))


def test_a_board_elsewhere_than_the_task_believes_is_refused():
    text = refused("board", *given("simulator:board.distance", "0.5"))
    assert "board.distance = 0.42" in text and "0.5" in text


def test_writing_in_the_air_is_refused():
    text = refused("board", *given("simulator:board.stiffness", "0.0"))
    assert text.startswith("simulator: board.stiffness = 0.0 N/m") and "valid: above 0 N/m" in text


def test_bad_words_are_refused():
    assert "no arm experiment 'wall'; valid: board, compliance" in refused("wall")
    assert "arm_experiment" in refused("board", "--fast")
    assert "arm_experiment: argument --duration" in refused("board", "--duration", "-1")
    assert "experiment" in refused()


@pytest.mark.parametrize("seconds", [-1.0, 0.0, float("nan")])
def test_an_experiment_without_a_tick_is_refused(seconds):
    with pytest.raises(ConfigurationError, match="duration"):
        simulate_arm("board", seconds)
