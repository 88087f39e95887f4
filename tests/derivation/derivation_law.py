"""Functions of any scalar, and Lagrange's operator on jets: the definition, for any L(q, v, t)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet

Lagrangian: TypeAlias = Callable[[Sequence[Any], Sequence[Any], Any], Any]
"""A function L(q, v, t) written with the functions below, so that any scalar may enter."""

sin, cos, tan, atan2 = map(function, ("sin", "cos", "tan", "atan2"))
sqrt, exp, log = map(function, ("sqrt", "exp", "log"))


def euler(L: Lagrangian, q: Any, v: Any, a: Any, t: float | np.ndarray = 0.0) -> np.ndarray:
    """Return d/dt ∂L/∂vᵢ − ∂L/∂qᵢ along a motion, by the definition, for any L.

    With q + ε v varied along direction i and v + ε a along direction n + i, the value of L is a jet
    whose partial [ε¹, n + i] is d/dt ∂L/∂vᵢ and whose partial [ε⁰, i] is ∂L/∂qᵢ (J. L. Lagrange,
    Mécanique analytique, 1788).

    Args:
        L: the function L(q, v, t), written generically; T − V, or T alone.
        q: shape (n,) or (n, states).
        v: shape (n,) or (n, states), rates of q.
        a: shape (n,) or (n, states), rates of v.
        t: time, shape () or (states,) [s].

    Returns:
        shape (n,) or (n, states).
    """
    q, v, a = (np.asarray(x, dtype=float) for x in (q, v, a))
    n = len(q)

    def path(value: Any, rate: Any, direction: int | None = None) -> Jet:
        c = np.zeros((2, 1 + 2 * n, *q.shape[1:]))
        c[0, 0], c[1, 0] = value, rate
        if direction is not None:
            c[0, 1 + direction] = 1.0
        return Jet(c)

    Q = [path(q[i], v[i], i) for i in range(n)]
    V = [path(v[i], a[i], n + i) for i in range(n)]
    result = L(Q, V, path(t, 1.0))
    if not isinstance(result, Jet):  # L is a constant
        return np.zeros_like(q)
    return np.asarray(result.c[1, 1 + n :] - result.c[0, 1 : 1 + n])
