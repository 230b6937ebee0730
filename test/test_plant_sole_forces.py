"""The compiled arithmetic of the soles against Pinocchio and closed forms."""

import numpy as np
import pinocchio as pin
import pytest
from plant_bench import robot

from follower_humanoid.plant import sole_forces

POINTS, COLUMNS = 12, 20
FRICTION, STIFFNESS, STEP = 0.7, 1e5, 1e-3


@pytest.fixture
def random():
    return np.random.default_rng(5)


class Contact:
    """Arrays of points in random states, as `sole_forces` wants them."""

    def __init__(self, random):
        self.jacobian = random.normal(size=(POINTS, 3, COLUMNS))
        self.jacobian[:, :, 9:14] = 0.0  # columns that carry no point
        self.trial, self.slip = random.normal(size=(POINTS, 3)), random.normal(size=(POINTS, 2))
        self.pressing = random.random(POINTS) < 0.7
        self.sticking = self.pressing & (random.random(POINTS) < 0.5)
        self.start, self.gain = np.zeros((2, POINTS, 3))
        self.change, self.force = np.zeros((2, POINTS, 3))

    @property
    def slipping(self):
        return self.pressing & ~self.sticking

    def add_to(self, implicit, matrix, right_side):
        sole_forces.add_to(
            self.jacobian, self.trial, self.slip, self.pressing, self.sticking, implicit,
            self.start, self.gain, matrix, right_side,
        )  # fmt: skip

    def finish(self, implicit, acceleration):
        return sole_forces.finish(
            self.jacobian, acceleration, self.trial, self.start, self.gain, FRICTION, implicit,
            self.change, self.force, self.slip, self.pressing, self.sticking,
        )  # fmt: skip


def test_a_point_is_placed_as_pinocchio_places_it(random):
    moved, local, points = [pin.SE3.Random() for _ in range(3)], random.normal(size=(4, 3)), np.zeros((4, 3))
    poses = np.array([np.vstack((pose.rotation.T, pose.translation)) for pose in moved])
    carriers = np.array([2, 0, 0, 1])
    sole_forces.place(poses, carriers, local, points)
    expected = [moved[joint].act(row) for joint, row in zip(carriers, local, strict=True)]
    assert points == pytest.approx(np.array(expected), abs=1e-14)


def test_the_jacobian_of_a_point_is_pinocchios(random):
    model = robot().pin_model
    data, q = model.createData(), pin.randomConfiguration(model, -np.ones(52), np.ones(52))
    pin.computeJointJacobians(model, data, q)
    frame = robot().frame_id("r_contact_5")
    pin.updateFramePlacement(model, data, frame)
    expected = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
    carried, found = expected[:, :COLUMNS].any(axis=0), np.zeros((3, COLUMNS))
    sole_forces.point_jacobian(data.oMf[frame].translation, data.J, carried, found)
    assert found == pytest.approx(expected[:, :COLUMNS], abs=1e-13)


def test_contact_adds_its_mass_and_force_at_every_axis_that_holds(random):
    contact, matrix, right_side = Contact(random), np.zeros((51, 51), order="F"), np.zeros(51)
    contact.add_to(3.0, matrix, right_side)
    gain = 3.0 * np.column_stack((contact.sticking, contact.sticking, contact.pressing))
    start = np.where(gain > 0.0, contact.trial, 0.0)
    start[contact.slipping, :2] = contact.slip[contact.slipping]
    expected = np.einsum("pai,pa,paj->ij", contact.jacobian, gain, contact.jacobian)
    assert matrix[:COLUMNS, :COLUMNS] == pytest.approx(np.triu(expected), abs=1e-12)
    assert not matrix[COLUMNS:].any() and not matrix[:, COLUMNS:].any()
    expected = np.einsum("pai,pa->i", contact.jacobian, start)
    assert right_side == pytest.approx(np.r_[expected, np.zeros(31)], abs=1e-12)


def test_forces_follow_the_acceleration_and_states_stay_if_they_fit(random):
    contact = Contact(random)
    contact.sticking[:] = contact.pressing
    contact.trial[:, 2] = 100.0
    contact.add_to(0.1, np.zeros((51, 51), order="F"), np.zeros(51))
    states, acceleration = contact.pressing.copy(), random.normal(size=51)
    assert contact.finish(0.1, acceleration)
    change = contact.jacobian @ acceleration[:COLUMNS]
    expected = np.where(states[:, None], contact.trial - 0.1 * change, 0.0)
    assert contact.force == pytest.approx(expected, abs=1e-12)
    assert np.array_equal(contact.sticking, states)


def test_a_pulling_point_is_let_go_and_one_beyond_the_cone_slips(random):
    contact = Contact(random)
    contact.pressing[:], contact.sticking[:] = True, True
    contact.trial[:] = 0.0, 0.0, 100.0
    contact.trial[3, 2] = -5.0
    contact.trial[7, :2] = 60.0, -80.0
    contact.add_to(0.0, np.zeros((51, 51), order="F"), np.zeros(51))
    assert not contact.finish(0.0, np.zeros(51))
    assert np.flatnonzero(~contact.pressing).tolist() == [3]
    assert np.flatnonzero(contact.slipping).tolist() == [7]
    assert contact.slip[7] == pytest.approx([0.6 * FRICTION * 100.0, -0.8 * FRICTION * 100.0])


def test_points_land_where_they_touch_and_their_trial_is_a_spring_and_a_damper(random):
    points = random.normal(size=(POINTS, 3))
    points[:, 2] = -1e-3
    points[4:, 2] = 0.01
    twists, velocity = np.asfortranarray(random.normal(size=(6, 51))), 0.01 * random.normal(size=51)
    carries, below = np.ones((POINTS, COLUMNS), dtype=bool), np.zeros(POINTS, dtype=bool)
    at_origin, carriers, placed = np.eye(4, 3)[np.newaxis], np.zeros(POINTS, dtype=int), np.zeros((POINTS, 3))
    below[0] = True  # lay on the ground already, 1 mm from its anchor
    anchor = points + np.array([0.001, 0.0, 0.0])
    jacobian, rate, trial = np.zeros((POINTS, 3, COLUMNS)), np.zeros((POINTS, 3)), np.zeros((POINTS, 3))
    slip, pressing, sticking = np.zeros((POINTS, 2)), below.copy(), below.copy()
    touching = sole_forces.begin(
        at_origin, carriers, points, twists, carries, velocity, STIFFNESS, 100.0, FRICTION, placed, below,
        anchor, jacobian, rate, trial, slip, pressing, sticking,
    )  # fmt: skip
    assert np.array_equal(placed, points)
    assert touching and np.flatnonzero(below).tolist() == [0, 1, 2, 3]
    assert np.array_equal(anchor[1:4], points[1:4])
    twist = twists[:, :COLUMNS] @ velocity[:COLUMNS]
    expected = twist[:3] + np.cross(twist[3:], points[:4])
    assert rate[:4] == pytest.approx(expected, abs=1e-13)
    spring = np.zeros((4, 3))
    spring[:, 2], spring[0, 0] = STIFFNESS * 1e-3, STIFFNESS * 0.001
    assert trial[:4] == pytest.approx(spring - 100.0 * expected, abs=1e-9)


def test_slipping_friction_lies_on_the_cone_along_the_spring():
    slip = np.zeros(2)
    sole_forces.slide(FRICTION, 50.0, -3.0, 4.0, slip)
    assert slip == pytest.approx([-0.6 * FRICTION * 50.0, 0.8 * FRICTION * 50.0])
    sole_forces.slide(FRICTION, -1.0, -3.0, 4.0, slip)
    assert not slip.any()


def test_clipping_brings_every_force_into_the_cone_and_leaves_those_inside(random):
    force = random.normal(size=(200, 3))
    clipped = force.copy()
    sole_forces.clip(FRICTION, clipped)
    pull = np.hypot(clipped[:, 0], clipped[:, 1])
    assert (clipped[:, 2] >= 0.0).all() and (pull <= FRICTION * clipped[:, 2] + 1e-15).all()
    inside = (force[:, 2] > 0.0) & (np.hypot(force[:, 0], force[:, 1]) < FRICTION * force[:, 2])
    assert inside.any() and np.array_equal(clipped[inside], force[inside])


def test_the_anchor_of_a_slipping_point_goes_where_the_spring_carries_its_friction(random):
    points, rate, change, force = random.normal(size=(4, POINTS, 3))
    contact, anchor = Contact(random), np.zeros((POINTS, 3))
    sole_forces.follow(
        points, rate, change, force, contact.pressing, contact.sticking, STEP, STIFFNESS, anchor
    )
    end = points + STEP * rate + STEP**2 * change
    slipping = contact.slipping
    assert (-STIFFNESS * (end - anchor))[slipping, :2] == pytest.approx(force[slipping, :2], rel=1e-9)
    assert not anchor[~slipping].any() and not anchor[:, 2].any()


def test_wrenches_of_the_feet_are_sums_over_their_points(random):
    points, force = random.normal(size=(2, POINTS, 3))
    feet = np.ones((2, 6))
    sole_forces.add_wrenches(points, force, feet)
    rows = np.hstack((force, np.cross(points, force)))
    assert feet - 1.0 == pytest.approx(np.array([rows[:6].sum(axis=0), rows[6:].sum(axis=0)]), abs=1e-14)
