"""The page in a real browser: what it shows, what can be done on it, and what happens when it goes."""

import dataclasses
import threading

import numpy as np
import pinocchio as pin
import pytest
from graph_bench import wait_until
from report_run import walking
from viewer_browser import Browser, needs_browser

from follower_humanoid.core.samples import SIDES, Joints, Odometry, Polygon, Side, Wrench
from follower_humanoid.pictures.shapes import visual_shapes
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.viewer.bag_page import BagPage
from follower_humanoid.viewer.config import PullConfig, ViewerConfig
from follower_humanoid.viewer.meshes import copies
from follower_humanoid.viewer.moment import Moment, Trail
from follower_humanoid.viewer.page import Page
from follower_humanoid.viewer.skeleton import Skeleton

pytestmark = needs_browser
# So long that a busy machine, which draws a picture in seconds, does not let go by itself.
CONFIG = ViewerConfig(port=0, shadows=False, rate=10.0, pull=PullConfig(patience=40.0))
HASTY = dataclasses.replace(CONFIG, pull=PullConfig(patience=8.0))
STANDING = np.zeros(45)
LINKS = {name: kind.links for name, kind in copies(RobotModel().urdf).items()}


@pytest.fixture(scope="module")
def robot():
    return RobotModel()


def posture(robot: RobotModel, position=STANDING, base=(0.0, 0.0, 0.91), quat=(0.0, 0.0, 0.0, 1.0), **more):
    zero = np.zeros(3)
    return Moment(
        1.0,
        {
            "joint_states": Joints(position, np.zeros(45), np.zeros(45)),
            "odom": Odometry(np.array(base), np.array(quat), zero, zero),
            **more,
        },
    )


class Shown:
    """A page that is drawn over and over, as the node draws it."""

    def __init__(self, robot: RobotModel, config: ViewerConfig = CONFIG) -> None:
        self.pushes: list[np.ndarray] = []
        self.resets = 0
        self.page = Page(config, Skeleton(robot.urdf), self.pushes.append, self.reset)
        self.moment = posture(robot)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._draw)
        self._thread.start()

    def reset(self) -> None:
        self.resets += 1

    def _draw(self) -> None:
        while not self._over.wait(1.0 / CONFIG.rate):
            if self.page.watched:
                self.page.show(self.moment, lambda _: Trail())

    def force(self) -> np.ndarray | None:
        return self.page.forces()[Side.LEFT]

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self.page.close("The run is over: the test has ended.")


@pytest.fixture(scope="module")
def shown(robot):
    shown = Shown(robot)
    yield shown
    shown.close()


@pytest.fixture(scope="module")
def browser(shown):
    browser = Browser()
    browser.open(shown.page.address)
    yield browser
    browser.close()


def test_the_page_needs_no_network_and_has_no_complaints(browser):
    browser.wait(lambda: "Standing." in browser.text())
    assert "Take its hand" in browser.text()
    assert browser.errors() == []


def test_links_and_handles_are_where_joints_and_base_put_them(robot, shown, browser):
    rng = np.random.default_rng(3)
    data = robot.pin_model.createData()
    for _ in range(3):
        position = rng.uniform(np.maximum(robot.lower, -1.0), np.minimum(robot.upper, 1.0))
        quat = rng.normal(size=4)
        quat /= np.linalg.norm(quat)
        base = rng.uniform(-2.0, 2.0, 3)
        shown.moment = posture(robot, position, base, quat)
        pin.framesForwardKinematics(robot.pin_model, data, np.concatenate((base, quat, position)))

        def wanted(frame: str) -> np.ndarray:
            return np.array(data.oMf[robot.frame_id(frame)].homogeneous)

        def off(found: np.ndarray, frame: str, local: np.ndarray) -> float:
            return float(np.linalg.norm(found[:3, 3] - (wanted(frame) @ [*local, 1.0])[:3]))

        browser.wait(lambda: off(browser.node("/world/handles/left_hand"), "l_gripper", np.zeros(3)) < 1e-3)
        assert off(browser.node("/world/handles/right_hand"), "r_gripper", np.zeros(3)) < 1e-3
        shapes = visual_shapes(robot.urdf)
        for name, links in LINKS.items():
            own = [s for s in shapes if s.kind == name.split("_")[0] and s.link in links]
            assert [shape.link for shape in own] == list(links)
            found = browser.copies(f"/world/robot/{name}", len(own))
            for shape, placed in zip(own, found, strict=True):
                assert off(placed, shape.link, np.array(shape.position)) < 1e-3
                axes = placed[:3, :3] / np.linalg.norm(placed[:3, :3], axis=0)
                turned = wanted(shape.link)[:3, :3] @ shape.rotation
                np.testing.assert_allclose(axes, turned, atol=1e-3)
    shown.moment = posture(robot)
    browser.wait(lambda: abs(browser.node("/world/handles/left_hand")[1, 3] - 0.19) < 1e-3)


def test_state_is_told_in_words(robot, shown, browser):
    square = Polygon(np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]], dtype=float))
    pull = Wrench(np.array([5.0, 0.0, 0.0]), np.zeros(3))
    standing = posture(robot, **{"left_hand/applied": pull, "support_polygon": square})
    for moment, words in (
        (standing, "Standing, led by the left hand."),
        (Moment(1.0, standing.samples, {"simulator": {"fallen": "True"}}), "Fallen"),
        (Moment(1.0, standing.samples, missing=("zmp_balance",)), "Missing: zmp_balance."),
        (Moment(1.0, standing.samples, silent=3.0), "stands still"),
        (Moment(1.0, {}), "Waiting for a robot."),
    ):
        shown.moment = moment
        browser.wait(lambda words=words: words in browser.text(), what=words)
    shown.moment = posture(robot)
    browser.wait(lambda: "Standing." in browser.text())


def test_a_dragged_handle_pulls_level_within_the_limit_until_released(shown, browser):
    browser.grab("/world/handles/left_hand", (60, 0))
    force = browser.wait(lambda: (f := shown.force()) is not None and np.linalg.norm(f) > 1.0 and [f])[0]
    assert abs(force[2]) < 0.5
    assert np.linalg.norm(force) <= CONFIG.pull.limit + 1e-6
    browser.release()
    browser.wait(lambda: shown.force() is None, CONFIG.pull.patience / 2)


def test_a_page_that_hangs_lets_go(robot, browser):
    shown = Shown(robot, HASTY)
    try:
        with browser.second_window():
            browser.open(shown.page.address)
            browser.grab("/world/handles/left_hand", (60, 0))
            browser.wait(lambda: shown.force() is not None)
            with browser.hanging():
                assert shown.force() is not None
                # Its connection stays: nothing else can have let go.
                assert wait_until(lambda: shown.force() is None, 18.0)
            browser.release()
    finally:
        shown.close()


def test_keys_push_and_reset(shown, browser):
    browser.script("document.activeElement.blur()")
    browser.keys("p")
    browser.wait(lambda: shown.pushes)
    np.testing.assert_allclose(shown.pushes[0], [0.0, 8.0, 0.0], atol=1e-9)
    browser.keys("r")
    browser.wait(lambda: shown.resets)


def test_legs_are_of_glass_until_a_key_makes_them_solid(shown, browser):
    browser.script("document.activeElement.blur()")
    assert browser.opacity("/world/robot/box") == 1.0
    for see_through in (False, True):
        browser.wait(lambda s=see_through: (browser.opacity("/world/robot/box_below_knee") < 1.0) is not s)
        browser.keys("g")
    browser.wait(lambda: browser.opacity("/world/robot/box_below_knee") < 1.0)


def test_sliders_work_by_keyboard_and_the_button_lets_go(shown, browser, monkeypatch):
    sliders = browser.driver.find_elements("css selector", "[role=slider]")
    sliders[0].send_keys("\ue014")  # the right arrow
    force = browser.wait(lambda: (f := shown.force()) is not None and [f])[0]
    np.testing.assert_allclose(force, [0.5, 0.0, 0.0], atol=1e-9)
    signs_of_life: list[int] = []
    monkeypatch.setattr(shown.page.hands, "heard", lambda page, now: signs_of_life.append(page))
    browser.wait(lambda: len(signs_of_life) > 1)
    assert set(signs_of_life) == shown.page.hands.pages()
    browser.driver.find_element("xpath", "//button[contains(., 'Let go')]").click()
    browser.wait(lambda: shown.force() is None)
    browser.wait(lambda: sliders[0].get_attribute("aria-valuenow") == "0")


def test_closing_the_page_in_the_middle_of_a_drag_lets_go(shown, browser):
    with browser.second_window():
        browser.open(shown.page.address)
        browser.grab("/world/handles/left_hand", (50, 0))
        browser.wait(lambda: shown.force() is not None)
    browser.wait(lambda: shown.force() is None, CONFIG.pull.patience / 2)
    assert all(not shown.page.hands.held(side) for side in SIDES)


def test_a_narrow_page_fits(shown, browser):
    with browser.phone(375, 720):
        browser.wait(lambda: browser.script("return window.innerWidth") == 375)
        browser.wait(lambda: "Follower" in browser.text())
        assert browser.script("return document.documentElement.scrollWidth") <= 375
        assert browser.script("return window.__viserMutable.canvas.getBoundingClientRect().width") > 300
    assert browser.errors() == []


def test_a_bag_plays_and_its_slider_moves_the_robot(browser):
    bag = BagPage(walking(), CONFIG)
    over = threading.Event()

    def play() -> None:
        while not over.wait(0.05):
            bag.draw(0.05)

    thread = threading.Thread(target=play)
    thread.start()
    try:
        browser.open(bag.page.address)
        slider = browser.driver.find_elements("css selector", "[role=slider]")[0]
        slider.send_keys("\ue010")  # End
        run = bag.tape.run
        wanted = run["odom"].position[-1]
        browser.wait(lambda: bag.transport.time == pytest.approx(bag.tape.end, abs=0.02))
        browser.wait(lambda: abs(-browser.script(OFFSET)[0] - wanted[0]) < 1e-3)
        browser.script("document.activeElement.blur()")
        browser.keys(" ")  # plays from the beginning
        browser.wait(lambda: 0.3 < bag.transport.time < 3.0)
        browser.keys(" ")
        browser.wait(lambda: not bag.transport.playing)
        assert browser.errors() == []
    finally:
        over.set()
        thread.join()
        bag.page.close("The viewer was stopped.")
    browser.wait(lambda: "The viewer was stopped." in browser.text())


OFFSET = "return window.__viserMutable.nodePoseData['/world'].position"
