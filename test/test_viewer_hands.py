"""What a page does to the robot's hands: limits, and letting go whatever happens to the page."""

import numpy as np
import pytest

from follower_humanoid.core.samples import Side
from follower_humanoid.viewer.config import PullConfig
from follower_humanoid.viewer.hands import Hands, level_target
from follower_humanoid.viewer.push import LENGTH, Push

LEFT, RIGHT = Side.LEFT, Side.RIGHT
CONFIG = PullConfig(limit=20.0, stiffness=50.0, patience=1.5)
HAND = np.array([0.3, 0.2, 0.9])
FORWARD = np.array([0.1, 0.0, 0.0])
GRIP = np.array([0.02, -0.03, 0.01])


def test_a_level_leash_stays_level_with_a_hand_that_sinks():
    hands = Hands(CONFIG)
    hands.pull_to(LEFT, 1, HAND + GRIP, 0.0, GRIP, level=True)
    hands.pull_to(LEFT, 1, HAND + GRIP + FORWARD, 0.0, level=True)
    force = hands.force(LEFT, HAND - [0.0, 0.0, 0.08], 0.0)
    np.testing.assert_allclose(force, CONFIG.stiffness * FORWARD, atol=1e-12)


@pytest.fixture
def hands() -> Hands:
    return Hands(CONFIG)


def grab(hands: Hands, pull: tuple[float, float, float], page: int = 1, now: float = 0.0) -> None:
    hands.pull_to(LEFT, page, HAND + GRIP, now, GRIP)
    hands.pull_to(LEFT, page, HAND + GRIP + np.array(pull), now)


def test_taking_a_hand_does_not_pull_yet(hands):
    hands.pull_to(LEFT, 1, HAND + GRIP, 0.0, GRIP)
    np.testing.assert_allclose(hands.force(LEFT, HAND, 0.0), 0.0, atol=1e-12)


def test_the_leash_pulls_like_a_spring_towards_the_pointer(hands):
    grab(hands, (0.1, -0.02, 0.0))
    np.testing.assert_allclose(hands.force(LEFT, HAND, 0.0), [5.0, -1.0, 0.0])
    np.testing.assert_allclose(hands.force(LEFT, HAND + FORWARD, 0.0), [0.0, -1.0, 0.0], atol=1e-12)
    assert hands.force(RIGHT, HAND, 0.0) is None


def test_no_pull_exceeds_the_limit_and_its_direction_stays(hands):
    rng = np.random.default_rng(1)
    for _ in range(50):
        pull = rng.normal(size=3) * rng.uniform(0.0, 3.0)
        grab(hands, pull)
        force = hands.force(LEFT, HAND, 0.0)
        hands.pull_with(RIGHT, 1, 60.0 * pull, 0.0)
        for got in (force, hands.force(RIGHT, HAND, 0.0)):
            assert np.linalg.norm(got) <= CONFIG.limit + 1e-9
            np.testing.assert_allclose(np.cross(got, pull), 0.0, atol=1e-9)
            assert got @ pull > 0.0


@pytest.mark.parametrize("end", ["release", "disconnect", "all"])
def test_letting_go(hands, end):
    grab(hands, (0.2, 0.0, 0.0))
    if end == "release":
        hands.let_go(LEFT, 1)
    elif end == "disconnect":
        hands.gone(1)
    else:
        hands.let_all_go()
    assert hands.force(LEFT, HAND, 0.0) is None
    assert not hands.pages()


def test_a_page_that_falls_silent_has_let_go_until_it_drags_on(hands):
    grab(hands, (0.2, 0.0, 0.0))
    hands.heard(1, 1.0)
    assert hands.force(LEFT, HAND, 1.0 + CONFIG.patience) is not None
    assert hands.force(LEFT, HAND, 1.0 + CONFIG.patience + 0.01) is None
    hands.heard(1, 2.9)
    assert hands.force(LEFT, HAND, 2.9) is None
    hands.pull_to(LEFT, 1, HAND + GRIP + FORWARD, 3.0)  # its pointer moves on: the button is still down
    np.testing.assert_allclose(hands.force(LEFT, HAND, 3.0), [5.0, 0.0, 0.0])
    hands.let_go(LEFT, 1)
    hands.pull_to(LEFT, 1, HAND + 1.0, 3.0)
    assert hands.force(LEFT, HAND, 3.0) is None


def test_a_steady_pull_needs_signs_of_life_too(hands):
    hands.pull_with(LEFT, 1, np.array([5.0, 0.0, 0.0]), 0.0)
    for now in np.arange(0.0, 10.0, 1.0):
        hands.heard(1, now)
        assert hands.force(LEFT, HAND, now) is not None
    assert hands.force(LEFT, HAND, 9.0 + CONFIG.patience + 0.1) is None


def test_signs_of_life_of_another_page_do_not_count(hands):
    grab(hands, (0.2, 0.0, 0.0), page=1)
    hands.heard(2, 5.0)
    assert hands.force(LEFT, HAND, 5.0) is None


def test_the_newest_page_wins_and_the_older_ones_release_is_not_its(hands):
    grab(hands, (0.2, 0.0, 0.0), page=1)
    grab(hands, (-0.1, 0.0, 0.0), page=2)
    hands.pull_to(LEFT, 1, HAND + 1.0, 0.0)
    hands.let_go(LEFT, 1)
    hands.gone(1)
    np.testing.assert_allclose(hands.force(LEFT, HAND, 0.0), [-5.0, 0.0, 0.0])


def test_sliders_back_at_zero_let_go(hands):
    hands.pull_with(LEFT, 1, np.array([5.0, 0.0, 0.0]), 0.0)
    assert hands.steady(LEFT)
    hands.pull_with(LEFT, 1, np.zeros(3), 0.0)
    assert not hands.held(LEFT)


def test_a_level_target_lies_at_the_height_and_behind_the_pointer():
    rng = np.random.default_rng(2)
    for _ in range(50):
        eye = np.array([*rng.uniform(-3, 3, 2), rng.uniform(1.5, 3.0)])
        pointer = np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(0.6, 1.2)])
        target = level_target(eye, pointer, 0.9)
        assert target[2] == pytest.approx(0.9)
        if not np.allclose(target[:2], pointer[:2]):
            np.testing.assert_allclose(np.cross(pointer - eye, target - eye), 0.0, atol=1e-9)


def test_who_looks_along_the_level_pulls_below_the_pointer():
    target = level_target(np.array([3.0, 0.0, 0.9]), np.array([0.0, 0.4, 0.95]), 0.9)
    np.testing.assert_allclose(target, [0.0, 0.4, 0.9])


def test_a_push_has_its_impulse_and_ends_with_zero():
    push = Push()
    assert not push.active
    impulse = np.array([3.0, -8.0, 0.0])
    push.begin(impulse, 10.0)
    times = 10.0 + 0.001 * np.arange(1000)
    forces = np.array([push.force(t) for t in times])
    np.testing.assert_allclose(forces.sum(axis=0) * 0.001, impulse, rtol=0.01)
    assert np.all(forces[times > 10.0 + LENGTH + 1e-6] == 0.0)
    assert not push.active


def test_a_push_ends_where_time_begins_anew():
    push = Push()
    push.begin(np.array([5.0, 0.0, 0.0]), 10.0)
    assert not push.force(0.0).any()
    assert not push.active
