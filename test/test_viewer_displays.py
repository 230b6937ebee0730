"""Markers and scene agree with what was measured."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from report_run import walking

from follower_humanoid.core.samples import Footstep, Footsteps, Polygon, Side, Wrench
from follower_humanoid.pictures.palette import HAND_FORCE_SCALE
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.markers import Markers
from follower_humanoid.viewer.carried import VISIBLE, carry
from follower_humanoid.viewer.meshes import ball, copies
from follower_humanoid.viewer.moment import Moment, TrailKeeper
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.speedometer import Speedometer
from follower_humanoid.viewer.tape import Tape
from follower_humanoid.viewer.words import figures, state_words

SQUARE = np.array([[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]])


@pytest.fixture(scope="module")
def tape():
    return Tape(walking())


@pytest.fixture
def moment(tape):
    shown = tape.moment(3.0)
    steps = (
        Footstep(Side.LEFT, np.array([0.5, 0.09, 0.0]), 0.3, taken=True),
        Footstep(Side.RIGHT, np.array([0.9, -0.09, 0.0]), 0.3, taken=False),
    )
    more = {
        "left_hand/applied": Wrench(np.array([5.0, 0.0, -2.0]), np.zeros(3)),
        "support_polygon": Polygon(SQUARE),
        "footsteps": Footsteps(steps),
    }
    return Moment(shown.time, {**shown.samples, **more})


def test_arrows_begin_at_the_hands_and_have_the_length_of_the_force(moment):
    skeleton = Skeleton()
    markers = Markers(skeleton).of(moment).markers
    (arrow,) = [m for m in markers if m.ns == "hand_force" and m.action == m.ADD]
    start, tip = (np.array([p.x, p.y, p.z]) for p in arrow.points)
    np.testing.assert_allclose(start, skeleton.position("l_gripper"))
    np.testing.assert_allclose(tip - start, HAND_FORCE_SCALE * np.array([5.0, 0.0, -2.0]))


def test_polygon_is_closed_and_planned_steps_are_pale(moment):
    markers = Markers(Skeleton()).of(moment).markers
    (polygon,) = [m for m in markers if m.ns == "support_polygon"]
    assert len(polygon.points) == 5
    assert polygon.points[0] == polygon.points[-1]
    taken, planned = [m for m in markers if m.ns == "footsteps" and m.action == m.ADD]
    assert planned.color.a < 0.5 < taken.color.a
    assert 2 * np.arctan2(taken.pose.orientation.z, taken.pose.orientation.w) == pytest.approx(0.3)


def test_no_two_markers_of_a_message_share_a_name_and_steps_that_are_gone_are_deleted(moment):
    markers = Markers(Skeleton())
    fewer = Moment(moment.time, {**moment.samples, "footsteps": Footsteps(moment["footsteps"].steps[:1])})
    for shown, steps, gone in ((moment, 2, 0), (fewer, 1, 1), (fewer, 1, 1), (moment, 2, 0)):
        found = markers.of(shown).markers
        assert len({(m.ns, m.id) for m in found}) == len(found)
        assert all(m.action in (m.ADD, m.DELETE) for m in found)
        footsteps = [m for m in found if m.ns == "footsteps"]
        assert sum(m.action == m.ADD for m in footsteps) == steps
        assert sum(m.action == m.DELETE for m in footsteps) == gone


def test_every_marker_is_in_the_world_at_the_time_of_the_state(moment):
    for marker in Markers(Skeleton()).of(moment).markers:
        assert marker.header.frame_id == "world"
        assert marker.header.stamp.sec + 1e-9 * marker.header.stamp.nanosec == pytest.approx(moment.time)


def test_a_tape_shows_what_was_there_at_a_time(tape):
    run = tape.run
    for time in (tape.begin, 2.5, tape.end):
        tick = round(time / run.tick)
        shown = tape.moment(time)
        np.testing.assert_array_equal(shown["odom"].position, run["odom"].position[tick])
        np.testing.assert_array_equal(shown["joint_states"].position, run["joint_states"].position[tick])
    assert len(tape.trail(tape.begin).path) <= 1
    ahead = np.diff([len(tape.trail(time).path) for time in np.linspace(tape.begin, tape.end, 20)])
    assert (ahead >= 0).all()
    assert ahead.sum() > 0


def test_copies_cover_every_visual_with_its_true_size():
    urdf = RobotModel().urdf
    kinds = copies(urdf)
    assert sum(len(kind.links) for kind in kinds.values()) == urdf.count("<visual>")
    for kind in kinds.values():
        points, faces = kind.mesh
        np.testing.assert_allclose(np.ptp(points, axis=0), 1.0, atol=0.03)
        assert set(faces.ravel()) == set(range(len(points)))


def test_faces_of_the_ball_look_outward():
    points, faces = ball()
    a, b, c = (points[faces[:, i]] for i in range(3))
    assert (np.sum(np.cross(b - a, c - a) * (a + b + c), axis=1) > 0.0).all()


def table(poses):
    return np.array([[*pose.rotation.T, pose.translation] for pose in poses])


def told(count):
    return np.zeros((count, 3), np.float32), np.zeros((count, 4), np.float32)


def test_poses_are_carried_like_matrices_are_multiplied():
    pin.seed(7)
    frames = [pin.SE3.Random() for _ in range(5)]
    within = [pin.SE3.Random() for _ in range(40)]
    rows = np.arange(40) % 5
    positions, wxyz = told(40)
    assert carry(table(frames), rows, table(within), positions, wxyz)
    for n, pose in enumerate(within):
        together = frames[rows[n]] * pose
        np.testing.assert_allclose(positions[n], together.translation, atol=1e-6)
        turned = pin.Quaternion(*wxyz[n].astype(float)).toRotationMatrix()
        np.testing.assert_allclose(turned, together.rotation, atol=1e-6)


@pytest.mark.parametrize("axis", np.eye(3))
def test_half_turns_are_carried_too(axis):
    half = pin.SE3(pin.exp3(np.pi * axis), np.zeros(3))
    positions, wxyz = told(1)
    assert carry(table([half]), np.array([0]), table([pin.SE3.Identity()]), positions, wxyz)
    np.testing.assert_allclose(np.abs(wxyz[0]), [0.0, *axis], atol=1e-6)


def test_what_creeps_is_never_told_farther_from_where_it_is_than_can_be_seen():
    pin.seed(3)
    within, rows, (positions, wxyz) = table([pin.SE3.Random()]), np.array([0]), told(1)
    told_at = []
    for step in range(100):
        place = pin.SE3(np.eye(3), np.array([0.3e-4 * step, 0.0, 0.0]))
        told_at += [step] if carry(table([place]), rows, within, positions, wxyz) else []
        assert abs(positions[0, 0] - within[0, 3, 0] - place.translation[0]) <= 1.01 * VISIBLE
    assert 20 < len(told_at) < 40


def test_the_trail_remembers_each_footprint_once(moment):
    keeper = TrailKeeper()
    for _ in range(3):
        trail = keeper.add(moment)
    assert [step.side for step in trail.prints] == [Side.LEFT]
    assert keeper.add(moment) is trail


def test_a_robot_that_is_put_elsewhere_begins_a_trail_anew(moment):
    keeper = TrailKeeper()
    keeper.add(moment)
    elsewhere = dataclasses.replace(
        moment["odom"], position=moment["odom"].position + np.array([2.0, 0.0, 0.0])
    )
    trail = keeper.add(Moment(moment.time, {**moment.samples, "odom": elsewhere}))
    np.testing.assert_array_equal(trail.path, [elsewhere.position])
    assert trail.prints == ()


def test_margin_and_words(moment):
    samples = {**moment.samples, "zmp": type(moment["zmp"])(np.array([0.04, 0.0, 0.0]))}
    inside = Moment(3.0, samples)
    assert inside.zmp_margin() == pytest.approx(0.06)
    assert ("ZMP margin", "60 mm") in figures(inside)
    assert np.isnan(Moment(0.0).zmp_margin())
    assert state_words(Moment(0.0)) == ("waiting", "Waiting for a robot.")
    ended = Moment(1.0, inside.samples, {"simulator": {"ended": "the run ended at 1.000 s"}})
    assert state_words(ended)[1] == "The run is over: the run ended at 1.000 s."


def test_speed_is_simulated_time_over_wall_time():
    speedometer = Speedometer()
    assert np.isnan(speedometer.look(0.0, 100.0))
    for step in range(1, 60):
        speed = speedometer.look(0.05 * step, 100.0 + 0.1 * step)
    assert speed == pytest.approx(0.5)
    speedometer.look(0.0, 200.0)
    assert np.isnan(speedometer.look(0.01, 200.1))
