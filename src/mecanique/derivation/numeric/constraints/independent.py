"""Solve Lagrange's equations of the second kind of a closed mechanism in independent coordinates.

The loops make the other coordinates functions of the independent ones. These functions are never
written down: their jets are found by Newton's method in the ring of jets, x ← x − J⁻¹ Φ(x) with
the constant J of the state, one order of ε after the other. Lagrange's operator is then evaluated
for the independent coordinates alone, by the same definition as for a tree
(`mecanique.derivation.numeric.lagrange`).

The coordinates of a joint with a quaternion are the Gibbs vector g of its rotation from the state,
p = p₀ (g/2, 1)/√(1 + g²/4), and for a free joint also the components of its displacement in the
axes it has in the state: at the state their rates are the joint's velocities (Shuster, J.
Astronaut. Sci. 41 (1993) 439, eq. 337).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.paths import JETS, stack_jets
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tolerances import ON_LOOPS, RANK, REGULAR
from mecanique.derivation.tree.links import links
from mecanique.derivation.tree.poses import (
    combination,
    joint_values,
    poses,
    quaternion_product,
    quaternion_rotation,
)
from mecanique.errors import DerivationError
from mecanique.model.expression import evaluate
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

_SWEEPS = 40
"""Largest number of Newton's iterations."""

_TOGETHER = 4096
"""States times directions computed together: more no longer fit in the cache."""


class _Group(NamedTuple):
    """States with the same dependent coordinates."""

    at: np.ndarray  # indices of the states
    rows: np.ndarray  # independent rows of J
    dependent: np.ndarray  # columns of J that these rows determine
    blocks: np.ndarray  # J in these rows and columns, shape (states, rows, rows)
    regular: np.ndarray  # least singular value of each block, relative to J's

    @property
    def inverse(self) -> np.ndarray:
        """Inverses of the blocks."""
        return np.linalg.inv(self.blocks)

    def take(self, indices: np.ndarray) -> _Group:
        """Return some of the states, counted in the group."""
        at, blocks, regular = (x[indices] for x in (self.at, self.blocks, self.regular))
        return _Group(at, self.rows, self.dependent, blocks, regular)


@final
class Reduced:
    """Compute the accelerations of a closed mechanism in independent coordinates."""

    def __init__(self, mechanism: Mechanism) -> None:
        for signal in mechanism.inputs:
            if callable(signal.signal):
                raise DerivationError(
                    f"input {signal.symbol!r} is a function, which has no exact derivatives"
                )
        self._mechanism = mechanism
        self._tree = links(mechanism)
        self._held = Held(mechanism)
        at = {name: k for k, name in enumerate(mechanism.velocities)}
        self._plain = {name: at[f"{name}'"] for name in mechanism.coordinates if f"{name}'" in at}
        self._definition = LagrangeOnJets(mechanism)

    def acceleration(self, states: States) -> np.ndarray:
        """Return a, shape (n, nv)."""
        result = np.empty_like(states.v)
        if not result.shape[1]:
            return result
        forces = self._definition.forces(states)
        for group in self._groups(states):
            result[group.at] = self._solve(states.at(group.at), forces[group.at], group)
        return result

    def regularity(self, states: States) -> np.ndarray:
        """Return the least singular value of the dependent columns of J, relative to J's, (n,)."""
        regular = np.ones(len(states))
        for group in self._groups(states) if self._mechanism.nv else ():
            regular[group.at] = group.regular
        return regular

    def _groups(self, states: States) -> Iterator[_Group]:
        """Group the states by their dependent coordinates."""
        J = self._held.at(states).jacobian / self._held.row_units.units[:, None]
        waiting = np.arange(len(states))
        while len(waiting):
            rows, dependent = _choose(J[waiting[0]])
            blocks = J[waiting][:, rows][:, :, dependent]
            regular = np.array(
                [_regularity(*pair) for pair in zip(blocks, J[waiting], strict=True)]
            )
            fit = regular > REGULAR
            fit[0] = True
            yield _Group(waiting[fit], rows, dependent, blocks[fit], regular[fit])
            waiting = waiting[~fit]

    def _solve(self, states: States, forces: np.ndarray, group: _Group) -> np.ndarray:
        n = len(states)
        start = self._start(states, group)
        count = start.shape[2] - 1
        # accelerations, all zero and along each independent coordinate, at every state
        a = np.repeat(np.eye(count + 1, count, -1), n, axis=0)
        most = max(_TOGETHER // (1 + count), 1)
        parts = []
        for first in range(0, len(a), most):
            some = np.arange(first, min(first + most, len(a)))
            of = some % n
            parts.append(self._operator(states.at(of), a[some], start[..., of], group.take(of)))
        rest, E, weight = (
            np.concatenate(part).reshape(count + 1, n, -1) for part in zip(*parts, strict=True)
        )
        M = np.moveaxis(E[1:] - E[0], 0, -1)
        # partial derivatives of all coordinates with respect to the independent ones
        follow = start[:, 0, 1:].transpose(2, 0, 1)
        right = np.einsum("nvk,nv->nk", follow, forces) - E[0] - weight[0]
        try:
            independent = np.linalg.solve(M, right[..., None])[..., 0]
        except np.linalg.LinAlgError:
            raise DerivationError(
                f"mechanism {self._mechanism.name!r}: "
                "its loops allow a motion without inertia; give a body in it mass"
            ) from None
        accelerations: np.ndarray = rest[0] + np.einsum("nvk,nk->nv", follow, independent)
        for joint in self._mechanism.joints:
            if joint.quaternion and joint.linear_velocities:
                # the components of the velocity are in axes that turn with the body
                at = [self._mechanism.velocities.index(name) for name in joint.velocities]
                v, omega = states.v[:, at[:3]], states.v[:, at[3:]]
                accelerations[:, at[:3]] -= np.cross(omega, v)
        return accelerations

    def _operator(
        self, states: States, a: np.ndarray, start: np.ndarray, group: _Group
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return all accelerations, Lagrange's operator on T, and ∂V/∂q of gravity."""
        # The latter two have shape (n, free)
        c = start.copy()
        c[np.setdiff1d(np.arange(len(c)), group.dependent), 2, 0] = a.T / 2
        r, H = self._close(states, c, 2, group)
        E = self._definition.operate(r, H, a.shape)
        return 2 * c[:, 2, 0].T, E, self._definition.weigh(H, a.shape)

    def _start(self, states: States, group: _Group) -> np.ndarray:
        """Return the coordinates' jets without what accelerations change, (nv, 3, 1 + free, n)."""
        nv, n = self._mechanism.nv, len(states)
        free = np.setdiff1d(np.arange(nv), group.dependent).tolist()
        c = np.zeros((nv, 3, 1 + len(free), n))
        for name, q in zip(self._mechanism.coordinates, states.q.T, strict=True):
            if name in self._plain:
                c[self._plain[name], 0, 0] = q
        for k, at in enumerate(free):
            c[at, 0, 1 + k] = 1.0
        c[:, 1, 0] = states.v.T
        for order in range(2):
            self._close(states, c, order, group)
        return c

    def _close(
        self, states: States, c: np.ndarray, order: int, group: _Group
    ) -> tuple[dict[str, Any], list[Jet]]:
        """Close the loops in one order of ε, those below being closed; return values and poses."""
        dependent, inverse = group.dependent, group.inverse
        units = self._held.row_units.units
        # the state itself is not corrected: near a singular position the correction of its
        # rounding errors would grow with every order
        given = order < 2
        last = np.inf
        for _ in range(_SWEEPS):
            # no order depends on those above it
            placed = self._evaluate_poses(states, [Jet(path[: order + 1]) for path in c])
            if not len(group.rows):  # loops may hold nothing that moves
                break
            phi = self._held.gaps(placed[1])
            off = np.stack([phi[i].c[order] / units[i] for i in group.rows], axis=-1)
            if given and float(np.abs(off[0]).max(initial=0.0)) < ON_LOOPS:
                off[0] = 0.0
            size = float(np.abs(off).max(initial=0.0))
            most = max(float(np.abs(c[:, order]).max()), 1.0)
            if size < 1e-15 or (size < 1e-10 * most and size >= last):
                break
            last = size
            c[dependent, order] -= np.moveaxis((inverse @ off[..., None])[..., 0], -1, 0)
        return placed

    def _evaluate_poses(self, states: States, x: list[Jet]) -> tuple[dict[str, Any], list[Jet]]:
        mechanism = self._mechanism
        values: dict[str, Any] = {
            **mechanism.values,
            **{name: x[at] for name, at in self._plain.items()},
        }
        q = dict(zip(mechanism.coordinates, states.q.T, strict=True))
        for joint in mechanism.joints:
            if joint.quaternion:
                place = [mechanism.velocities.index(name) for name in joint.velocities]
                displaced = _turn([q[name] for name in joint.coordinates], [x[at] for at in place])
                values |= zip(joint.coordinates, displaced, strict=True)
        c = np.zeros(x[0].c.shape)
        c[0, 0], c[1:2, 0] = states.t, 1.0
        values["t"] = Jet(c)
        for signal in mechanism.inputs:
            values[signal.symbol] = evaluate(signal.signal, values, function=function)
        values = joint_values(mechanism, values, JETS)
        return values, [stack_jets(rows, x[0].c.shape) for rows in poses(self._tree, values, JETS)]


def _turn(start: list[np.ndarray], x: list[Jet]) -> list[Any]:
    """Displace the coordinates of a joint with a quaternion."""
    origin, p = start[:-4], start[-4:]
    gx, gy, gz = (g * 0.5 for g in x[-3:])
    size = (1 + gx * gx + gy * gy + gz * gz).sqrt()
    quaternion = [part / size for part in quaternion_product(p, (gx, gy, gz, 1.0))]
    if not origin:
        return quaternion
    turn = quaternion_rotation(*p)
    moved = [combination(row, x[:3]) + at for row, at in zip(turn, origin, strict=True)]
    return [*moved, *quaternion]


def _choose(J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Choose independent rows, and the coordinates they determine best, by full pivoting."""
    J = J.copy()
    rows: list[int] = []
    columns: list[int] = []
    top = float(np.abs(J).max(initial=0.0))
    while len(rows) < min(J.shape):
        i, k = np.unravel_index(int(np.abs(J).argmax()), J.shape)
        if not abs(J[i, k]) > RANK * top:
            break
        rows.append(int(i))
        columns.append(int(k))
        J -= np.outer(J[:, k] / J[i, k], J[i])
        J[:, k] = 0.0
        J[i] = 0.0
    return np.array(sorted(rows), dtype=int), np.array(sorted(columns), dtype=int)


def _regularity(block: np.ndarray, J: np.ndarray) -> float:
    """Return the least singular value of a block of J, relative to J's; 0 if its rank is less."""
    sizes = np.linalg.svd(J, compute_uv=False)
    if rank_of(sizes, RANK) != len(block):
        return 0.0
    if not len(block):
        return 1.0
    return float(np.linalg.svd(block, compute_uv=False)[-1] / sizes[len(block) - 1])
