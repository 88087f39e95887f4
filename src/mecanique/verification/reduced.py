"""Equations in independent velocities w: v = S w, SᵀM(S w' + c).

A derivation that puts constraints on velocities into T before Lagrange's operator, which is wrong,
has the right mass matrix SᵀMS and another bias: that of the Lagrangian T(q, S w) − V (Neimark &
Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. III, sect. 1; SymPy's documentation did, issue
27631).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.derivation.numeric.constraints.multipliers import Held
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.stencil import differences
from mecanique.verification.verdict import Cause

_STEP = 1e-2
"""Of the differences along each independent velocity."""

_SAME = 1e-6
"""Relative difference up to which a bias is that of a Lagrangian with the constraint in it."""


class _Tree(NamedTuple):
    """M, h and forces of the tree with S and c, at n states."""

    M: Array
    h: Array
    Q: Array
    g: Array
    S: Array
    c: Array


@final
class Reduced:
    """The equations of a mechanism in some of its velocities, which the others follow."""

    def __init__(self, mechanism: Mechanism, by: tuple[str, ...]) -> None:
        if not mechanism.rolls:
            raise InputError(
                f"mechanism {mechanism.name!r} has no contacts or velocity constraints; expected "
                "functions of all its velocities, without 'by'"
            )
        if mechanism.quaternions:
            raise InputError(
                f"joint {mechanism.quaternions[0][0]!r} turns by a quaternion; describe it by "
                "three hinges to compare equations in some of the velocities"
            )
        known = [name.removesuffix("'") for name in mechanism.velocities if name.endswith("'")]
        for name in by:
            if name not in known:
                raise UnknownNameError("coordinate", name, known)
        self._mechanism = mechanism
        self._equations, self._held = derive(mechanism), Held(mechanism)
        self._at = [mechanism.velocities.index(f"{name}'") for name in by]

    def values(self, states: States) -> dict[str, Array]:
        """Return mass matrix, bias and forces in the independent velocities, by quantity."""
        tree = self._tree(states)
        moved = np.einsum("nij,nj->ni", tree.M, tree.c) + tree.h
        return {
            "mass matrix": self._mass(tree),
            "bias": np.einsum("nij,ni->nj", tree.S, moved),
            "forces": np.einsum("nij,ni->nj", tree.S, tree.Q),
        }

    def substitute(self, states: States) -> Array:
        """Return the bias of Lagrange's operator on T(q, S w) − V, shape (n, N)."""
        tree, w = self._tree(states), states.v[:, self._at]
        forces: Array = np.einsum("nij,ni->nj", tree.S, tree.g)
        for k in range(len(states)):
            along = tree.S[k]

            def mass(steps: Array, k: int = k, along: Array = along) -> Array:
                state = states.at(np.full(len(steps), k))
                there = replace(state, q=state.q + steps @ along.T)
                flat: Array = self._mass(self._tree(there)).reshape(len(steps), -1)
                return flat

            n = len(self._at)
            slopes = differences(mass, n, _STEP).reshape(n, n, n)  # ∂M_ij/∂q_b
            forces[k] += np.einsum("ijb,b,j->i", slopes, w[k], w[k])
            forces[k] -= np.einsum("ijb,i,j->b", slopes, w[k], w[k]) / 2
        return forces

    def _mass(self, tree: _Tree) -> Array:
        mass: Array = np.einsum("nij,nik,nkl->njl", tree.S, tree.M, tree.S)
        return mass

    def _tree(self, states: States) -> _Tree:
        equations, held = self._equations, self._held.at(states)
        still = np.zeros_like(states.v)
        n, nv = states.v.shape
        S, c = np.zeros((n, nv, len(self._at))), np.zeros((n, nv))
        rest = [k for k in range(nv) if k not in self._at]
        for k, (J, gamma) in enumerate(zip(held.jacobian, held.gamma, strict=True)):
            given = np.column_stack([J[:, self._at], gamma])
            solution, _, rank, _ = np.linalg.lstsq(J[:, rest], -given, rcond=1e-9)
            if rank < len(rest):
                names = ", ".join(self._mechanism.velocities[i] for i in self._at)
                raise InputError(f"the velocities {names} do not determine the others")
            S[k, self._at], S[k, rest] = np.eye(len(self._at)), solution[:, :-1]
            c[k, rest] = solution[:, -1]
        q, v, t = states.q, states.v, states.t
        return _Tree(
            M=np.asarray(equations.mass_matrix(q, t)),
            h=np.asarray(equations.bias(q, v, t)),
            Q=np.asarray(equations.forces(q, v, t)),
            g=np.asarray(equations.bias(q, still, t)),
            S=S,
            c=c,
        )


def blame_substitution(
    reduced: Reduced, states: States, ours: dict[str, Array], theirs: dict[str, Array]
) -> tuple[Cause, ...]:
    """Return the cause that the constraint was put into T, if that explains a bias."""
    if "bias" not in theirs:
        return ()
    wrong = reduced.substitute(states)
    size = float(np.linalg.norm(theirs["bias"])) or 1.0
    before, after = (
        float(np.linalg.norm(theirs["bias"] - bias)) / size for bias in (ours["bias"], wrong)
    )
    if not (after <= _SAME < before):
        return ()
    text = (
        "the constraint on velocities was put into T before Lagrange's operator; it belongs beside "
        "it, with multipliers (Q + Jᵀ λ), or the equations are projected afterwards"
    )
    return (Cause("constraint put into T", "", text, before, after),)
