"""How elements hold a mechanism on its coordinate map: the sizes of their forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.reference.engine.forces.elements import Columns, Unit

__all__ = ["Held", "hold"]

_RANK = 1e-9
_LOOSE = 1e-8
"""Shares of a force in those that balance one another below this count as none."""


class Held(NamedTuple):
    """What elements do in one state.

    Args:
        forces: shape (k,), of the elements [N or N·m].
        reactions: shape (joints, 2, 3), what the joints transmit.
        loose: shape (joints, 6), which components of these redundant elements leave undetermined.
        actions: on the bodies, with the sizes of the forces, shape (units, 3, 3): points, forces,
            moments.
        unknown: shape (k,), which forces redundant elements leave undetermined.
    """

    forces: Array
    reactions: Array
    loose: npt.NDArray[np.bool_]
    actions: Array
    unknown: npt.NDArray[np.bool_]


def hold(columns: Columns, demand: Array, units: list[Unit], carried: Array, totals: Array) -> Held:
    """Return what elements do, of all possibilities the least.

    Args:
        columns: the unknown forces along the joints.
        demand: shape (nu,), what they leave open in all.
        units: what unit forces do to the bodies.
        carried: shape (2, k, joints, 2, 3), what the joints transmit under unit forces, and under
            what goes with their magnitudes.
        totals: shape (joints, 2, 3), what crosses the joints in all.
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
