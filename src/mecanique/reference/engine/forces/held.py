"""Solve for the forces by which elements hold a mechanism on its coordinate map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.reference.engine.forces.elements import Columns, Unit

_RANK = 1e-9
_LOOSE = 1e-8
"""Components below this of self-balancing sets of unit forces count as zero."""


class Held(NamedTuple):
    """The forces of the elements in one state, and the reactions that remain.

    Args:
        forces: shape (k,), the elements' forces [N or N·m].
        reactions: shape (joints, 2, 3), reactions of the joints.
        loose: shape (joints, 6), whether redundant elements leave a component undetermined.
        actions: shape (units, 3, 3), point, force and moment of each action on a body.
        unknown: shape (k,), whether redundant elements leave a force undetermined.
    """

    forces: Array
    reactions: Array
    loose: npt.NDArray[np.bool_]
    actions: Array
    unknown: npt.NDArray[np.bool_]


def hold(columns: Columns, demand: Array, units: list[Unit], carried: Array, totals: Array) -> Held:
    """Solve for the elements' forces; if several sets are possible, take the least.

    Args:
        columns: the unknown forces along the joints.
        demand: shape (nu,), their required sum along the joint velocities.
        units: the actions of unit forces on the bodies.
        carried: shape (2, k, joints, 2, 3), wrenches of the joints under unit forces, and under
            the forces that grow with their magnitudes.
        totals: shape (joints, 2, 3), total wrenches across the joints.
    """
    carried, pressed = carried
    count = len(carried)
    _, sizes, right = np.linalg.svd(columns.matrix)
    rank = int((sizes > _RANK * sizes.max(initial=_RANK)).sum())
    found = np.linalg.pinv(columns.matrix, rcond=_RANK) @ np.concatenate(
        [-columns.scale * demand, columns.stated]
    )
    forces = found[:count]
    idle = right[rank:, :count]
    reactions = totals + np.einsum("k,kjab->jab", forces, carried)
    reactions += np.einsum("k,kjab->jab", np.abs(forces), pressed)
    spread = np.einsum("ik,kjab->ijab", idle, carried).reshape(len(idle), len(totals), 6)
    loose = (np.abs(spread) > _LOOSE).any(axis=0)
    unknown = (np.abs(idle) > _LOOSE).any(axis=0)
    pushes = []
    for unit in units:
        size = abs(forces[unit.force]) if unit.pressed else forces[unit.force]
        pushes.append(size * np.array([unit.action.force, unit.action.torque]))
    points = np.array([unit.action.point for unit in units]).reshape(-1, 1, 3)
    actions = np.concatenate([points, np.array(pushes).reshape(-1, 2, 3)], axis=1)
    return Held(forces, reactions, loose, actions, unknown)
