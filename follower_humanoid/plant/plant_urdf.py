"""The URDF as the plant uses it: only what has mass, own mass errors, joints without Bullet's limits.

A link without `<inertial>` (our frames) becomes 1 kg in PyBullet, so frames are left out there;
Pinocchio keeps them. Bullet's joint limits are constraints of its own making: our stops replace them.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass

import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Side


@dataclass(frozen=True)
class BodyErrorConfig:
    """How the plant's body differs from the model that the controllers know."""

    mass_scale: float = parameter(1.0, "factor on every mass and inertia", "", 0.5, 2.0)
    left_hand_load: float = parameter(0.0, "mass fixed to the left gripper", "kg", 0.0, 30.0)
    right_hand_load: float = parameter(0.0, "mass fixed to the right gripper", "kg", 0.0, 30.0)

    def hand_load(self, side: Side) -> float:
        """Mass at one gripper [kg]."""
        return self.left_hand_load if side is Side.LEFT else self.right_hand_load


# A load is a solid ball: its radius only matters for the inertia about its own centre.
LOAD_RADIUS = 0.05


def _scaled(root: ET.Element, factor: float) -> None:
    if factor == 1.0:
        return
    for inertial in root.iter("inertial"):
        for tag in ("mass", "inertia"):
            for element in inertial.iter(tag):
                for key, value in element.attrib.items():
                    element.set(key, repr(float(value) * factor))


def _loaded(root: ET.Element, side: Side, mass: float) -> None:
    """Fixes a ball to the gripper frame: an inertial on the frame's massless link."""
    if mass == 0.0:
        return
    for link in root.findall("link"):
        if link.get("name") == f"{side.prefix}_gripper":
            inertial = ET.SubElement(link, "inertial")
            ET.SubElement(inertial, "mass", value=repr(mass))
            moment = repr(0.4 * mass * LOAD_RADIUS**2)
            ET.SubElement(
                inertial, "inertia", ixx=moment, iyy=moment, izz=moment, ixy="0", ixz="0", iyz="0"
            )


def plant_body(urdf: str, errors: BodyErrorConfig) -> str:
    """URDF with the plant's own masses, for Pinocchio."""
    root = ET.fromstring(urdf)
    _scaled(root, errors.mass_scale)
    for side in SIDES:
        _loaded(root, side, errors.hand_load(side))
    return ET.tostring(root, encoding="unicode")


def _vector(element: ET.Element | None, key: str, default: str) -> list[float]:
    text = default if element is None else element.get(key, default)
    return [float(word) for word in text.split()]


def _freeze(joint: ET.Element, angle: float) -> None:
    """Makes a revolute joint a fixed one that stands at an angle [rad]."""
    axis, origin = _vector(joint.find("axis"), "xyz", "1 0 0"), joint.find("origin")
    if origin is None:
        origin = ET.SubElement(joint, "origin")
    turned = pin.rpy.rpyToMatrix(*_vector(origin, "rpy", "0 0 0"))
    length = math.sqrt(sum(x * x for x in axis))
    half = math.sin(angle / 2) / length
    turn = pin.Quaternion(math.cos(angle / 2), *(half * x for x in axis)).toRotationMatrix()
    origin.set("rpy", " ".join(repr(float(x)) for x in pin.rpy.matrixToRpy(turned @ turn)))
    joint.set("type", "fixed")


def bullet_body(urdf: str, held: Mapping[str, float] | None = None) -> str:
    """URDF for PyBullet: massless links, visuals, feet's collision shapes and joint limits left out.

    Args:
        urdf: The plant's own body.
        held: Joints that do not move, and the angle at which each stands [rad].
    """
    held = held or {}
    root = copy.deepcopy(ET.fromstring(urdf))
    massless = {link.get("name") for link in root.findall("link") if link.find("inertial") is None}
    feet = set()
    for joint in list(root.findall("joint")):
        child, parent = joint.find("child"), joint.find("parent")
        if child is not None and parent is not None and child.get("link") in massless:
            if "_contact_" in str(child.get("link")):
                feet.add(parent.get("link"))
            root.remove(joint)
        elif str(joint.get("name")) in held:
            _freeze(joint, held[str(joint.get("name"))])
        elif joint.get("type") == "revolute":
            joint.set("type", "continuous")
    for link in list(root.findall("link")):
        if link.get("name") in massless:
            root.remove(link)
            continue
        unwanted = link.findall("visual")
        if link.get("name") in feet:
            unwanted += link.findall("collision")
        for element in unwanted:
            link.remove(element)
    # PyBullet fails on a long document without line breaks.
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")
