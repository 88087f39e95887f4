"""Compute the forces of guiding elements (cords, gears …) on batched floats.

The balances of the bodies give the total wrench T_k across each joint. The reaction in joint k is
R_k = T_k + Σ f_j S_kj, where S_kj balances the unit force j on all bodies beyond the joint. A joint
transmits nothing along or about its own directions n; hence for each of them

    n·T_k + armature u' + Σ f_j n·S_kj + (forces by which the joint itself is held) = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.derivation.mechanics.elements import Ground, unit_forces
from mecanique.derivation.numeric.free_bodies import Snapshot, shift, times
from mecanique.derivation.tolerances import EXPLAINED, RANK, SHARE
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model.constraint_base import Strung
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.guides.fit import cord_fault, mesh_fault, work_fault
from mecanique.model.guides.guide import Guide
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length


@final
@dataclass(frozen=True, eq=False)
class Along:
    """The effects of the elements' unit forces along the joint velocities."""

    forces: np.ndarray  # shape (n, nu, k), component of each unit force along each joint velocity
    rates: np.ndarray  # shape (n, nu, nv), ∂u/∂v
    # for each joint velocity, its joint and the coordinates it changes
    joints: Sequence[tuple[int, tuple[str, ...]]]


def unit_needs(mechanism: Mechanism, at: Snapshot, *, pressed: bool = False) -> np.ndarray:
    """Return the wrenches that balance the elements' unit forces on each body, (n, b, 6, k)."""
    ground = at.tree.ground
    if not pressed:
        _refuse_misfits(mechanism, ground)
    place = {name: k for k, name in enumerate(at.names)}
    needs = np.zeros((*at.twists.shape, len(force_names(mechanism.elements))))
    for unit in unit_forces(mechanism, ground):
        if unit.body in place and unit.pressed == pressed:
            k = place[unit.body]
            point, force, moment = map(_vectors, (unit.point, unit.force, unit.moment))
            wrench = np.hstack(np.broadcast_arrays(force, moment))
            needs[:, k, :, unit.index] -= times(shift(point - at.centers[:, k]), wrench)
    return needs


def _refuse_misfits(mechanism: Mechanism, ground: Ground) -> None:
    """Raise an error if a cord has no straight run, or wheels do not mesh."""

    def turn(body: str, axis: Sequence[float]) -> np.ndarray:
        return _vectors([combination(axis, row) for row in ground.turn(body)])

    for element in mechanism.elements:
        fault = ""
        if isinstance(element, Strung):
            stops = [_vectors(ground.point(stop.body, stop.center)) for stop in element.stops]
            n = np.array(element.normal)
            if element.axes != "world":
                n = turn(element.axes, element.normal)
            places = np.stack(np.broadcast_arrays(*stops), axis=-2)
            fault = cord_fault(mechanism, element, places, n)
        elif isinstance(element, (Gear, Rack)):
            a, b = (mechanism.joint(name) for name in element.joints)
            assert isinstance(a, Single)
            assert isinstance(b, Single)
            seat = element.point if isinstance(element, Rack) else (0.0, 0.0, 0.0)
            n, line = turn(a.child, a.axis)[0], turn(b.child, b.axis)[0]
            start = _vectors(ground.point(a.child, (0.0, 0.0, 0.0)))[0]
            end = _vectors(ground.point(b.child, seat))[0]
            # the first state serves for all: wheels that mesh in one do so in any
            fault = mesh_fault(mechanism, element, (n, line), (start, end))
        if fault:
            raise DerivationError(fault)


def refuse_work(mechanism: Mechanism, along: Along) -> None:
    """Raise an error if an element does work in a motion of the coordinate map."""
    fault = work_fault(mechanism, np.swapaxes(along.rates, 1, 2) @ along.forces)
    if fault:
        raise DerivationError(fault)


def _vectors(components: Sequence[np.ndarray]) -> np.ndarray:
    """Three components as vectors, shape (n, 3)."""
    return np.stack(np.broadcast_arrays(*components), axis=-1)


def find_unexplained(
    mechanism: Mechanism, guides: Sequence[Guide], along: Along
) -> tuple[Guide, ...]:
    """Return the guides that the elements do not describe, as judged in one generic state."""
    scale = _scale(mechanism, along)
    known = scale[:, None] * _collect_columns(along, 0)
    onto = known @ np.linalg.pinv(known, rcond=RANK)
    found = []
    for guide in guides:
        basis = scale[:, None] * _find_tie_forces(along, guide, 0)
        if not guide.crossed or np.abs(basis - onto @ basis).max() > EXPLAINED:
            found.append(guide)
    return tuple(found)


def size(
    mechanism: Mechanism, guides: Sequence[Guide], along: Along, demand: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the least forces of the elements that meet a demand, and which balance one another."""
    # Shapes: demand (n, nu); forces (n, k) [N or N·m]; sets of forces that balance one another and
    # so stay undetermined (n, k, m)
    refuse_work(mechanism, along)
    count, scale = along.forces.shape[2], _scale(mechanism, along)
    stated = preloads(mechanism.elements)
    totals = np.array(mechanism.evaluate_all(one.total for one in stated))
    forces, idle = [], []
    for k, wanted in enumerate(demand):
        bases = [_find_tie_forces(along, guide, k) for guide in guides if guide.crossed]
        A = scale[:, None] * np.concatenate([_collect_columns(along, k), *bases], axis=1)
        together = np.zeros((len(stated), A.shape[1]))
        for row, one in zip(together, stated, strict=True):
            row[one.forces] = 1.0
        A = np.concatenate([A, together])
        inverse = np.linalg.pinv(A, rcond=RANK)
        forces.append((inverse @ np.concatenate([-scale * wanted, totals]))[:count])
        idle.append((np.eye(A.shape[1]) - inverse @ A)[:count])
    return np.array(forces), np.where(np.abs(idle) > SHARE, idle, 0.0)


def _scale(mechanism: Mechanism, along: Along) -> np.ndarray:
    length = characteristic_length(mechanism)
    angular = {name for joint in mechanism.joints for name in joint.angular_coordinates}
    return np.array([1 / length if names[0] in angular else 1.0 for _, names in along.joints])


def _collect_columns(along: Along, k: int) -> np.ndarray:
    """Columns along the joints: unit forces of the elements, and forces within single joints."""
    own = [along.forces[k]]
    for joint in dict.fromkeys(holder for holder, _ in along.joints):
        rows = [u for u, (holder, _) in enumerate(along.joints) if holder == joint]
        own.append(_find_null(along.rates[k], rows))
    return np.concatenate(own, axis=1)


def _find_tie_forces(along: Along, guide: Guide, k: int) -> np.ndarray:
    """A basis of the forces by which a guide may hold its joints."""
    tied = set(guide.coordinates)
    rows = [u for u, (_, names) in enumerate(along.joints) if tied.intersection(names)]
    return _find_null(along.rates[k], rows)


def _find_null(rates: np.ndarray, rows: list[int]) -> np.ndarray:
    """A basis of forces along some joint velocities that do no virtual work, shape (nu, k)."""
    left, sizes, _ = np.linalg.svd(rates[rows])
    rank = int((sizes > RANK * sizes.max(initial=RANK)).sum())
    out = np.zeros((len(rates), len(rows) - rank))
    out[rows] = left[:, rank:]
    return out
