"""How far rounding alone may drive two accelerations apart at a state.

Two sources whose M, bias and forces agree to rounding still differ in what they solve from these.
Nothing is compared more strictly than the conditioning at that state allows: for A x = b and
(A + δA)(x + δx) = b + δb with ‖δA‖ ≤ u ‖A‖ and ‖δb‖ ≤ u β,

    ‖δx‖ ≤ ‖A⁻¹‖ (u ‖A‖ ‖x‖ + u β) / (1 − u ‖A⁻¹‖ ‖A‖)

(N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 2002, theorem 7.2), and
Gaussian elimination of a symmetric definite A commits no more than such a δA (sect. 10.1). β is the
sum of the norms of what makes b, so that cancellation of bias and forces counts. The norms are
taken after scaling by d_i = √M_ii, which is within a factor n of the best scaling there is (A. van
der Sluis, Numer. Math. 14 (1969) 14; Higham, theorem 7.5).

- Trees: A = M, b = forces − bias.
- Loops: A = [[M, −Jᵀ], [J, 0]], b = (forces − bias, −γ), rows of J scaled to length one. With an
  orthonormal basis N of the null space of J, the rows of A⁻¹ that give a are N (Nᵀ M N)⁻¹ Nᵀ and
  −(1 − N (Nᵀ M N)⁻¹ Nᵀ M) J⁺. Velocities satisfy J v = 0 to rounding only, so they are uncertain by
  u ‖J‖ ‖J⁺‖ ‖v‖; bias and γ are quadratic in them.
- Reactions of trees follow from the accelerations of bodies. Their error is that of a in the norm
  of the kinetic energy: δaᵀ M δa = δbᵀ M⁻¹ δb, which makes it grow with the root of ‖M⁻¹‖ only.

u is `UNIT` times the number of velocities: what n sums along a chain of links make of the machine's
ε = 2⁻⁵².
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from mecanique.derivation.numeric.multipliers import constraints
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.difference import scales
from mecanique.verification.rows import moving_mass

__all__ = ["UNIT", "rounding"]

Array = npt.NDArray[np.float64]

UNIT = 8 * float(np.finfo(float).eps)
"""Relative rounding error of the entries of M, bias and forces, for each velocity."""

_RANK = 1e-9
"""Singular values of the constraints below this part of the largest count as zero."""


def rounding(mechanism: Mechanism, states: States, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return how far rounding may drive what is solved for apart, scaled, by quantity; shape (n,).

    Args:
        mechanism: whose equations they are.
        states: n states.
        values: mass matrix, bias, forces and acceleration of one source there.
    """
    if not {"mass matrix", "bias", "forces", "acceleration"} <= values.keys():
        return {}
    d = scales(values["mass matrix"])
    mass = values["mass matrix"] / (d[:, :, None] * d[:, None, :])
    bias, forces = values["bias"] / d, values["forces"] / d
    acceleration = values["acceleration"] * d
    unit = UNIT * max(d.shape[1], 1)
    known = np.isfinite(mass).all(axis=(1, 2)) & np.isfinite(acceleration).all(axis=1)
    found = np.zeros((2, len(states)))
    total = moving_mass(mechanism)
    linked = constraints(mechanism, states) if mechanism.loops else None
    for k in np.flatnonzero(known):
        M, a = mass[k], acceleration[k]
        size = _norm(M) * _norm(a) + _norm(bias[k]) + _norm(forces[k])
        if linked is None:
            least = float(np.linalg.eigvalsh(M)[0]) if M.size else 1.0
            inverse = 1 / least if least > 0 else np.inf
            found[:, k] = inverse * size, (total * inverse) ** 0.5 * size
        else:
            J, gamma = linked.jacobian[k] / d[k], linked.gamma[k]
            found[0, k] = _constrained(M, J, gamma, a, bias[k], forces[k])
    found *= unit
    return (
        {"acceleration": found[0]}
        if mechanism.loops
        else dict(zip(("acceleration", "reactions"), found, strict=True))
    )


def _constrained(M: Array, J: Array, gamma: Array, a: Array, bias: Array, forces: Array) -> float:
    """Return the bound on ‖δa‖ of a closed mechanism, for u = 1."""
    lengths = np.linalg.norm(J, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)
    J, gamma = J / lengths[:, None], gamma / lengths
    left, sizes, right = np.linalg.svd(J)
    rank = int((sizes > _RANK * sizes[0]).sum()) if len(sizes) else 0
    N = right[rank:].T
    inverse = (right[:rank].T / sizes[:rank]) @ left[:, :rank].T
    free = np.linalg.pinv(N.T @ M @ N, rcond=1e-14, hermitian=True)
    by_force = N @ free @ N.T
    by_drift = inverse - by_force @ (M @ inverse)
    multipliers = inverse.T @ (M @ a + bias - forces)
    worse = 1 + 2 * _norm(J) * _norm(inverse)
    pushed = _norm(M) * _norm(a) + _norm(forces) + worse * _norm(bias)
    pushed += _norm(J) * _norm(multipliers)
    drifted = _norm(J) * _norm(a) + worse * _norm(gamma)
    return _norm(by_force) * pushed + _norm(by_drift) * drifted


def _norm(x: Array) -> float:
    return float(np.linalg.norm(x, 2)) if x.size else 0.0
