"""The forces of the elements that guide, on batched floats, from what joints cannot transmit.

What crosses the joints in all, totals T_k, is known from the balances of the bodies. The reaction
in joint k is R_k = T_k + Σ f_j S_kj, where S_kj balances the unit forces j on all that hangs on the
joint. A joint transmits nothing along or about its own directions n, so that for each of them

    n·T_k + armature u' + Σ f_j n·S_kj + (what holds the joint itself) = 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.derivation.numeric.free_bodies import Snapshot
from mecanique.derivation.tree.elements import Ground, UnitForce, unit_forces
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.model.expression import Scalar
from mecanique.model.guides.guide import Guide
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import characteristic_length

__all__ = ["Along", "Sizes", "find_unexplained", "size", "unit_needs"]

_RANK = 1e-9
_EXPLAINED = 1e-6
"""What elements leave of a guide's unit forces, where they describe it."""

_SHARE = 1e-8
"""Shares of a force in those that balance one another below this count as none."""


@final
@dataclass(frozen=True, eq=False)
class Along:
    """What acts along the joint velocities.

    Args:
        forces: shape (n, nu, k), of unit forces of the elements.
        rates: shape (n, nu, nv), joint velocities by generalized velocity.
        joints: which joint each joint velocity belongs to, and the coordinates it changes.
    """

    forces: np.ndarray
    rates: np.ndarray
    joints: Sequence[tuple[int, tuple[str, ...]]]


@final
@dataclass(frozen=True, eq=False)
class Sizes:
    """The sizes of the elements' forces.

    Args:
        forces: shape (n, k) [N or N·m].
        idle: shape (n, k, m), forces of the elements that balance one another.
    """

    forces: np.ndarray
    idle: np.ndarray


def unit_needs(mechanism: Mechanism, at: Snapshot, *, pressed: bool = False) -> list[np.ndarray]:
    """Return what each body needs to bear unit forces of the elements, each shape (n, 6, k).

    Args:
        mechanism: whose elements they are.
        at: its bodies, cut free.
        pressed: whether what goes with the magnitudes of the forces is wanted instead.
    """
    n, place = len(at.springs), {body.name: k for k, body in enumerate(at.bodies)}
    needs = [np.zeros((n, 6, len(force_names(mechanism.elements)))) for _ in at.bodies]
    for unit in unit_forces(mechanism, _ground(mechanism, at)):
        if unit.body in place and unit.pressed == pressed:
            force, moment = _wrench(unit, at.bodies[place[unit.body]].center)
            needs[place[unit.body]][:, :3, unit.index] -= force
            needs[place[unit.body]][:, 3:, unit.index] -= moment
    return needs


def _wrench(unit: UnitForce, center: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    def stack(part: Sequence[np.ndarray]) -> np.ndarray:
        return np.stack([np.broadcast_to(c, len(center)) for c in part], axis=1)

    point, force, moment = map(stack, (unit.point, unit.force, unit.moment))
    return force, moment + np.cross(point - center, force)


def _ground(mechanism: Mechanism, at: Snapshot) -> Ground:
    bodies = {body.name: body for body in at.bodies}
    n = len(at.springs)

    def turn(name: str) -> list[list[np.ndarray]]:
        turns = bodies[name].turn if name in bodies else np.broadcast_to(np.eye(3), (n, 3, 3))
        return [list(row) for row in np.moveaxis(turns, 0, -1)]

    def point(name: str, xyz: Sequence[object]) -> list[np.ndarray]:
        here = mechanism.evaluate_all(xyz)
        seat = bodies[name].seat if name in bodies else np.zeros((n, 3))
        pairs = zip(seat.T, turn(name), strict=True)
        return [start + combination(here, row) for start, row in pairs]

    def wave(angle: Scalar) -> tuple[float, float]:
        size = mechanism.evaluate(angle)
        return math.cos(size), math.sin(size)

    return Ground(
        point=point,
        turn=turn,
        scalar=mechanism.evaluate,
        root=np.sqrt,
        wave=wave,
        ratio=lambda a, b: a / b,
    )


def find_unexplained(
    mechanism: Mechanism, guides: Sequence[Guide], along: Along
) -> tuple[Guide, ...]:
    """Return the guides that the elements do not describe, at a position like any other.

    Args:
        mechanism: whose guides they are.
        guides: all of them.
        along: what acts along the joints there, in one state.
    """
    scale = _scale(mechanism, along)
    known = scale[:, None] * _known(along, 0)
    onto = known @ np.linalg.pinv(known, rcond=_RANK)
    found = []
    for guide in guides:
        basis = scale[:, None] * _tie_forces(along, guide, 0)
        if not guide.crossed or np.abs(basis - onto @ basis).max() > _EXPLAINED:
            found.append(guide)
    return tuple(found)


def size(mechanism: Mechanism, guides: Sequence[Guide], along: Along, demand: np.ndarray) -> Sizes:
    """Return the forces of the elements, of all that do the same the least.

    Args:
        mechanism: whose elements they are.
        guides: those that the elements do not describe.
        along: what acts along the joints.
        demand: shape (n, nu), what totals demand along the joints.

    Raises:
        DerivationError: if an element does work where the coordinate map moves the bodies.
    """
    work = np.abs(np.swapaxes(along.rates, 1, 2) @ along.forces)
    if work.size and work.max() > 1e-8:
        worst = int(work.max(axis=(0, 1)).argmax())
        raise DerivationError(
            f"mechanism {mechanism.name!r}: {force_names(mechanism.elements)[worst]} does work "
            f"where the coordinate map moves the bodies, {work.max():.3g} per unit; correct the "
            "points, radii or senses of its element, or the map"
        )
    count, scale = along.forces.shape[2], _scale(mechanism, along)
    stated = preloads(mechanism.elements)
    totals = np.array(mechanism.evaluate_all(one.total for one in stated))
    forces, idle = [], []
    for k, wanted in enumerate(demand):
        bases = [_tie_forces(along, guide, k) for guide in guides if guide.crossed]
        A = scale[:, None] * np.concatenate([_known(along, k), *bases], axis=1)
        together = np.zeros((len(stated), A.shape[1]))
        for row, one in zip(together, stated, strict=True):
            row[one.forces] = 1.0
        A = np.concatenate([A, together])
        inverse = np.linalg.pinv(A, rcond=_RANK)
        forces.append((inverse @ np.concatenate([-scale * wanted, totals]))[:count])
        idle.append((np.eye(A.shape[1]) - inverse @ A)[:count])
    return Sizes(np.array(forces), np.where(np.abs(idle) > _SHARE, idle, 0.0))


def _scale(mechanism: Mechanism, along: Along) -> np.ndarray:
    length = characteristic_length(mechanism)
    angular = {name for joint in mechanism.joints for name in joint.angular_coordinates}
    return np.array([1 / length if names[0] in angular else 1.0 for _, names in along.joints])


def _known(along: Along, k: int) -> np.ndarray:
    """Unit forces of the elements along the joints, and what the joints take themselves."""
    own = [along.forces[k]]
    for joint in dict.fromkeys(holder for holder, _ in along.joints):
        rows = [u for u, (holder, _) in enumerate(along.joints) if holder == joint]
        own.append(_null(along.rates[k], rows))
    return np.concatenate(own, axis=1)


def _tie_forces(along: Along, guide: Guide, k: int) -> np.ndarray:
    """The forces along the joints by which a guide may hold them."""
    tied = set(guide.coordinates)
    rows = [u for u, (_, names) in enumerate(along.joints) if tied.intersection(names)]
    return _null(along.rates[k], rows)


def _null(rates: np.ndarray, rows: list[int]) -> np.ndarray:
    """Forces along some joint velocities that do no work in any displacement, shape (nu, k)."""
    left, sizes, _ = np.linalg.svd(rates[rows])
    rank = int((sizes > _RANK * sizes.max(initial=_RANK)).sum())
    out = np.zeros((len(rates), len(rows) - rank))
    out[rows] = left[:, rank:]
    return out
