"""Build a robot of its file in Exudyn, which reads no URDF by itself, and evaluate it there.

The file is walked by the reader of the stand-in, which has no part in any other engine here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.reference.originals.original import (
    ByJoint,
    EngineJoint,
    Original,
    evaluate,
    free_root_of,
    same,
    turning,
)
from mecanique.reference.standin import SE3, Inertia, Model, tree_of_robot
from mecanique.safe_xml import XmlRefusedError, tree_of

_TURN, _SLIDE = "RevoluteZ", "PrismaticZ"
"""Exudyn's joints move along or about z."""

_AXIAL = {"revolute": _TURN, "continuous": _TURN, "prismatic": _SLIDE}
_FREE = ((_SLIDE, 0), (_SLIDE, 1), (_SLIDE, 2), (_TURN, 0), (_TURN, 1), (_TURN, 2))
"""The joints that a floating one is a chain of, each with its axis."""


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Build a robot of its file in Exudyn and evaluate it in n states.

    A body that floats hangs on three slides and three hinges, with empty bodies between them.

    Args:
        text: the file's text.
        gravity: shape (3,) [m/s²].
        q: positions of joints.
        v: velocities of joints.

    Raises:
        EngineError: if the file is no URDF, or has a joint of another kind.
    """
    model = _model_of(text, free_root_of(text, v))
    axials, joints = _chains(model)
    size = len(axials)
    if not size:
        return Original((), np.zeros((1, 0, 0)), np.zeros((1, 0)), ())
    import exudyn

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
    system.AddObject(_tree(exudyn, node, axials, gravity))
    system.Assemble()
    solver, settings = exudyn.MainSolverImplicitSecondOrder(), exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    solver.InitializeSolver(system, settings)

    def answer(place: Array, speed: Array) -> tuple[Array, ...]:
        system.systemData.SetODE2Coordinates(place.tolist())
        system.systemData.SetODE2Coordinates_t(speed.tolist())
        solver.ComputeMassMatrix(system)
        solver.ComputeODE2RHS(system)
        mass = np.array(solver.GetSystemMassMatrix())
        return mass, -np.array(solver.GetSystemResidual())[:size]

    return evaluate(q, v, joints, np.zeros(size), answer)


class _Axial(NamedTuple):
    """A joint along or about an axis, with the body that it carries."""

    kind: str
    parent: int
    axis: Array
    placement: SE3
    inertia: Inertia


def _chains(model: Model) -> tuple[list[_Axial], list[EngineJoint]]:
    """Return a model's joints as joints with an axis each, and how they are counted."""
    axials: list[_Axial] = []
    joints: list[EngineJoint] = []
    last = [-1]
    for k, joint in enumerate(model.joints[1:], 1):
        if joint.kind == "floating":
            chain = [(kind, np.eye(3)[axis]) for kind, axis in _FREE]
        else:
            chain = [(_AXIAL[joint.kind], joint.axis)]
        at, parent, placement = len(axials), last[model.parents[k]], model.jointPlacements[k]
        if joint.kind == "floating":  # whose position is asked in the world
            placement = SE3(np.eye(3), np.zeros(3))
        for kind, axis in chain:
            axials.append(_Axial(kind, parent, axis, placement, Inertia.Zero()))
            parent, placement = len(axials) - 1, SE3(np.eye(3), np.zeros(3))
        axials[-1] = axials[-1]._replace(inertia=model.inertias[k])
        last.append(parent)
        what, chart = ("free", _free) if joint.kind == "floating" else ("single", same)
        joints.append(EngineJoint(model.names[k], slice(at, at + len(chain)), at, what, chart))
    return axials, joints


def _free(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Position, then angles about x, y and z, each axis turned by those before."""
    R, linear, drift = turning(q, v)
    a, b, c = np.arctan2(-R[1, 2], R[2, 2]), np.arcsin(R[0, 2]), np.arctan2(-R[0, 1], R[0, 0])
    sb, cb, sc, cc = np.sin(b), np.cos(b), np.sin(c), np.cos(c)
    spin = np.array([[cb * cc, sc, 0.0], [-cb * sc, cc, 0.0], [sb, 0.0, 1.0]])  # of their rates
    rates = np.linalg.solve(spin, v[3:])
    by_b = np.array([[-sb * cc, 0.0, 0.0], [sb * sc, 0.0, 0.0], [cb, 0.0, 0.0]])
    by_c = np.array([[-cb * sc, cc, 0.0], [-cb * cc, -sc, 0.0], [0.0, 0.0, 0.0]])
    turned = (by_b * rates[1] + by_c * rates[2]) @ rates
    T = np.vstack([linear, np.hstack([np.zeros((3, 3)), np.linalg.inv(spin)])])
    place = np.concatenate([q[:3], [a, b, c]])
    return place, T, np.append(drift, -np.linalg.solve(spin, turned))


def _tree(exudyn: Any, node: Any, axials: Sequence[_Axial], gravity: Sequence[float]) -> Any:
    # each joint's frame is turned so that z is its axis
    turns = [*(_to_axis(joint.axis) for joint in axials), np.eye(3)]  # the last of the world
    turned = [*zip(axials, turns, strict=False)]
    return {
        "objectType": "KinematicTree",
        "nodeNumber": node,
        "jointTypes": [getattr(exudyn.JointType, joint.kind) for joint in axials],
        "linkParents": [joint.parent for joint in axials],
        "jointTransformations": exudyn.Matrix3DList(
            [turns[joint.parent].T @ joint.placement.rotation @ turn for joint, turn in turned]
        ),
        "jointOffsets": exudyn.Vector3DList(
            [turns[joint.parent].T @ joint.placement.translation for joint in axials]
        ),
        "linkInertiasCOM": exudyn.Matrix3DList(
            [turn.T @ joint.inertia.inertia @ turn for joint, turn in turned]
        ),
        "linkCOMs": exudyn.Vector3DList([turn.T @ joint.inertia.lever for joint, turn in turned]),
        "linkMasses": [joint.inertia.mass for joint in axials],
        "gravity": list(gravity),
    }


def _model_of(text: bytes, free: str | None) -> Model:
    """Return the tree of a file, its root in a joint of that name if it moves freely."""
    try:
        robot = tree_of(text)
    except XmlRefusedError as error:
        raise EngineError(f"line {error.line}: {error}") from None
    if robot.tag != "robot":
        raise EngineError(f"it is built of URDF alone, not of <{robot.tag}>")
    if free is not None:
        # the root of a robot gets a floating joint
        children = {child.get("link") for child in robot.iterfind("joint/child")}
        links = [link.get("name", "") for link in robot.iterfind("link")]
        world = "_".join(["world", *links])  # a name that no link has
        ElementTree.SubElement(robot, "link", name=world)
        joint = ElementTree.SubElement(robot, "joint", name=free, type="floating")
        ElementTree.SubElement(joint, "parent", link=world)
        roots = [link for link in links if link not in children]
        ElementTree.SubElement(joint, "child", link=roots[0] if roots else "")
    try:
        model = tree_of_robot(robot)
    except ValueError as error:
        raise EngineError(str(error)) from None
    except KeyError as error:
        raise EngineError(f"its trees have no joint of type {error}") from None
    return model


def _to_axis(axis: Array) -> Array:
    """A turn that takes z to an axis."""
    across = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(across, axis) / np.linalg.norm(np.cross(across, axis))
    return np.column_stack([x, np.cross(axis, x), axis])
