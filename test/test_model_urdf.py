"""The model: URDF from the table, contract frames, masses and inertias, left and right alike."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest

from follower_humanoid.core.samples import SIDES
from follower_humanoid.resources import share_path
from follower_humanoid.robot.body_table import follower_body
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.robot.urdf_writer import urdf_text

CONTRACT_FRAMES = (
    ["base_link", "torso", "gaze"]
    + [f"{p}_{name}" for p in "lr" for name in ("wrist", "gripper", "ankle", "sole", "toe")]
    + [f"{p}_contact_{n}" for p in "lr" for n in range(1, 7)]
)


@pytest.fixture(scope="module")
def robot():
    return RobotModel()


def test_urdf_is_what_the_table_says():
    written = share_path("urdf/follower.urdf").read_text(encoding="utf-8")
    assert written == urdf_text(follower_body())


def test_has_51_degrees_of_freedom(robot):
    assert robot.pin_model.nv == 51
    assert len(robot.joint_names) == 45
    groups = robot.groups
    sizes = [len(g) for g in (groups.left_leg, groups.right_leg, groups.left_arm, groups.right_arm)]
    assert sizes == [7, 7, 7, 7]
    assert len(groups.trunk) == 15
    assert len(groups.neck) == 2
    driven = np.concatenate((groups.legs, groups.arms))
    assert sorted(driven) == list(range(45))


@pytest.mark.parametrize("name", CONTRACT_FRAMES)
def test_contract_frame_exists(robot, name):
    assert robot.pin_model.existFrame(name)
    assert name in {link.get("name") for link in ET.fromstring(robot.urdf).findall("link")}


def test_masses_add_up(robot):
    assert robot.mass == pytest.approx(73.0, rel=0.02)


def test_stands_175_cm_tall(robot):
    data = robot.pin_model.createData()
    pin.framesForwardKinematics(robot.pin_model, data, pin.neutral(robot.pin_model))
    head = data.oMf[robot.frame_id("head")].translation[2] + 0.155 + 0.105  # centre and radius of the skull
    sole = data.oMf[robot.frame_id("l_sole")].translation[2]
    assert head - sole == pytest.approx(1.75, abs=0.06)


def test_inertias_are_those_of_solid_bodies():
    for link in follower_body().links:
        xx, yy, zz = link.inertia
        assert min(xx, yy, zz) > 0.0, link.name
        # Twice the largest moment never exceeds the sum: PyBullet zeroes inertias that break this.
        assert 2 * max(xx, yy, zz) <= xx + yy + zz + 1e-12, link.name
        assert link.mass >= 0.1, link.name
        assert min(xx, yy, zz) >= 2e-5, link.name


def test_contact_points_lie_on_the_sole_plane(robot):
    data = robot.pin_model.createData()
    pin.framesForwardKinematics(robot.pin_model, data, pin.neutral(robot.pin_model))
    for side in SIDES:
        sole = data.oMf[robot.frame_id(f"{side.prefix}_sole")]
        ankle = data.oMf[robot.frame_id(f"{side.prefix}_ankle")]
        assert sole.translation[:2] == pytest.approx(ankle.translation[:2])
        for n in range(1, 7):
            point = data.oMf[robot.frame_id(f"{side.prefix}_contact_{n}")]
            assert point.translation[2] == pytest.approx(sole.translation[2], abs=1e-12)


def mirrored(robot, vector):
    """The 45 joint values of the mirror image: sides swapped, roll and yaw reversed."""
    result = np.empty(45)
    for index, name in enumerate(robot.joint_names):
        twin = {"l_": "r_", "r_": "l_"}.get(name[:2], name[:2]) + name[2:]
        axis = name.rsplit("_", 1)[-1]
        sign = 1.0 if axis in ("pitch", "knee", "elbow") else -1.0
        result[robot.joint_index(twin)] = sign * vector[index]
    return result


BASE_MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # y, roll and yaw change sign


@pytest.mark.parametrize("seed", range(5))
def test_mirror_image_moves_as_the_mirror_image(robot, seed):
    random = np.random.default_rng(seed)
    joints, rates, torques = random.uniform(-0.8, 0.8, 45), random.normal(0, 2, 45), random.normal(0, 20, 45)
    place, turn, twist = random.normal(0, 1, 3), random.normal(0, 0.8, 3), random.normal(0, 1, 6)

    def accelerations(mirror):
        sign = BASE_MIRROR if mirror else np.ones(6)
        swap = (lambda x: mirrored(robot, x)) if mirror else (lambda x: x)
        quat = pin.Quaternion(pin.exp3(turn * sign[3:])).coeffs()
        q = np.concatenate((place * sign[:3], quat, swap(joints)))
        v = np.concatenate((twist * sign, swap(rates)))
        data = robot.pin_model.createData()
        return pin.aba(robot.pin_model, data, q, v, np.concatenate((np.zeros(6), swap(torques))))

    plain, image = accelerations(False), accelerations(True)
    assert image[:6] == pytest.approx(BASE_MIRROR * plain[:6], rel=1e-8, abs=1e-8)
    assert image[6:] == pytest.approx(mirrored(robot, plain[6:]), rel=1e-8, abs=1e-6)


def test_joint_ranges_are_mirrored(robot):
    low, high = mirrored(robot, robot.lower), mirrored(robot, robot.upper)
    assert np.minimum(low, high) == pytest.approx(robot.lower)
    assert np.maximum(low, high) == pytest.approx(robot.upper)
    assert np.all(robot.lower < robot.upper)
