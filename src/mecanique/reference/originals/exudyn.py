"""Build a robot of its file in Exudyn, which reads no URDF by itself, and evaluate it there.

The file is walked by the reader of the stand-in, which has no part in any other engine here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.reference.originals.original import ByJoint, Original, columns
from mecanique.reference.standin import Model, tree_of_robot
from mecanique.safe_xml import XmlRefusedError, tree_of

_AXIAL = {"revolute": "RevoluteZ", "continuous": "RevoluteZ", "prismatic": "PrismaticZ"}
"""Exudyn's joints move along or about z."""


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
    model, kinds = _model_of(text)
    names, size = tuple(model.names[1:]), model.nv
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
    system.AddObject(_tree(exudyn, node, model, kinds, gravity))
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


def _tree(
    exudyn: Any, node: Any, model: Model, kinds: Sequence[str], gravity: Sequence[float]
) -> Any:
    # each joint's frame is turned so that z is its axis
    turns = [np.eye(3), *(_to_axis(joint.axis) for joint in model.joints[1:])]
    seats, parents = model.jointPlacements, model.parents
    bodies = range(1, model.njoints)
    return {
        "objectType": "KinematicTree",
        "nodeNumber": node,
        "jointTypes": [getattr(exudyn.JointType, kind) for kind in kinds],
        "linkParents": [parents[k] - 1 for k in bodies],
        "jointTransformations": exudyn.Matrix3DList(
            [turns[parents[k]].T @ seats[k].rotation @ turns[k] for k in bodies]
        ),
        "jointOffsets": exudyn.Vector3DList(
            [turns[parents[k]].T @ seats[k].translation for k in bodies]
        ),
        "linkInertiasCOM": exudyn.Matrix3DList(
            [turns[k].T @ model.inertias[k].inertia @ turns[k] for k in bodies]
        ),
        "linkCOMs": exudyn.Vector3DList([turns[k].T @ model.inertias[k].lever for k in bodies]),
        "linkMasses": [model.inertias[k].mass for k in bodies],
        "gravity": list(gravity),
    }


def _model_of(text: bytes) -> tuple[Model, list[str]]:
    """Return the tree of a file, and Exudyn's types of its joints."""
    try:
        robot = tree_of(text)
    except XmlRefusedError as error:
        raise EngineError(f"line {error.line}: {error}") from None
    if robot.tag != "robot":
        raise EngineError(f"it is built of URDF alone, not of <{robot.tag}>")
    try:
        model = tree_of_robot(robot)
        kinds = [_AXIAL[joint.kind] for joint in model.joints[1:]]
    except ValueError as error:
        raise EngineError(str(error)) from None
    except KeyError as error:
        raise EngineError(f"its trees have no joint of type {error}") from None
    return model, kinds


def _to_axis(axis: Array) -> Array:
    """A turn that takes z to an axis."""
    across = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(across, axis) / np.linalg.norm(np.cross(across, axis))
    return np.column_stack([x, np.cross(axis, x), axis])
