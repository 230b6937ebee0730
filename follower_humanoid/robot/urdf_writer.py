"""Writes the body table as URDF: `python -m follower_humanoid.robot.urdf_writer urdf/follower.urdf`."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

from follower_humanoid.robot.body_table import CLOTH, DARK, LIGHT, SKIN, Body, Link, Shape, follower_body

COLORS = {
    SKIN: (0.86, 0.68, 0.57, 1.0),
    CLOTH: (0.23, 0.42, 0.62, 1.0),
    DARK: (0.22, 0.25, 0.31, 1.0),
    LIGHT: (0.93, 0.93, 0.91, 1.0),
}
# Limits that URDF demands; the motors' own limits (voltage, back-EMF) are what acts.
EFFORT_LIMIT, VELOCITY_LIMIT = 400.0, 12.0


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.10g}" for value in values)


def _shape_elements(parent: ET.Element, tag: str, shape: Shape) -> None:
    element = ET.SubElement(parent, tag)
    ET.SubElement(element, "origin", xyz=_numbers(shape.center), rpy="0 0 0")
    geometry = ET.SubElement(element, "geometry")
    if shape.kind == "box":
        ET.SubElement(geometry, "box", size=_numbers(shape.size))
    elif shape.kind == "cylinder":
        ET.SubElement(geometry, "cylinder", radius=f"{shape.size[0]:.10g}", length=f"{shape.size[1]:.10g}")
    else:
        ET.SubElement(geometry, "sphere", radius=f"{shape.size[0]:.10g}")
    if tag == "visual":
        ET.SubElement(element, "material", name=shape.color)


def _link_element(root: ET.Element, link: Link) -> None:
    element = ET.SubElement(root, "link", name=link.name)
    inertial = ET.SubElement(element, "inertial")
    ET.SubElement(inertial, "origin", xyz=_numbers(link.center), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{link.mass:.10g}")
    xx, yy, zz = (f"{value:.10g}" for value in link.inertia)
    ET.SubElement(inertial, "inertia", ixx=xx, ixy="0", ixz="0", iyy=yy, iyz="0", izz=zz)
    for shape in link.shapes:
        _shape_elements(element, "visual", shape)
    for shape in link.shapes:
        if shape.solid:
            _shape_elements(element, "collision", shape)


def urdf_text(body: Body) -> str:
    """The table as URDF, one element a line."""
    root = ET.Element("robot", name="follower")
    for name, rgba in COLORS.items():
        material = ET.SubElement(root, "material", name=name)
        ET.SubElement(material, "color", rgba=_numbers(rgba))
    for link in body.links:
        _link_element(root, link)
    for joint in body.joints:
        element = ET.SubElement(root, "joint", name=joint.name, type="revolute")
        ET.SubElement(element, "origin", xyz=_numbers(joint.origin), rpy="0 0 0")
        ET.SubElement(element, "parent", link=joint.parent)
        ET.SubElement(element, "child", link=joint.child)
        ET.SubElement(element, "axis", xyz=_numbers(joint.axis))
        ET.SubElement(
            element, "limit", lower=f"{joint.lower:.10g}", upper=f"{joint.upper:.10g}",
            effort=f"{EFFORT_LIMIT:.10g}", velocity=f"{VELOCITY_LIMIT:.10g}",
        )  # fmt: skip
    for frame in body.frames:
        ET.SubElement(root, "link", name=frame.name)
        element = ET.SubElement(root, "joint", name=f"{frame.name}_fixed", type="fixed")
        ET.SubElement(element, "origin", xyz=_numbers(frame.origin), rpy="0 0 0")
        ET.SubElement(element, "parent", link=frame.parent)
        ET.SubElement(element, "child", link=frame.name)
    ET.indent(root)
    header = "<!-- Generated from follower_humanoid/robot/body_table.py; edit that table, not this file. -->"
    return f'<?xml version="1.0"?>\n{header}\n{ET.tostring(root, encoding="unicode")}\n'


def main() -> None:
    """Writes to the path given on the command line."""
    if len(sys.argv) != 2:
        sys.exit("usage: python -m follower_humanoid.robot.urdf_writer OUTPUT.urdf")
    Path(sys.argv[1]).write_text(urdf_text(follower_body()), encoding="utf-8")


if __name__ == "__main__":
    main()
