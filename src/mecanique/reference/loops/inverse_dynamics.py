"""Compute the inverse dynamics of a mechanism with loops: the driving forces in chosen joints.

M a + bias − forces = Jᵀ λ + B τ; λ does no work in the motions T that the loops allow, so
Tᵀ B τ = Tᵀ (M a + bias − forces) (principle of virtual work; Shabana, Dynamics of Multibody
Systems, sect. 5.5).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import ClosureError
from mecanique.reference.engine.tree import Tree
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.freedom.independent import Independent
from mecanique.reference.loops.tolerances import DEPENDENT, OPEN

_LEFT = 1e-8
"""Largest unbalanced part of the forces, relative to these."""


def free_motions(closed: Closed, q: Array, t: float) -> tuple[Array, Array]:
    """Return the independent velocities w, and T of v = T w + b, shape (nv, n).

    Args:
        closed: the loops.
        q: shape (nq,), with closed loops.
        t: time [s].

    Raises:
        EngineError: if a loop is open.
    """
    closed.refuse_open(q, t)
    found = Independent(closed, q, t)
    return found.chosen, found.tangent


def driving_forces(
    tree: Tree,
    closed: Closed | None,
    drives: Sequence[str],
    q: Array,
    v: Array,
    t: float,
    a: Array,
) -> Array:
    """Return the forces in some joints that give a mechanism its accelerations, shape (drives,).

    Args:
        tree: the mechanism's tree.
        closed: its loops, if any.
        drives: the velocities of these joints.
        q: shape (nq,).
        v: shape (nv,).
        t: time [s].
        a: shape (nv,).

    Raises:
        EngineError: if a loop is open.
        ClosureError: if the loops do not allow v or a, or the drives cannot produce these.
    """
    name = tree.mechanism.name
    T = np.eye(len(v))
    if closed is not None:
        _, T = free_motions(closed, q, t)
        here = closed.closures.at(q, v, t)
        for what, kind, rest in ((v, "velocities", here.drift), (a, "accelerations", here.gamma)):
            moved = here.jacobian * what
            off = np.abs(closed.closures.rows * (moved.sum(axis=1) + rest))
            size = closed.closures.rows * (np.abs(moved).sum(axis=1) + np.abs(rest))
            if (off > OPEN * max(float(size.max(initial=0.0)), 1.0)).any():
                worst = closed.closures.names[int(off.argmax())]
                raise ClosureError(
                    f"mechanism {name!r}: the loops do not allow these {kind} ({worst}); "
                    "expected J v + b = 0 and J a + γ = 0, see Reference.constraint_jacobian"
                )
    parts = tree.mass(q, v, t) @ a, tree.bias(q, v, t), -tree.forces(q, v, t)
    chart = tree.chart
    chart.place(q, t)
    chart.at(q, v, t)
    B = T.T @ chart.G[[chart.rows[drive] for drive in drives]].T
    needed = T.T @ sum(parts)
    tau: Array = np.linalg.lstsq(B, needed, rcond=DEPENDENT)[0]
    size = np.abs(T.T) @ sum(np.abs(part) for part in parts) + np.abs(B) @ np.abs(tau)
    if (np.abs(B @ tau - needed) > _LEFT * size).any():
        raise ClosureError(
            f"mechanism {name!r}: drives in {', '.join(drives)} alone cannot produce these "
            f"accelerations: {T.shape[1]} motions are free; name more joints to drive"
        )
    return tau
