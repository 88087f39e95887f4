"""Read the URDF text that mecanique writes, welding the links of fixed joints."""

from __future__ import annotations

from collections import defaultdict
from typing import cast
from xml.etree import ElementTree

import numpy as np

from mecanique.arrays import Array
from mecanique.reference.standin.model import Frame, Joint, Kind, Model
from mecanique.reference.standin.spatial import SE3, Inertia


def buildModelFromXML(text: str) -> Model:
    """Return the tree of a URDF text.

    Args:
        text: as `write_urdf` writes it.
    """
    # safe: only text written by mecanique is parsed here
    robot = ElementTree.fromstring(text)
    behind = defaultdict(list)
    children = set()
    for joint in robot.findall("joint"):
        behind[_name(joint, "parent")].append(joint)
        children.add(_name(joint, "child"))
    links = {link.get("name", ""): link for link in robot.findall("link")}
    (root,) = links.keys() - children
    model = Model()
    waiting = [(root, 0, SE3(np.eye(3), np.zeros(3)))]
    while waiting:
        name, holder, placement = waiting.pop()
        model.frames.append(Frame(name, holder, placement))
        if holder:
            model.inertias[holder] += placement.act(_inertia(links[name]))
        for joint in reversed(behind[name]):
            at = placement * _origin(joint)
            kind = joint.get("type", "")
            child = _name(joint, "child")
            if kind == "fixed":
                waiting.append((child, holder, at))
                continue
            moving = Joint(cast(Kind, kind), _axis(joint))
            index = model.addJoint(holder, moving, at, joint.get("name", ""))
            waiting.append((child, index, SE3(np.eye(3), np.zeros(3))))
    return model


def _name(joint: ElementTree.Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else found.get("link", "")


def _vector(text: str | None, default: str) -> Array:
    return np.array([float(part) for part in (text or default).split()])


def _axis(joint: ElementTree.Element) -> Array:
    found = joint.find("axis")
    axis = _vector(None if found is None else found.get("xyz"), "1 0 0")
    return np.asarray(axis / np.linalg.norm(axis))


def _origin(element: ElementTree.Element) -> SE3:
    found = element.find("origin")
    if found is None:
        return SE3(np.eye(3), np.zeros(3))
    roll, pitch, yaw = _vector(found.get("rpy"), "0 0 0")
    cx, cy, cz = np.cos([roll, pitch, yaw])
    sx, sy, sz = np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return SE3(about_z @ about_y @ about_x, _vector(found.get("xyz"), "0 0 0"))


def _inertia(link: ElementTree.Element) -> Inertia:
    inertial = link.find("inertial")
    if inertial is None:
        return Inertia.Zero()
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    value = 0.0 if mass is None else float(mass.get("value", "0"))

    def entry(name: str) -> float:
        return 0.0 if tensor is None else float(tensor.get(name, "0"))

    xy, xz, yz = entry("ixy"), entry("ixz"), entry("iyz")
    rows = [[entry("ixx"), xy, xz], [xy, entry("iyy"), yz], [xz, yz, entry("izz")]]
    about: Inertia = _origin(inertial).act(Inertia(value, np.zeros(3), np.array(rows)))
    return about
