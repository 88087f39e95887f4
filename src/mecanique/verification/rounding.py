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
- What a form sums on its way, as the thousands of terms of a closed form beside a wheel that lies
  almost flat, is in none of these. Where it decides, the form is asked again at positions that
  differ by rounding; what its answers then differ by is rounding as well (J. J. Moré & S. M. Wild,
  Estimating computational noise, SIAM J. Sci. Comput. 33, 2011).
- Reactions of trees follow from the accelerations of bodies. Their error is that of a in the norm
  of the kinetic energy: δaᵀ M δa = δbᵀ M⁻¹ δb grows with the root of M⁻¹ only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array, rank_of
from mecanique.derivation.mechanics.chart import JointMotion
from mecanique.derivation.numeric.constraints.rows import Constraints, Held
from mecanique.derivation.numeric.paths import driven_paths
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.tree.links import Link, unit_motions
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.rows import moving_mass, scale, scales

UNIT = 8 * float(np.finfo(float).eps)
"""Relative rounding error of the entries of M, bias and forces of one velocity."""

_STEPS = 8
"""How much the steps along a path in independent coordinates add to one elimination."""

_RANK = 1e-9
"""Singular values of the constraints below this part of the largest count as zero."""


_SHIFTS = 5
"""How many times a form is asked again to see its noise."""

_SHIFTED = 4 * float(np.finfo(float).eps)
"""Relative change of the positions at which it is asked again, besides what loops are open."""

_NOISE = 8.0
"""Times the largest noise seen that two answers may differ by."""

_LOUDEST = 1e-5
"""Noise above this part of an answer excuses nothing: it may come from a fault.

The accelerations of a right closed form beside a crowned wheel that lies almost flat have 6.5e-6.
"""


def measure_noise(
    ask: Callable[[States], Mapping[str, Array]],
    mass: Array,
    states: States,
    opening: Array,
) -> dict[str, Array]:
    """Return the noise of a source's answers by quantity, (n,) each; opening (n,) of its loops."""
    # answers near the states are compared with each other, so that nothing but noise counts
    random = np.random.default_rng(0)
    # loops far from the origin close to the rounding of where they are, not of what they are
    size = _SHIFTED * np.abs(states.q) + opening[:, None]
    near = [random.uniform(states.q - size, states.q + size) for _ in range(_SHIFTS)]
    first, *others = (ask(replace(states, q=q)) for q in near)
    noise: dict[str, Array] = {}
    for quantity, values in first.items():
        once = scale(quantity, values, mass)
        repeated = (scale(quantity, answer[quantity], mass) for answer in others)
        change = np.max([np.linalg.norm(again - once, axis=1) for again in repeated], axis=0)
        loudest = _LOUDEST * np.linalg.norm(once, axis=1)
        noise[quantity] = np.where(change <= loudest, _NOISE * change, 0.0)
    return noise


def rounding(
    mechanism: Mechanism,
    states: States,
    values: Mapping[str, Array],
) -> dict[str, Array]:
    """Return how far rounding may separate sources, by quantity, (n,)."""
    if not {"mass matrix", "bias", "forces"} <= values.keys() or not mechanism.nv:
        return {}
    d = scales(values["mass matrix"])
    s = d.max(axis=0) / d
    size = np.linalg.norm(s, axis=1)
    beta = {
        quantity: _size(values[quantity], d)
        for quantity in ("bias", "gravity", "forces")
        if quantity in values
    }
    pushed = beta["bias"] + beta["forces"]
    bounds = {"mass matrix": size**2, **{name: size * most for name, most in beta.items()}}
    bounds["inverse dynamics"] = size * (np.sum(s * np.abs(states.a * d), axis=1) + pushed)
    if "acceleration" in values:
        mass = values["mass matrix"] / (d[:, :, None] * d[:, None, :])
        scaled = {"bias": values["bias"] / d, "forces": values["forces"] / d}
        scaled["acceleration"] = values["acceleration"] * d
        if mechanism.constrained:
            linked = Held(mechanism).at(states)
            bounds["acceleration"] = _of_loops(linked, d, mass, s, scaled, beta)
        else:
            # infinite where there is no inverse
            inverses = np.full_like(mass, np.inf)
            for k, matrix in enumerate(mass):
                if np.isfinite(matrix).all() and np.linalg.matrix_rank(matrix) == len(matrix):
                    inverses[k] = np.linalg.inv(matrix)
            inverse = np.abs(inverses)
            pushed = pushed + np.sum(s * np.abs(scaled["acceleration"]), axis=1)
            driven = np.einsum("nij,nj->ni", inverse, s)
            bounds["acceleration"] = np.linalg.norm(driven, axis=1) * pushed
            energy = moving_mass(mechanism) * np.sum(s * driven, axis=1)
            bounds["reactions"] = np.sqrt(energy) * pushed
    unit = UNIT * mechanism.nv ** (1.0 if mechanism.loops else 0.5)
    return {name: unit * np.nan_to_num(bound, posinf=np.inf) for name, bound in bounds.items()}


def in_independent_coordinates(bounds: Mapping[str, Array], regular: Array) -> dict[str, Array]:
    """Return the bounds for the block B of J that determines the others; regular (n,)."""
    # B⁻¹ enters twice in each step along the path
    gain = _STEPS / np.maximum(regular, _RANK) ** 2
    return {name: bound * (gain if name == "acceleration" else 1) for name, bound in bounds.items()}


def _of_loops(
    linked: Constraints,
    d: Array,
    mass: Array,
    s: Array,
    scaled: Mapping[str, Array],
    beta: Mapping[str, Array],
) -> Array:
    """Return the bounds on ‖δa‖ of a closed mechanism, for u = 1, shape (n,)."""
    bounds = np.zeros(len(d))
    usual = np.linalg.norm(linked.jacobian, axis=2).max(axis=0)
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
        rank = rank_of(sizes, _RANK)
        N = right[rank:].T
        inverse = (right[:rank].T / sizes[:rank]) @ left[:, :rank].T
        by_force = N @ np.linalg.pinv(N.T @ M @ N, rcond=1e-14, hermitian=True) @ N.T
        by_drift = inverse - by_force @ (M @ inverse)
        largest = _norm(J) * summed
        uncertain = 1 + 2 * largest * _norm(inverse)
        moved = float(np.sum(s[k] * np.abs(a)))
        multipliers = inverse.T @ (M @ a + rest)
        pushed = moved + beta["forces"][k] + uncertain * beta["bias"][k]
        pushed += largest * _norm(multipliers)
        drifted = largest * moved + uncertain * _norm(gamma)
        forced = _norm(np.abs(by_force) @ s[k])
        bounds[k] = forced * pushed + _norm(by_drift) * drifted
    return bounds


def _size(forces: Array, d: Array) -> Array:
    """Return the norm at each state, and the typical one against the largest masses, shape (n,)."""
    with np.errstate(all="ignore"):
        typical = np.linalg.norm(forces / d.max(axis=0), axis=1)
        known = typical[np.isfinite(typical)]
        usual = float(np.sqrt(np.mean(known**2))) if len(known) else 0.0
        size: Array = np.linalg.norm(forces / d, axis=1) + usual
    return size


def _norm(x: Array) -> float:
    return float(np.linalg.norm(x, 2)) if x.size else 0.0


ENTRY = 64 * float(np.finfo(float).eps)
"""u, four times the largest measured over all textbook systems and robots of example-robot-data."""

_TURN = 2 * np.pi
"""Angles that are larger are rounded by more than u allows."""


def entry_rounding(mechanism: Mechanism, states: States) -> dict[str, Array]:
    """Return the rounding error of each entry, by quantity, shaped like its values."""
    # of mass matrix and gravity; of bias, energy and momenta only where the coordinate map is
    # linear: derivatives by time of another may cancel
    if not mechanism.nv:
        return {}
    recursion = Recursion(mechanism)
    tree = recursion.tree
    chart = _Chart.of(recursion.at(states).chart, tree, states)
    weights: list[Array] = []
    pull, weight = np.zeros_like(chart.u), np.zeros_like(chart.u)
    kinetic, momentum, angular = np.zeros((3, len(states)))
    ways: list[Array] = []
    rates: list[_Rates] = []
    still, g = np.zeros(len(states)), np.linalg.norm(mechanism.evaluate_all(mechanism.gravity))
    last = 0
    for link, origin, J in zip(tree, recursion.origins, recursion.moments, strict=True):
        first, last = last, last + len(link.velocities)
        columns = slice(first, last)
        step = np.linalg.norm(origin[:3, 3]) + chart.reach(link)
        way = np.full(chart.u.shape, np.nan)
        before = _Rates(still, still, still, still + g)
        if link.parent >= 0:
            way, before = ways[link.parent] + step[:, None], rates[link.parent]
        way[:, columns] = 0.0
        ways.append(way)
        rates.append(before.advance(step, link, chart.u[:, columns]))
        if not J.any():
            continue
        root, size, rate = np.sqrt(J[3, 3]), np.sqrt(max(np.trace(J[:3, :3]), 0.0)), rates[-1]
        moved = ~np.isnan(way)
        B = np.where(chart.turns, root * way + size, root) * moved
        V = (root * rate.speed + size * rate.spin)[:, None]
        C = np.where(chart.turns, V, root * rate.spin[:, None]) * moved
        weights.append(np.nan_to_num(B))
        weight += weights[-1] * root * g
        pull += weights[-1] * (root * rate.speeding + size * rate.tumbling)[:, None] + C * V
        kinetic += V[:, 0] ** 2
        momentum += root * V[:, 0]
        angular += (2 * root * rate.way + size) * V[:, 0]
    B = np.stack(weights, axis=1) if weights else np.zeros((len(states), 0, last))
    rotors = np.abs([mechanism.evaluate(link.armature) for link in tree for _ in link.velocities])
    M = np.swapaxes(B, 1, 2) @ B + np.diag(rotors)
    kinetic += chart.u**2 @ rotors
    unit = ENTRY * chart.turned
    bounds = {
        "mass matrix": unit[:, None, None]
        * np.moveaxis(chart.motion.project_matrix(np.moveaxis(M, 0, -1)), -1, 0),
        "gravity": unit[:, None] * np.array(chart.motion.project(weight.T)).T,
    }
    if chart.linear:
        bounds |= {
            "bias": unit[:, None] * np.array(chart.motion.project(pull.T)).T,
            "kinetic energy": unit * kinetic,
            "momentum": np.tile(unit * momentum, (3, 1)).T,
            "angular momentum": np.tile(unit * angular, (3, 1)).T,
        }
    return bounds


@final
@dataclass(frozen=True)
class _Rates:
    """Sums of magnitudes along the links, their lengths, ω, v and a, shape (n,) each."""

    way: Array
    spin: Array
    speed: Array
    speeding: Array

    @property
    def tumbling(self) -> Array:
        """α + ω²: the turns of axes, ω × u, add up to another ω²."""
        return 2 * self.spin**2

    def advance(self, step: Array, link: Link, u: Array) -> _Rates:
        """Return the sums at the next link; step [m], u (n, velocities)."""
        turns = _turns(link)
        turn, slide = u[:, turns].sum(axis=1), u[:, ~turns].sum(axis=1)
        return _Rates(
            self.way + step,
            self.spin + turn,
            self.speed + self.spin * step + slide,
            self.speeding + self.tumbling * step + (2 * self.spin + turn) * slide,
        )


@final
@dataclass(frozen=True)
class _Chart:
    """Magnitudes of joint coordinates and velocities."""

    motion: JointMotion  # the joint coordinates, with G replaced by its magnitude
    sizes: dict[str, Array]  # magnitude of each joint coordinate, shape (n,)
    u: Array  # of the joint velocities, shape (n, nu)
    turns: npt.NDArray[np.bool_]  # which joint velocities turn, shape (nu,)
    turned: Array  # how much more than u the angles' own rounding makes, shape (n,)
    linear: bool  # whether joint coordinates are linear in the generalized ones

    @classmethod
    def of(cls, move: JointMotion, tree: tuple[Link, ...], states: States) -> _Chart:
        n, linear = len(states), True
        coordinates = [name for link in tree for name in link.coordinates]
        sizes = {name: np.abs(np.broadcast_to(move.r[name], (n,))) for name in coordinates}
        if move.order is None:
            G = np.array(np.broadcast_to(np.abs(move.G), (*move.G.shape[:2], n)))
            names = [name for link in tree for name in link.velocities]
            for name, driven in _drive(states).items():
                sizes[name] = driven.size
                G[names.index(f"{name}'")] = driven.slope.T
                linear = linear and driven.linear
            move = replace(move, G=G)
        angles = [sizes[link.coordinates[0]] for link in tree if link.kind == "turn"]
        turned = np.max([np.full(n, 1.0), *(angle / _TURN for angle in angles)], axis=0)
        turns = np.concatenate([np.zeros(0, dtype=bool), *map(_turns, tree)])
        return cls(
            motion=move,
            sizes=sizes,
            u=np.abs(move.u.T),
            turns=turns,
            turned=turned,
            linear=linear,
        )

    def reach(self, link: Link) -> Array:
        """Return how far a link's coordinates move its origin, shape (n,) [m]."""
        lengths = {"slide": 1, "free": 3}.get(link.kind, 0)
        squares = [self.sizes[name] ** 2 for name in link.coordinates[:lengths]]
        return np.sqrt(sum(squares, np.zeros(len(self.turned))))


def _turns(link: Link) -> npt.NDArray[np.bool_]:
    """Return which velocities of a link turn it, shape (velocities,)."""
    return np.array([any(angular) for _, angular in unit_motions(link)], dtype=bool)


@final
@dataclass(frozen=True)
class _Driven:
    """A joint coordinate r that follows the coordinate map, with its own rounding for u = 1."""

    size: Array  # |r| and what its arguments' rounding makes of it, shape (n,)
    slope: Array  # the same of ∂r/∂q, shape (n, nv)
    linear: bool  # whether r is a linear function of q


def _drive(states: States) -> dict[str, _Driven]:
    """Return what follows the coordinate map, by name of the joint coordinate."""
    mechanism, n = states.mechanism, len(states)
    coordinates = mechanism.coordinates
    used = set[str]().union(*map(symbols_in, coordinates.driven.values()))
    # along a motion at rest, ∂/∂t; along one with v = q in one coordinate, q ∂/∂q as well
    sizes = {f"{name}'": states.q[:, k] for k, name in enumerate(coordinates) if name in used}
    for joint in mechanism.joints:
        if joint.quaternion and used & {*joint.coordinates}:
            place = [coordinates.index(name) for name in joint.linear_coordinates]
            sizes |= dict.fromkeys(
                joint.linear_velocities, np.linalg.norm(states.q[:, place], axis=1)
            )
            sizes |= dict.fromkeys(joint.angular_velocities, np.ones(n))
    v = [np.zeros_like(states.v)]
    for k, name in enumerate(mechanism.velocities):
        if name in sizes:
            v.append(np.zeros_like(states.v))
            v[-1][:, k] = sizes[name]
    many = states.at(np.tile(np.arange(n), len(v)))
    driven = {}
    for name, c in driven_paths(replace(many, v=np.concatenate(v))).items():
        # of r and of its slopes, shape (1 + nv, n): the value first, then its rate
        still, *moving = np.moveaxis(c.reshape(*c.shape[:2], len(v), n), 2, 0)
        changes = [still[1] * states.t, *(motion[1] - still[1] for motion in moving)]
        size, *slopes = np.abs([still[0], *changes]).sum(axis=0)
        bent = np.any([motion[1, 1:] for motion in moving])
        driven[name] = _Driven(size, np.array(slopes).T, not (still[1].any() or bent))
    return driven
