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
"""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar, NamedTuple, final

import numpy as np

from mecanique.derivation.numeric.constraints.multipliers import Held
from mecanique.derivation.numeric.dynamics import BatchDynamics, solve
from mecanique.derivation.numeric.elements import (
    Along,
    find_unexplained,
    refuse_work,
    size,
    unit_needs,
)
from mecanique.derivation.numeric.free_bodies import (
    BatchFreeBodies,
    Snapshot,
    cross_rows,
    times,
)
from mecanique.derivation.tolerances import OUTSIDE, RANK_UNSCALED
from mecanique.errors import DerivationError
from mecanique.model.constraints.elements import force_names
from mecanique.model.guides.find import guides_of
from mecanique.model.guides.guide import Guide, idle_coordinates
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States


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

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return T = Σ ½ m v_C² + ½ H_C·ω and V of gravity and springs, each shape (n,) [J]."""
        # The kinetic energy is that of Fundamentals of Dynamics, eq. 1.31.
        at = self._bodies.at(states)
        T = 0.5 * np.sum(at.armature * at.u**2, axis=-1)
        V = at.springs
        for body in at.bodies:
            T = T + 0.5 * body.mass * (body.velocity**2).sum(-1)
            T = T + 0.5 * (body.angular_momentum * body.spin).sum(-1)
            V = V - body.mass * body.center @ self._bodies.gravity
        return T, V

    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the linear momentum, and the angular ones about origin and center of mass."""
        # They are the sums of m v_C and of H_C + r_C × m v_C, each shape (n, 3) (Fundamentals of
        # Dynamics, eqs. 1.7, 1.9, 1.11).
        linear, angular, first = (np.zeros((len(states), 3)) for _ in range(3))
        mass = 0.0
        for body in self._bodies.moving(states):
            push = body.mass * body.velocity
            linear = linear + push
            angular = angular + body.angular_momentum + cross_rows(body.center, push)
            first, mass = first + body.mass * body.center, mass + body.mass
        center = first / mass if mass else first
        return linear, angular, angular - cross_rows(center, linear)


@final
class Balances(FreeBodyDynamics):
    """The balances of linear and angular momentum of every body of a mechanism, in numbers."""

    def acceleration(self, states: States) -> np.ndarray:
        """Return the accelerations, shape (n, nv), solved for together with all reactions."""
        return self._solve(states)[:, : self._mechanism.nv]

    def reactions(self, states: States) -> dict[str, JointWrench]:
        """Return the reaction in each joint by name, without springs, dampers, drives and loads."""
        # Components that depend on a guide without an element are NaN
        found = self._hold(states)[0] if self._mechanism.elements else self.totals(states)
        crossed = {name for guide in self.guides for name in guide.crossed}
        if crossed:
            at = self._bodies.at(states)
            for k, joint in enumerate(self._mechanism.tree):
                if joint.name in crossed:
                    part = np.where(self._loose(at, k), np.nan, 0.0)
                    found[joint.name] = JointWrench(part[:, :3], part[:, 3:])
        return found

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
        found = guides_of(m)
        if not m.elements:
            return found
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
                return find_unexplained(m, found, along)
        assert fault is not None
        raise fault

    def _push(self, at: Snapshot) -> tuple[list[np.ndarray], Along]:
        """Return the wrenches across the joints that balance the elements' unit forces."""
        # Also return their components along the joint velocities
        carried = self._transmit(at, unit_needs(self._mechanism, at))
        return carried, Along(self._along(at, carried), at.rates, self._bodies.columns)

    def _hold(self, states: States) -> tuple[dict[str, JointWrench], np.ndarray]:
        """Return the reactions without the elements' actions, and the elements' forces, (n, k)."""
        m, at = self._mechanism, self._bodies.at(states)
        solved = self._solve(states)
        carried, along = self._push(at)
        end = m.nv + 6 * len(m.joints)  # the multipliers follow
        totals = [solved[:, k : k + 6] for k in range(m.nv, end, 6)]
        u = times(at.rates, solved[:, : m.nv]) + at.gamma
        demand = self._along(at, [total[..., None] for total in totals])[..., 0] + at.armature * u
        sizes = size(m, self.guides, along, demand)
        pressed = self._transmit(at, unit_needs(m, at, pressed=True))
        found = {}
        for joint, total, under, apart in zip(m.tree, totals, carried, pressed, strict=True):
            whole = total + times(under, sizes.forces) + times(apart, np.abs(sizes.forces))
            found[joint.name] = JointWrench(whole[:, :3], whole[:, 3:])
        unknown = (sizes.idle != 0).any(axis=(0, 2))
        forces = np.where(unknown, np.nan, sizes.forces)
        return {joint.name: found[joint.name] for joint in m.joints}, forces

    def totals(self, states: States) -> dict[str, JointWrench]:
        """Return the total wrench across each joint: its reaction and the guides' actions."""
        nv, count = self._mechanism.nv, len(self._mechanism.joints)
        found = self._solve(states)[:, nv : nv + 6 * count].reshape(len(states), -1, 2, 3)
        names = [joint.name for joint in self._mechanism.tree]
        by_name = {
            name: JointWrench(found[:, k, 0], found[:, k, 1]) for k, name in enumerate(names)
        }
        return {joint.name: by_name[joint.name] for joint in self._mechanism.joints}

    def multipliers(self, states: States) -> np.ndarray:
        """Return the multiplier of each row of `Held`, shape (n, m)."""
        return self._solve(states)[:, self._mechanism.nv + 6 * len(self._mechanism.joints) :]

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M: the coefficients of the accelerations once the reactions are eliminated."""
        at = self._bodies.at(states)
        G = at.rates
        needs = [
            np.concatenate([body.mass * body.J, body.inertia @ body.J_spin], axis=1)
            for body in at.bodies
        ]
        return np.asarray(
            self._project(at, needs) + np.swapaxes(G, 1, 2) @ (at.armature[:, None] * G)
        )

    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv)."""
        at = self._bodies.at(states)
        g = self._bodies.gravity
        needs = [
            np.concatenate([b.mass * (b.gamma - g), b.tumbling], axis=1)[..., None]
            for b in at.bodies
        ]
        rotors = np.einsum("nuv,nu->nv", at.rates, at.armature * at.gamma)
        return np.asarray(self._project(at, needs)[..., 0] + rotors)

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv)."""
        at = self._bodies.at(states)
        needs = [np.concatenate([body.force, body.moment], axis=1)[..., None] for body in at.bodies]
        return self._project(at, needs)[..., 0]

    def gravity(self, states: States) -> np.ndarray:
        """Return gravity's part of the bias, shape (n, nv)."""
        at, n = self._bodies.at(states), len(states)
        weights = [
            body.mass * np.concatenate([self._bodies.gravity, np.zeros(3)]) for body in at.bodies
        ]
        return -self._project(at, [np.broadcast_to(w, (n, 6))[..., None] for w in weights])[..., 0]

    def _project(self, at: Snapshot, needs: list[np.ndarray]) -> np.ndarray:
        """Project the bodies' wrenches on the generalized velocities, without reactions."""
        # Shape (n, nv, k). Shapes: needs (n, 6, k).
        return np.asarray(np.swapaxes(at.rates, 1, 2) @ self._along(at, self._transmit(at, needs)))

    def _transmit(self, at: Snapshot, needs: list[np.ndarray]) -> list[np.ndarray]:
        """Sum wrenches from the tips inward: the wrench at each body's seat, each (n, 6, k)."""
        across = [_shift(need, body.arm) for need, body in zip(needs, at.bodies, strict=True)]
        for k in range(len(across) - 1, -1, -1):
            body = at.bodies[k]
            if body.parent >= 0:
                across[body.parent] = across[body.parent] + _shift(across[k], body.step)
        return across

    def _along(self, at: Snapshot, wrenches: list[np.ndarray]) -> np.ndarray:
        """Components of the joints' wrenches along their joint velocities, shape (n, nu, k)."""
        columns = wrenches[0].shape[2] if wrenches else 1
        out = np.zeros((len(at.springs), len(at.holders), columns))
        for u, k in enumerate(at.holders):
            out[:, u] = np.einsum("ni,nik->nk", at.axes[:, :, u], wrenches[k])
        return out

    def _solve(self, states: States) -> np.ndarray:
        """Solve for accelerations, reactions and multipliers, shape (n, nv + 6 nb + m)."""
        at = self._bodies.at(states)
        if self._mechanism.rolls:
            A, known = self._held_system(at, states)
            defined = np.isfinite(A).all(axis=(1, 2))  # not where a crowned wheel lies flat
            inverse = np.linalg.pinv(np.where(defined[:, None, None], A, 0.0), rcond=RANK_UNSCALED)
            found = np.where(defined[:, None], np.zeros_like(known), np.nan)
            # refined iteratively: forces and accelerations differ much in size
            for _ in range(_REFINED):
                found += times(inverse, known - times(A, found))
            return found
        if self._mechanism.nv + 6 * len(at.bodies) <= _DENSE:
            A, known = self._system(at)
            return solve(self._mechanism, A, known)
        a = solve(
            self._mechanism, self.mass_matrix(states), self.forces(states) - self.bias(states)
        )
        needs = []
        for body in at.bodies:
            push = body.mass * (times(body.J, a) + body.gamma - self._bodies.gravity) - body.force
            turn = times(body.inertia, times(body.J_spin, a)) + body.tumbling - body.moment
            needs.append(np.concatenate([push, turn], axis=1)[..., None])
        return np.concatenate(
            [a, *(wrench[..., 0] for wrench in self._transmit(at, needs))], axis=1
        )

    def _system(self, at: Snapshot) -> tuple[np.ndarray, np.ndarray]:
        """Assemble A x = known for x = [a, force and couple of each joint]."""
        # The rows are those of the bodies, then of the joints
        n, nv, count = len(at.springs), self._mechanism.nv, len(at.bodies)
        size = nv + 6 * count
        A, known = np.zeros((n, size, size)), np.zeros((n, size))
        for k, body in enumerate(at.bodies):
            push, turn = _rows(k)
            A[:, push, :nv] = body.mass * body.J
            A[:, turn, :nv] = body.inertia @ body.J_spin
            known[:, push] = body.mass * (self._bodies.gravity - body.gamma) + body.force
            known[:, turn] = body.moment - body.tumbling
            # the reaction acts on the body, and its opposite on the parent
            force, couple = _rows(k, nv)
            for other, sign, step in ((k, -1.0, 0.0), (body.parent, 1.0, body.step)):
                if other < 0:
                    continue
                push, turn = _rows(other)
                arm = step - at.bodies[other].arm
                A[:, push, force] += sign * np.eye(3)
                A[:, turn, couple] += sign * np.eye(3)
                A[:, turn, force] += sign * _cross(arm)
        G = at.rates
        joints = slice(6 * count, size)
        for u, k in enumerate(at.holders):
            wrench = slice(nv + 6 * int(k), nv + 6 * int(k) + 6)
            A[:, joints, wrench] += G[:, u, :, None] * at.axes[:, None, :, u]
        rotors = G * at.armature[:, None]
        A[:, joints, :nv] += np.swapaxes(G, 1, 2) @ rotors
        known[:, joints] -= np.einsum("nuv,nu->nv", rotors, at.gamma)
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
        forces = self._held.forces(states)
        index = {body.name: k for k, body in enumerate(at.bodies)}
        for i in range(m):
            column = A[:, :size, size + i]
            if i not in forces:
                column[:, size - nv :] = -rows.jacobian[:, i]
                continue
            place, direction, ends = forces[i]
            for body, sign in zip(ends, (1.0, -1.0), strict=True):
                if body in index:
                    push, turn = _rows(index[body])
                    arm = place - at.bodies[index[body]].center
                    column[:, push] -= sign * direction
                    column[:, turn] -= sign * np.cross(arm, direction)
        return A, np.concatenate([known, -rows.gamma], axis=1)


_REFINED = 3
"""How often a constrained system is solved, each time for the last residual."""

_DENSE = 200
"""Reactions are eliminated from systems with more equations than this before solving."""


def _cross(r: np.ndarray) -> np.ndarray:
    """Return the matrix of r ×, shape (n, 3, 3)."""
    x, y, z = r.T
    upper = np.zeros((len(r), 3, 3))
    upper[:, 0, 1] = -z
    upper[:, 0, 2] = y
    upper[:, 1, 2] = -x
    return upper - np.swapaxes(upper, 1, 2)


def _rows(k: int, start: int = 0) -> tuple[slice, slice]:
    """Return the slices of the k-th force and the k-th moment in an array of wrenches."""
    middle = start + 6 * k + 3
    return slice(middle - 3, middle), slice(middle, middle + 3)


def _shift(wrench: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Refer a wrench to a new point; `arm` leads from there to the old one, shape (n, 6, k)."""
    force, couple = wrench[:, :3], wrench[:, 3:]
    moment = couple + cross_rows(arm[:, :, None], force)
    return np.concatenate([force, moment], axis=1)


def refuse_misfits(mechanism: Mechanism) -> None:
    """Raise a DerivationError if an element that guides does not fit the coordinate map."""
    if mechanism.elements:
        _ = Balances(mechanism).guides
