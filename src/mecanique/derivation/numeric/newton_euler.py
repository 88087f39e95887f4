"""Solve Newton's and Euler's equations of all bodies for accelerations and reactions together.

For each body, about its center of mass C and in world axes (Fundamentals of Dynamics, eqs. 1.2,
1.3, 1.8, 1.12):

    m a_C = m g + F + R − Σ R_child,    d/dt H_C = M_C + (couple and moment of R) − Σ (those of
    R_child),

with applied forces F, their moment M_C, the reaction R and its couple at the body's joint, and
the opposite of the reactions of the joints that the body carries (action and reaction). A joint
transmits nothing along or about its free directions, except the torque of its rotor; where
coordinates are driven, the reactions along the joints do no virtual work in total. At a joint that
a guide crosses, the unknown is the total of the reaction and the guide's action. A contact acts by
an unknown force at the point where two bodies touch, and its opposite; the condition of rolling
completes the equations.

The forces of guiding elements (cords, gears …) follow from these wrenches. With the total T_k
across joint k, its reaction is R_k = T_k + Σ f_j S_kj, where S_kj balances the unit force j on all
bodies beyond the joint. A joint transmits nothing along or about its own directions n; hence for
each

    n·T_k + armature u' + Σ f_j n·S_kj + (forces by which the joint itself is held) = 0.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple, final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.derivation.mechanics.elements import Ground, unit_forces
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.numeric.dynamics import BatchDynamics, solve
from mecanique.derivation.numeric.free_bodies import (
    BatchFreeBodies,
    Snapshot,
    cross_rows,
    shift,
    times,
)
from mecanique.derivation.tolerances import EXPLAINED, OUTSIDE, RANK, RANK_UNSCALED, SHARE
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model import Gear, Mechanism, Rack
from mecanique.model.constraint_base import Strung
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.model.guides import (
    Guide,
    cord_fault,
    guides_of,
    idle_coordinates,
    mesh_fault,
    work_fault,
)
from mecanique.model.joint_base import Single
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States


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
    needs = np.zeros((*at.twists.shape, len(force_names(mechanism.elements))))
    for unit in unit_forces(mechanism, ground):
        if unit.body in at.places and unit.pressed == pressed:
            k = at.places[unit.body]
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
    unexplained = []
    for guide in guides:
        basis = scale[:, None] * _find_tie_forces(along, guide, 0)
        if not guide.crossed or np.abs(basis - onto @ basis).max() > EXPLAINED:
            unexplained.append(guide)
    return tuple(unexplained)


def size(
    mechanism: Mechanism, guides: Sequence[Guide], along: Along, demand: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the least forces of the elements that meet a demand, and which balance one another."""
    # Shapes: demand (n, nu); forces (n, k) [N or N·m]; sets of forces that balance one another and
    # so stay undetermined (n, k, m)
    refuse_work(mechanism, along)
    count, scale = along.forces.shape[2], _scale(mechanism, along)
    stated = preloads(mechanism.elements)
    totals = np.array(mechanism.evaluate_all(preload.total for preload in stated))
    forces, idle = [], []
    for k, wanted in enumerate(demand):
        bases = [_find_tie_forces(along, guide, k) for guide in guides if guide.crossed]
        A = scale[:, None] * np.concatenate([_collect_columns(along, k), *bases], axis=1)
        together = np.zeros((len(stated), A.shape[1]))
        for row, preload in zip(together, stated, strict=True):
            row[preload.forces] = 1.0
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
    columns = [along.forces[k]]
    for joint in dict.fromkeys(holder for holder, _ in along.joints):
        rows = [u for u, (holder, _) in enumerate(along.joints) if holder == joint]
        columns.append(_find_null(along.rates[k], rows))
    return np.concatenate(columns, axis=1)


def _find_tie_forces(along: Along, guide: Guide, k: int) -> np.ndarray:
    """A basis of the forces by which a guide may hold its joints."""
    tied = set(guide.coordinates)
    rows = [u for u, (_, names) in enumerate(along.joints) if tied.intersection(names)]
    return _find_null(along.rates[k], rows)


def _find_null(rates: np.ndarray, rows: list[int]) -> np.ndarray:
    """A basis of forces along some joint velocities that do no virtual work, shape (nu, k)."""
    left, sizes, _ = np.linalg.svd(rates[rows])
    rank = rank_of(sizes, RANK)
    out = np.zeros((len(rates), len(rows) - rank))
    out[rows] = left[:, rank:]
    return out


class JointWrench(NamedTuple):
    """The wrench that a parent exerts on its child through their joint."""

    force: np.ndarray  # shape (3,) or (n, 3), world axes [N]
    # shape (3,) or (n, 3), about the origin of the child's frame, world axes [N·m]
    moment: np.ndarray


class FreeBodyDynamics(BatchDynamics):
    """What free bodies give, however their equations are solved."""

    rolls: ClassVar[bool] = True

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._bodies = BatchFreeBodies(mechanism)

    @cached_property
    def _held(self) -> Held:
        return Held(self._mechanism)

    @abstractmethod
    def project(self, at: Snapshot, wrenches: np.ndarray) -> np.ndarray:
        """Return the generalized forces of wrenches on the bodies, shape (n, nv, k)."""
        # Shapes: wrenches (n, b, 6, k), about the centers of mass

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M: the generalized forces of the inertia forces of unit accelerations."""
        at = self._bodies.at(states)
        rotors = np.swapaxes(at.rates, 1, 2) @ (at.armature[:, None] * at.rates)
        return np.asarray(self.project(at, at.inertia @ at.J) + rotors)

    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv)."""
        at = self._bodies.at(states)
        rotors = np.einsum("nuv,nu->nv", at.rates, at.armature * at.joint_gamma)
        return np.asarray(self.project(at, at.drift[..., None])[..., 0] + rotors)

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv)."""
        at = self._bodies.at(states)
        return self.project(at, at.loads[..., None])[..., 0]

    def gravity(self, states: States) -> np.ndarray:
        """Return gravity's part of the bias, shape (n, nv)."""
        at = self._bodies.at(states)
        return -self.project(at, at.weights[..., None])[..., 0]

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return T = Σ ½ m v_C² + ½ H_C·ω and V of gravity and springs, each shape (n,) [J]."""
        # The kinetic energy is that of Fundamentals of Dynamics, eq. 1.31.
        at = self._bodies.at(states)
        T = np.sum(at.armature * at.u**2, axis=-1) + np.sum(at.momenta * at.twists, axis=(1, 2))
        return 0.5 * T, at.springs - (at.centers @ at.fall[:3]) @ at.masses

    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the linear momentum, and the angular ones about origin and center of mass."""
        # They are the sums of m v_C and of H_C + r_C × m v_C, each shape (n, 3) (Fundamentals of
        # Dynamics, eqs. 1.7, 1.9, 1.11).
        at = self._bodies.at(states)
        centers, masses = at.centers[:, at.moves], at.masses[at.moves]
        push, spin = np.split(at.momenta[:, at.moves], 2, axis=-1)
        linear = push.sum(axis=1)
        angular = (spin + cross_rows(centers, push)).sum(axis=1)
        center = masses @ centers / (masses.sum() or 1.0)
        return linear, angular, angular - cross_rows(center, linear)


@final
class Balances(FreeBodyDynamics):
    """The balances of linear and angular momentum of every body of a mechanism, in numbers."""

    def acceleration(self, states: States) -> np.ndarray:
        """Return the accelerations, shape (n, nv), solved for together with all reactions."""
        return self._split(states)[0]

    def reactions(self, states: States) -> dict[str, JointWrench]:
        """Return the reaction in each joint by name, without springs, dampers, drives and loads."""
        # Components that depend on a guide without an element are NaN
        wrenches = self._hold(states)[0] if self._mechanism.elements else self.totals(states)
        crossed = {name for guide in self.guides for name in guide.crossed}
        if crossed:
            at = self._bodies.at(states)
            for k, joint in enumerate(self._mechanism.tree):
                if joint.name in crossed:
                    part = np.where(self._loose(at, k), np.nan, 0.0)
                    wrenches[joint.name] = JointWrench(part[:, :3], part[:, 3:])
        return wrenches

    def _loose(self, at: Snapshot, k: int) -> np.ndarray:
        """Whether a guide may act along each component of the k-th joint's wrench, shape (n, 6)."""
        idle = idle_coordinates(self.guides, self._mechanism.tree[k])
        mine = [
            u
            for u, (holder, names) in enumerate(self._bodies.columns)
            if holder == k and idle.issuperset(names)
        ]
        axes = at.axes[:, :, mine]
        # each unit wrench less its projection on the idle directions
        left = np.eye(6) - axes @ np.linalg.pinv(axes)
        return np.asarray(np.linalg.norm(left, axis=1) > OUTSIDE)

    def guide_forces(self, states: States) -> dict[str, np.ndarray]:
        """Return the forces of the guiding elements by name, each shape (n,) [N or N·m]."""
        # Forces that redundant elements leave undetermined are NaN
        if not self._mechanism.elements:
            return {}
        forces = self._hold(states)[1]
        return dict(zip(force_names(self._mechanism.elements), forces.T, strict=True))

    @cached_property
    def guides(self) -> tuple[Guide, ...]:
        """The guides that no element describes."""
        m = self._mechanism
        every = guides_of(m)
        if not m.elements:
            return every
        away = np.random.default_rng(1784).uniform(0.2, 1.0, m.nq)
        fault = None
        for near in (0.1, 0.03, 0.01, 0.003, 0.0):
            at = self._bodies.at(States.of(m, m.normalize(m.neutral() + near * away)))
            try:
                along = self._push(at)[1]
                refuse_work(m, along)
            except DerivationError as error:
                fault = error
            else:
                return find_unexplained(m, every, along)
        assert fault is not None
        raise fault

    def _push(self, at: Snapshot) -> tuple[np.ndarray, Along]:
        """Return the wrenches across the joints that balance the elements' unit forces."""
        # Also return their components along the joint velocities
        carried = self._transmit(at, unit_needs(self._mechanism, at))
        return carried, Along(self._along(at, carried), at.rates, self._bodies.columns)

    def _hold(self, states: States) -> tuple[dict[str, JointWrench], np.ndarray]:
        """Return the reactions without the elements' actions, and the elements' forces, (n, k)."""
        m, at = self._mechanism, self._bodies.at(states)
        a, totals, _ = self._split(states)
        carried, along = self._push(at)
        u = times(at.rates, a) + at.joint_gamma
        demand = self._along(at, totals[..., None])[..., 0] + at.armature * u
        sizes, idle = size(m, self.guides, along, demand)
        pressed = self._transmit(at, unit_needs(m, at, pressed=True))
        pull = sizes[:, None]
        whole = totals + times(carried, pull) + times(pressed, np.abs(pull))
        unknown = (idle != 0).any(axis=(0, 2))
        return self._by_joint(whole), np.where(unknown, np.nan, sizes)

    def totals(self, states: States) -> dict[str, JointWrench]:
        """Return the total wrench across each joint: its reaction and the guides' actions."""
        return self._by_joint(self._split(states)[1])

    def multipliers(self, states: States) -> np.ndarray:
        """Return the multiplier of each row of `Held`, shape (n, m)."""
        return self._split(states)[2]

    def _split(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return accelerations, wrenches of the joints (n, b, 6), and multipliers."""
        nv, count = self._mechanism.nv, len(self._mechanism.joints)
        a, wrenches, multipliers = np.split(self._solve(states), [nv, nv + 6 * count], axis=1)
        return a, wrenches.reshape(len(a), count, 6), multipliers

    def _by_joint(self, wrenches: np.ndarray) -> dict[str, JointWrench]:
        """Return wrenches along the tree by the joints' names, in the author's order."""
        place = {joint.name: k for k, joint in enumerate(self._mechanism.tree)}
        wrench = {joint.name: wrenches[:, place[joint.name]] for joint in self._mechanism.joints}
        return {name: JointWrench(both[:, :3], both[:, 3:]) for name, both in wrench.items()}

    def project(self, at: Snapshot, wrenches: np.ndarray) -> np.ndarray:
        """Return the generalized forces of wrenches on the bodies, without reactions."""
        along = self._along(at, self._transmit(at, wrenches))
        return np.asarray(np.swapaxes(at.rates, 1, 2) @ along)

    def _transmit(self, at: Snapshot, wrenches: np.ndarray) -> np.ndarray:
        """Sum wrenches from the tips inward: the wrench at each body's seat, (n, b, 6, k)."""
        across, inward = shift(at.arms) @ wrenches, shift(at.steps)
        for k in range(len(at.parents) - 1, -1, -1):
            if at.parents[k] >= 0:
                across[:, at.parents[k]] += inward[:, k] @ across[:, k]
        return np.asarray(across)

    def _along(self, at: Snapshot, across: np.ndarray) -> np.ndarray:
        """Components of the joints' wrenches along their joint velocities, shape (n, nu, k)."""
        return np.asarray(np.einsum("niu,nuik->nuk", at.axes, across[:, at.holders]))

    def _solve(self, states: States) -> np.ndarray:
        """Solve for accelerations, reactions and multipliers, shape (n, nv + 6 nb + m)."""
        at = self._bodies.at(states)
        if self._mechanism.rolls:
            A, known = self._held_system(at, states)
            defined = np.isfinite(A).all(axis=(1, 2))  # not where a crowned wheel lies flat
            inverse = np.linalg.pinv(np.where(defined[:, None, None], A, 0.0), rcond=RANK_UNSCALED)
            solution = np.where(defined[:, None], np.zeros_like(known), np.nan)
            # refined iteratively: forces and accelerations differ much in size
            for _ in range(_REFINED):
                solution += times(inverse, known - times(A, solution))
            return solution
        if self._mechanism.nv + 6 * len(at.parents) <= _DENSE:
            A, known = self._system(at)
            return solve(self._mechanism, A, known)
        a = solve(
            self._mechanism, self.mass_matrix(states), self.forces(states) - self.bias(states)
        )
        missing = at.drift + times(at.inertia, times(at.J, a[:, None])) - at.loads
        return np.hstack([a, self._transmit(at, missing[..., None]).reshape(len(a), -1)])

    def _system(self, at: Snapshot) -> tuple[np.ndarray, np.ndarray]:
        """Assemble A x = known for x = [a, force and couple of each joint]."""
        # The rows are those of the bodies, then of the joints
        n, _, _, nv = at.J.shape
        joints = 6 * len(at.parents)
        A = np.zeros((n, joints + nv, nv + joints))
        known = np.zeros((n, joints + nv))
        A[:, :joints, :nv] = (at.inertia @ at.J).reshape(n, joints, nv)
        known[:, :joints] = (at.loads - at.drift).reshape(n, joints)
        for k, parent in enumerate(at.parents):
            # the reaction acts on the body, and its opposite on the parent
            reaction = slice(nv + 6 * k, nv + 6 * k + 6)
            A[:, 6 * k : 6 * k + 6, reaction] = -shift(-at.arms[:, k])
            if parent >= 0:
                arm = at.steps[:, k] - at.arms[:, parent]
                A[:, 6 * parent : 6 * parent + 6, reaction] = shift(arm)
        for u, k in enumerate(at.holders):
            along = at.rates[:, u, :, None] * at.axes[:, None, :, u]
            A[:, joints:, nv + 6 * k : nv + 6 * k + 6] += along
        rotors = at.rates * at.armature[:, None]
        A[:, joints:, :nv] += np.swapaxes(at.rates, 1, 2) @ rotors
        known[:, joints:] -= np.einsum("nuv,nu->nv", rotors, at.joint_gamma)
        return A, known

    def _held_system(self, at: Snapshot, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Extend `_system` by the multipliers of constraints, and by the rows J a = −γ."""
        tree, known = self._system(at)
        rows = self._held.at(states)
        n, size = known.shape
        m, nv = rows.gamma.shape[1], self._mechanism.nv
        A = np.zeros((n, size + m, size + m))
        A[:, :size, :size] = tree
        A[:, size:, :nv] = rows.jacobian
        for i, push in enumerate(rows.pushes):
            column = A[:, :size, size + i]
            if push is None:
                column[:, size - nv :] = -rows.jacobian[:, i]
                continue
            wrench = np.hstack([push.direction, np.zeros((n, 3))])
            for body, sign in zip(push.ends, (1.0, -1.0), strict=True):
                if body in at.places:
                    k = at.places[body]
                    moved = times(shift(push.place - at.centers[:, k]), wrench)
                    column[:, 6 * k : 6 * k + 6] -= sign * moved
        return A, np.concatenate([known, -rows.gamma], axis=1)


_REFINED = 3
"""How often a constrained system is solved, each time for the last residual."""

_DENSE = 200
"""Reactions are eliminated from systems with more equations than this before solving."""


def refuse_misfits(mechanism: Mechanism) -> None:
    """Raise a DerivationError if an element that guides does not fit the coordinate map."""
    if mechanism.elements:
        _ = Balances(mechanism).guides
