"""Build a robot of its file in Exudyn, which reads no URDF by itself, and evaluate it there.

The file is walked in a few lines of its own, so that neither the reader of this package nor that of
another engine has a part in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final
from xml.etree.ElementTree import Element

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.reference.originals.original import ByJoint, Original, columns
from mecanique.safe_xml import XmlRefusedError, tree_of

_AXIAL = {"revolute": "RevoluteZ", "continuous": "RevoluteZ", "prismatic": "PrismaticZ"}
"""Exudyn's joints move along or about z."""


@final
@dataclass
class _Part:
    """What moves as one: rigid links that a joint carries."""

    parent: int
    kind: str
    pose: Array  # of its frame, whose z is the joint's axis, in that of its parent
    mass: float
    first: Array  # Σ m c
    second: Array  # inertia about the frame's origin


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Build a robot of its file in Exudyn and evaluate it in n states, its root fixed.

    Args:
        text: the file's text.
        gravity: shape (3,) [m/s²].
        q: positions of joints.
        v: velocities of joints.

    Raises:
        EngineError: if the file is no URDF, or has a joint of another kind.
    """
    names, parts = _parts_of(text)
    if not parts:
        return Original((), np.zeros((1, 0, 0)), np.zeros((1, 0)), ())
    import exudyn

    size = len(parts)
    system = exudyn.SystemContainer().AddSystem()
    zeros = [0.0] * size
    node = system.AddNode(
        {
            "nodeType": "GenericODE2",
            "referenceCoordinates": zeros,
            "initialCoordinates": zeros,
            "initialCoordinates_t": zeros,
            "numberOfODE2Coordinates": size,
        }
    )
    system.AddObject(_tree(exudyn, node, parts, gravity))
    system.Assemble()
    solver, settings = exudyn.MainSolverImplicitSecondOrder(), exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    solver.InitializeSolver(system, settings)
    masses, biases = [], []
    for place, speed in zip(columns(q, names), columns(v, names), strict=True):
        system.systemData.SetODE2Coordinates(place.tolist())
        system.systemData.SetODE2Coordinates_t(speed.tolist())
        solver.ComputeMassMatrix(system)
        solver.ComputeODE2RHS(system)
        masses.append(np.array(solver.GetSystemMassMatrix()))
        biases.append(-np.array(solver.GetSystemResidual())[:size])
    return Original(names, np.array(masses), np.array(biases), ())


def _tree(exudyn: Any, node: Any, parts: Sequence[_Part], gravity: Sequence[float]) -> Any:
    centers, inertias = [], []
    for part in parts:
        center = part.first / part.mass if part.mass else np.zeros(3)
        shift = (center @ center) * np.eye(3) - np.outer(center, center)
        centers.append(center)
        inertias.append(part.second - part.mass * shift)
    return {
        "objectType": "KinematicTree",
        "nodeNumber": node,
        "jointTypes": [getattr(exudyn.JointType, _AXIAL[part.kind]) for part in parts],
        "linkParents": [part.parent for part in parts],
        "jointTransformations": exudyn.Matrix3DList([part.pose[:3, :3] for part in parts]),
        "jointOffsets": exudyn.Vector3DList([part.pose[:3, 3] for part in parts]),
        "linkInertiasCOM": exudyn.Matrix3DList(inertias),
        "linkCOMs": exudyn.Vector3DList(centers),
        "linkMasses": [part.mass for part in parts],
        "gravity": list(gravity),
    }


def _parts_of(text: bytes) -> tuple[tuple[str, ...], list[_Part]]:
    """Return the names of the joints with a coordinate, and what each carries."""
    try:
        robot = tree_of(text)
    except XmlRefusedError as error:
        raise EngineError(f"line {error.line}: {error}") from None
    if robot.tag != "robot":
        raise EngineError(f"it is built of URDF alone, not of <{robot.tag}>")
    joints: dict[str, list[Element]] = {}
    for joint in robot.findall("joint"):
        joints.setdefault(_ends(joint)[0], []).append(joint)
    links = {link.get("name", ""): link for link in robot.findall("link")}
    carried = {_ends(joint)[1] for joint in robot.findall("joint")}
    names: list[str] = []
    parts: list[_Part] = []
    # each link with the part that it belongs to, and its pose in that part's frame
    waiting = [(name, -1, np.eye(4)) for name in links if name not in carried]
    while waiting:
        name, part, pose = waiting.pop(0)
        if part >= 0:
            _add(parts[part], links[name], pose)
        for joint in joints.get(name, ()):
            kind, place = joint.get("type", ""), pose @ _origin(joint)
            child = _ends(joint)[1]
            if kind == "fixed":
                waiting.append((child, part, place))
                continue
            if kind not in _AXIAL:
                raise EngineError(f"its trees have no joint of type {kind!r}")
            turn = _to_axis(_numbers(joint.find("axis"), "xyz", (1.0, 0.0, 0.0)))
            names.append(joint.get("name", ""))
            zero = np.zeros((3, 3))
            parts.append(_Part(part, kind, place @ turn, 0.0, np.zeros(3), zero))
            waiting.append((child, len(parts) - 1, turn.T))
    return tuple(names), parts


def _add(part: _Part, link: Element, pose: Array) -> None:
    """Add the mass of a link to the part that it belongs to."""
    inertial = link.find("inertial")
    if inertial is None:
        return
    place = pose @ _origin(inertial)
    mass = float(_numbers(inertial.find("mass"), "value", (0.0,))[0])
    tags = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    stated = inertial.find("inertia")
    xx, xy, xz, yy, yz, zz = (float(_numbers(stated, tag, (0.0,))[0]) for tag in tags)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    turn, center = place[:3, :3], place[:3, 3]
    part.mass += mass
    part.first += mass * center
    part.second += turn @ inertia @ turn.T
    part.second += mass * ((center @ center) * np.eye(3) - np.outer(center, center))


def _ends(joint: Element) -> tuple[str, str]:
    parent, child = (joint.find(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        raise EngineError(f"joint {joint.get('name')!r} has no parent or no child")
    return parent.get("link", ""), child.get("link", "")


def _origin(element: Element) -> Array:
    """The pose of <origin>: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    origin, pose = element.find("origin"), np.eye(4)
    roll, pitch, yaw = _numbers(origin, "rpy", (0.0, 0.0, 0.0))
    for axis, angle in ((2, yaw), (1, pitch), (0, roll)):
        step, (i, k) = np.eye(3), ((axis + 1) % 3, (axis + 2) % 3)
        step[i, i] = step[k, k] = math.cos(angle)
        step[k, i], step[i, k] = math.sin(angle), -math.sin(angle)
        pose[:3, :3] = pose[:3, :3] @ step
    pose[:3, 3] = _numbers(origin, "xyz", (0.0, 0.0, 0.0))
    return pose


def _to_axis(axis: Array) -> Array:
    """A turn that takes z to an axis, as a pose."""
    z = axis / np.linalg.norm(axis)
    across = np.eye(3)[np.argmin(np.abs(z))]
    x = np.cross(across, z) / np.linalg.norm(np.cross(across, z))
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return pose


def _numbers(element: Element | None, name: str, default: Sequence[float]) -> Array:
    text = None if element is None else element.get(name)
    try:
        values = np.array([float(word) for word in text.split()] if text else default)
    except ValueError:
        values = np.zeros(0)
    if len(values) != len(default) or not np.isfinite(values).all():
        raise EngineError(f"expected {len(default)} numbers for {name}, got {text!r}")
    return values
