"""Estimate how far rounding alone may separate two correct sources at a state.

Nothing is compared more strictly than arithmetic allows there. u is `UNIT`, 8 ε with the machine's
ε = 2⁻⁵², times the root of the number of velocities: along a chain of links errors of either sign
add up like a random walk (Higham, sect. 2.8). In closed mechanisms it is `UNIT` times the number
itself: the elimination of the loops repeats the same errors, which then add up like their sizes.

What is summed: the error of a sum is at most u times the sum of its terms' magnitudes, however much
they cancel (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 2002, sect.
4.2). M_ii = m l² sin² θ, say, may be computed from m l² (1 − cos 2θ) / 2. The terms are at least as
large as the largest M_ii over the states; with s_i, the root of this maximum over M_ii, and
everything scaled by d_i = √M_ii,

    |δM_ij| ≤ u s_i s_j,    |δf_i| ≤ u s_i β

where β is the size of the forces f: their norm at the state and their typical one.

What is solved for: from (A + δA)(x + δx) = b + δb follows to first order |δx| ≤ |A⁻¹| (|δA| |x| +
|δb|) (Higham, theorem 7.4); elimination in a symmetric definite matrix adds no more than that
(sect. 10.1).

- Trees: A = M, b = forces − bias, hence |δa| ≤ u |M⁻¹| s (s·|a| + β).
- Loops: A = [[M, −Jᵀ], [J, 0]], b = (forces − bias, −γ), rows of J scaled to length one. With an
  orthonormal basis N of the null space of J, the rows of A⁻¹ that give a are N (Nᵀ M N)⁻¹ Nᵀ and
  −(1 − N (Nᵀ M N)⁻¹ Nᵀ M) J⁺. What a row of J sums is as large as its largest length over the
  states. Velocities satisfy J v = 0 to rounding only, so they are uncertain by u ‖J‖ ‖J⁺‖ ‖v‖; bias
  and γ are quadratic in them. In independent coordinates a block B of J takes the place of J, with
  an inverse that may be larger than J⁺, by a factor found in each state; it enters twice,
  δ(B⁻¹) = −B⁻¹ δB B⁻¹, in each step of Newton's method along the path.
- Reactions of trees follow from the accelerations of bodies. Their error is that of a in the norm
  of the kinetic energy: δaᵀ M δa = δbᵀ M⁻¹ δb grows with the root of M⁻¹ only.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.numeric.constraints.loops import Constraints
from mecanique.derivation.numeric.constraints.multipliers import constraints
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.difference import scales
from mecanique.verification.rows import moving_mass

UNIT = 8 * float(np.finfo(float).eps)
"""Relative rounding error of the entries of M, bias and forces of one velocity."""

_STEPS = 8
"""How much the steps along a path in independent coordinates add to one elimination."""

_RANK = 1e-9
"""Singular values of the constraints below this part of the largest count as zero."""


def rounding(
    mechanism: Mechanism,
    states: States,
    values: Mapping[str, Array],
    *,
    regular: Array | float = 1.0,
) -> dict[str, Array]:
    """Return how far rounding may separate sources, scaled, by quantity; shape (n,) each.

    Args:
        mechanism: whose equations they are.
        states: n states.
        values: mass matrix, bias and forces of one source there, and accelerations if they are
            compared.
        regular: least singular value of the part of J that is inverted, compared with J's, shape
            () or (n,).
    """
    if not {"mass matrix", "bias", "forces"} <= values.keys() or not mechanism.nv:
        return {}
    d = scales(values["mass matrix"])
    s = _largest(d) / d
    size = np.linalg.norm(s, axis=1)
    beta = {
        quantity: _size(values[quantity], d)
        for quantity in ("bias", "gravity", "forces")
        if quantity in values
    }
    pushed = beta["bias"] + beta["forces"]
    found = {"mass matrix": size**2, **{name: size * most for name, most in beta.items()}}
    found["inverse dynamics"] = size * (np.sum(s * np.abs(states.a * d), axis=1) + pushed)
    if "acceleration" in values:
        mass = values["mass matrix"] / (d[:, :, None] * d[:, None, :])
        scaled = {"bias": values["bias"] / d, "forces": values["forces"] / d}
        scaled["acceleration"] = values["acceleration"] * d
        if mechanism.constrained:
            linked = constraints(mechanism, states)
            found["acceleration"] = _of_loops(
                linked,
                d,
                mass,
                s,
                scaled,
                beta,
                np.broadcast_to(1 / np.maximum(regular, _RANK), len(d)),
            )
        else:
            inverse = np.abs(_inverses(mass))
            pushed = pushed + np.sum(s * np.abs(scaled["acceleration"]), axis=1)
            driven = np.einsum("nij,nj->ni", inverse, s)
            found["acceleration"] = np.linalg.norm(driven, axis=1) * pushed
            energy = moving_mass(mechanism) * np.sum(s * driven, axis=1)
            found["reactions"] = np.sqrt(energy) * pushed
    if np.ndim(regular) and "acceleration" in found:
        found["acceleration"] = _STEPS * found["acceleration"]
    unit = UNIT * mechanism.nv ** (1.0 if mechanism.loops else 0.5)
    return {name: unit * np.nan_to_num(bound, posinf=np.inf) for name, bound in found.items()}


def _of_loops(
    linked: Constraints,
    d: Array,
    mass: Array,
    s: Array,
    scaled: Mapping[str, Array],
    beta: Mapping[str, Array],
    gain: Array,
) -> Array:
    """Return the bounds on ‖δa‖ of a closed mechanism, for u = 1, shape (n,)."""
    bounds = np.zeros(len(d))
    usual = _largest(np.linalg.norm(linked.jacobian, axis=2))
    for k, M in enumerate(mass):
        a, rest = scaled["acceleration"][k], scaled["bias"][k] - scaled["forces"][k]
        J, gamma = linked.jacobian[k] / d[k], linked.gamma[k]
        if not all(np.isfinite(part).all() for part in (M, a, rest, J, gamma)):
            continue
        raw = np.linalg.norm(linked.jacobian[k], axis=1)
        summed = float(np.max(usual[raw > 0] / raw[raw > 0], initial=1.0))
        lengths = np.linalg.norm(J, axis=1)
        lengths = np.where(lengths > 0, lengths, 1.0)
        J, gamma = J / lengths[:, None], gamma / lengths
        left, sizes, right = np.linalg.svd(J)
        rank = int((sizes > _RANK * sizes.max(initial=0.0)).sum())
        N = right[rank:].T
        inverse = (right[:rank].T / sizes[:rank]) @ left[:, :rank].T
        by_force = N @ np.linalg.pinv(N.T @ M @ N, rcond=1e-14, hermitian=True) @ N.T
        by_drift = inverse - by_force @ (M @ inverse)
        largest = _norm(J) * summed
        uncertain = 1 + 2 * largest * _norm(inverse)
        moved = float(s[k] @ np.abs(a))
        multipliers = inverse.T @ (M @ a + rest)
        pushed = moved + beta["forces"][k] + uncertain * beta["bias"][k]
        pushed += largest * _norm(multipliers)
        drifted = largest * moved + uncertain * _norm(gamma)
        forced = _norm(np.abs(by_force) @ s[k])
        bounds[k] = gain[k] ** 2 * (forced * pushed + _norm(by_drift) * drifted)
    return bounds


def _inverses(mass: Array) -> Array:
    """Return the inverse of each matrix, infinite where there is none."""
    inverses = np.full_like(mass, np.inf)
    for k, matrix in enumerate(mass):
        if np.isfinite(matrix).all() and np.linalg.matrix_rank(matrix) == len(matrix):
            inverses[k] = np.linalg.inv(matrix)
    return inverses


def _largest(d: Array) -> Array:
    known = np.where(np.isfinite(d), d, 0.0)
    largest: Array = known.max(axis=0)
    return largest


def _size(forces: Array, d: Array) -> Array:
    """Return the norm at each state, and the typical one against the largest masses, shape (n,)."""
    with np.errstate(all="ignore"):
        typical = np.linalg.norm(forces / _largest(d), axis=1)
        known = typical[np.isfinite(typical)]
        usual = float(np.sqrt(np.mean(known**2))) if len(known) else 0.0
        size: Array = np.linalg.norm(forces / d, axis=1) + usual
    return size


def _norm(x: Array) -> float:
    return float(np.linalg.norm(x, 2)) if x.size else 0.0
