"""ZMP from foot wrenches, support polygon and margin: hand-derived cases and brute force."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import frame_at
from scipy.spatial import ConvexHull

from follower_humanoid.balance.support_polygon import convex_hull, ground_hull, polygon_margin
from follower_humanoid.balance.zmp import measured_zmp, moved_to_origin
from follower_humanoid.core.samples import Array, Wrench

FLOOR = 50.0
NOTHING = Wrench(np.zeros(3), np.zeros(3))


def at(x: float, y: float, yaw: float = 0.0, z: float = 0.0) -> Array:
    return frame_at(np.array([x, y, z]), pin.rpy.rpyToMatrix(0.0, 0.0, yaw))


def pushed(force: float, forward: float, left: float) -> Wrench:
    """A vertical force at a point of a level sole, told at the sole origin."""
    return Wrench(np.array([0.0, 0.0, force]), np.array([left * force, -forward * force, 0.0]))


def test_one_foot_pushed_at_one_point() -> None:
    zmp = measured_zmp(pushed(700.0, 0.05, 0.01), NOTHING, at(0.4, 0.09), at(0.0, -0.09), FLOOR)
    np.testing.assert_allclose(zmp, [0.45, 0.10])
    turned = measured_zmp(pushed(700.0, 0.05, 0.01), NOTHING, at(0.4, 0.09, np.pi / 2), at(0, 0), FLOOR)
    np.testing.assert_allclose(turned, [0.39, 0.14])


def test_two_feet_share_like_a_balance() -> None:
    zmp = measured_zmp(
        pushed(500.0, 0.0, 0.0), pushed(250.0, 0.06, 0.0), at(0.3, 0.09), at(0.0, -0.09), FLOOR
    )
    np.testing.assert_allclose(zmp, [(500 * 0.3 + 250 * 0.06) / 750, (500 * 0.09 - 250 * 0.09) / 750])


def test_friction_on_the_ground_does_not_move_the_zmp_but_at_a_height_it_does() -> None:
    force = np.array([80.0, -30.0, 600.0])
    on_ground = measured_zmp(Wrench(force, np.zeros(3)), NOTHING, at(0.1, 0.2), at(0, 0), FLOOR)
    np.testing.assert_allclose(on_ground, [0.1, 0.2])
    raised = measured_zmp(Wrench(force, np.zeros(3)), NOTHING, at(0.1, 0.2, z=0.06), at(0, 0), FLOOR)
    np.testing.assert_allclose(raised, np.array([0.1, 0.2]) - 0.06 * force[:2] / force[2])


def test_zmp_is_where_the_wrench_has_no_horizontal_moment() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        places = [pin.SE3(pin.exp3(rng.normal(0, 0.3, 3)), rng.normal(0, 0.3, 3)) for _ in range(2)]
        wrenches = [
            Wrench(rng.normal(0, 30, 3) + np.array([0, 0, 400.0]), rng.normal(0, 20, 3)) for _ in range(2)
        ]
        zmp = measured_zmp(*wrenches, *(frame_at(p.translation, p.rotation) for p in places), FLOOR)
        assert zmp is not None
        moment = np.zeros(3)
        for wrench, place in zip(wrenches, places, strict=True):
            lever = place.translation - np.append(zmp, 0.0)
            moment += place.rotation @ wrench.torque + np.cross(lever, place.rotation @ wrench.force)
        np.testing.assert_allclose(moment[:2], np.zeros(2), atol=1e-9)


def test_transport_of_wrenches_does_not_change_them() -> None:
    # The same wrench told at another point and in other axes of the foot.
    rng = np.random.default_rng(2)
    for _ in range(10):
        position, rotation = rng.normal(0, 0.3, 3), pin.exp3(rng.normal(0, 1.0, 3))
        wrench = Wrench(rng.normal(0, 100, 3), rng.normal(0, 20, 3))
        offset, turn = rng.normal(0, 0.1, 3), pin.exp3(rng.normal(0, 1.0, 3))
        other = frame_at(position + rotation @ offset, rotation @ turn)
        moved = turn.T @ wrench.force, turn.T @ (wrench.torque - np.cross(offset, wrench.force))
        here = moved_to_origin(wrench.force, wrench.torque, frame_at(position, rotation))
        np.testing.assert_allclose(here, moved_to_origin(*moved, other), atol=1e-9)
        dual = pin.SE3(rotation, position).act(pin.Force(wrench.force, wrench.torque))
        np.testing.assert_allclose(np.concatenate(here), dual.vector, atol=1e-9)


def test_the_zmp_moves_with_the_robot() -> None:
    left, right = pushed(300.0, 0.02, 0.01), pushed(420.0, -0.01, 0.02)
    here = measured_zmp(left, right, at(0.0, 0.1, 0.1), at(0.0, -0.1, 0.1), FLOOR)
    away = measured_zmp(left, right, at(7.0, -2.9, 0.1), at(7.0, -3.1, 0.1), FLOOR)
    assert here is not None
    np.testing.assert_allclose(away, here + np.array([7.0, -3.0]))


@pytest.mark.parametrize("force", [0.0, 49.9, -300.0])
def test_below_the_force_floor_there_is_no_zmp(force: float) -> None:
    assert measured_zmp(pushed(force, 0.0, 0.0), NOTHING, at(0, 0), at(0, 0), FLOOR) is None
    assert measured_zmp(pushed(50.0, 0.0, 0.0), NOTHING, at(0, 0), at(0, 0), FLOOR) is not None


def area(polygon: Array) -> float:
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_hull_agrees_with_scipy_and_goes_counter_clockwise() -> None:
    rng = np.random.default_rng(3)
    for number in (3, 4, 6, 12, 40):
        points = rng.normal(size=(number, 2))
        hull, reference = convex_hull(points), ConvexHull(points)
        assert {tuple(p) for p in hull} == {tuple(p) for p in points[reference.vertices]}
        assert area(hull) == pytest.approx(reference.volume)
        assert area(hull) > 0.0


def test_the_hull_of_ground_points_leaves_out_what_is_in_the_air() -> None:
    rng = np.random.default_rng(7)
    frames = rng.normal(size=(20, 4, 3))
    chosen = np.array([3, 5, 6, 8, 11, 17, 19], dtype=np.int64)
    frames[chosen, 3, 2] = [0.0, -0.001, 0.0029, 0.0, 0.0031, 0.5, 0.0]
    hull = ground_hull(frames, chosen, 0.003)
    np.testing.assert_array_equal(hull[:, :2], convex_hull(frames[[3, 5, 6, 8, 19], 3, :2]))
    np.testing.assert_array_equal(hull[:, 2], np.zeros(len(hull)))
    assert ground_hull(frames, chosen, -1.0).shape == (0, 3)
    assert ground_hull(frames, chosen[:0], 0.003).shape == (0, 3)


def test_hull_of_points_that_coincide_or_lie_in_line() -> None:
    assert convex_hull(np.array([[1.0, 2.0]] * 5)).shape == (1, 2)
    assert {tuple(p) for p in convex_hull(np.array([[0.0, 0.0], [2.0, 2.0], [1.0, 1.0]]))} == {(0, 0), (2, 2)}
    square = np.array(
        [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.0], [1.0, 0.5], [0.5, 0.5], [0, 0]], dtype=float
    )
    assert {tuple(p) for p in convex_hull(square)} == {(0, 0), (1, 0), (1, 1), (0, 1)}


def brute_force_margin(polygon: Array, point: Array, inside: bool) -> float:
    """Distance to the edges, each walked in small steps."""
    u = np.linspace(0.0, 1.0, 2001)[:, None]
    nearest = min(
        float(np.min(np.linalg.norm(a + u * (b - a) - point, axis=1)))
        for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)
    )
    return nearest if inside else -nearest


def test_margin_agrees_with_brute_force() -> None:
    rng = np.random.default_rng(4)
    signs = set()
    for _ in range(40):
        polygon = convex_hull(rng.normal(0, 0.1, (8, 2)))
        point = rng.normal(0, 0.1, 2)
        turns = [np.cross(np.append(b - a, 0), np.append(point - a, 0))[2]
                 for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)]  # fmt: skip
        inside = min(turns) >= 0.0
        signs.add(inside)
        assert polygon_margin(polygon, point) == pytest.approx(
            brute_force_margin(polygon, point, inside), abs=2e-4
        )
    assert signs == {True, False}


def test_margin_of_a_rectangle() -> None:
    sole = np.array([[-0.07, -0.05], [0.19, -0.05], [0.19, 0.05], [-0.07, 0.05]])
    assert polygon_margin(sole, np.array([0.05, 0.0])) == pytest.approx(0.05)
    assert polygon_margin(sole, np.array([0.18, 0.02])) == pytest.approx(0.01)
    assert polygon_margin(sole, np.array([0.19, 0.0])) == pytest.approx(0.0, abs=1e-12)
    assert polygon_margin(sole, np.array([0.22, 0.0])) == pytest.approx(-0.03)
    assert polygon_margin(sole, np.array([0.22, 0.09])) == pytest.approx(-0.05)


def test_no_point_is_inside_a_line_or_a_point() -> None:
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    assert polygon_margin(line, np.array([0.0, 0.3])) < 0.0
    assert polygon_margin(line[:1], np.array([0.0, 0.3])) == pytest.approx(-0.3)
