"""Bound the rounding error of each entry of a quantity, from the bodies' contributions.

The error of a sum is at most u times the sum of its terms' magnitudes, however much they cancel
(N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 2002, sect. 4.2). An entry
is a sum over bodies, and the terms of each are as large as its way back to the joint along the
links, however these are folded at the moment. With the way r_bi from joint i to the origin of body
b, its mass m_b and its polar second moment Σ_b = ∫ p² dm about that origin, let B_bi be
√m_b r_bi + √Σ_b for a turn and √m_b for a slide. Then

    |δM_ij| ≤ u Σ_b B_bi B_bj,    |δf_i| ≤ u Σ_b (B_bi A_b + C_bi V_b)

with A_b = √m_b a_b + √Σ_b (α_b + ω_b²) and V_b = √m_b v_b + √Σ_b ω_b, where the velocity v_b and
the acceleration a_b of the origin, ω_b and α_b are sums of magnitudes as well, collected along the
links. The first term is d'Alembert's force; the second is ∂T/∂q_i, which Lagrange's operator
subtracts from a rate that contains it: C_bi is V_b for a turn and √m_b ω_b for a slide.

Likewise the kinetic energy sums Σ V_b² / 2, a component of the momentum Σ √m_b V_b, and of the
angular momentum Σ (2 √m_b r_b + √Σ_b) V_b with the way r_b from the ground.

A coordinate map r = φ(q, t) with G = ∂φ/∂q spreads the terms over the generalized velocities; the
map itself is as certain as what goes into it: |δr| ≤ u (|r| + |G| |q| + |φ_t t|), and G likewise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.numeric.chart import Chart, Motions
from mecanique.derivation.numeric.paths import driven_paths
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.tree.links import Link, motions
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

ENTRY = 64 * float(np.finfo(float).eps)
"""u, four times the largest measured over all textbook systems and robots of example-robot-data."""

_TURN = 2 * np.pi
"""Angles that are larger are rounded by more than u allows."""


def entry_rounding(mechanism: Mechanism, states: States) -> dict[str, Array]:
    """Return the rounding error of each entry, by quantity, shaped like its values.

    They are those of the mass matrix and gravity, and where the coordinate map is linear those of
    bias, kinetic energy and momenta: derivatives by time of another may cancel.

    Args:
        mechanism: whose equations they are.
        states: n states.
    """
    if not mechanism.nv:
        return {}
    recursion = Recursion(mechanism)
    tree = recursion.tree
    chart = _Chart.of(mechanism, tree, states)
    weights: list[Array] = []
    pull, weight = np.zeros_like(chart.u), np.zeros_like(chart.u)
    kinetic, momentum, angular = np.zeros((3, len(states)))
    ways: list[Array] = []
    rates: list[_Rates] = []
    still, g = np.zeros(len(states)), np.linalg.norm(mechanism.evaluate_all(mechanism.gravity))
    last = 0
    for link, origin, J in zip(tree, recursion.origins, recursion.moments, strict=True):
        first, last = last, last + len(link.velocities)
        own = slice(first, last)
        step = np.linalg.norm(origin[:3, 3]) + chart.reach(link)
        way = np.full(chart.u.shape, np.nan)
        before = _Rates(still, still, still, still, still + g)
        if link.parent >= 0:
            way, before = ways[link.parent] + step[:, None], rates[link.parent]
        way[:, own] = 0.0
        ways.append(way)
        rates.append(before.advance(step, link, chart.u[:, own], chart.gamma[:, own]))
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
    rotors = [mechanism.evaluate(link.armature) for link in tree for _ in link.velocities]
    M = np.swapaxes(B, 1, 2) @ B + np.diag(np.abs(rotors))
    pull += np.abs(rotors) * chart.gamma
    unit = ENTRY * chart.turned
    found = {
        "mass matrix": unit[:, None, None] * chart.motions.projected_matrix(M),
        "gravity": unit[:, None] * chart.motions.project(weight),
    }
    if chart.linear:
        found |= {
            "bias": unit[:, None] * chart.motions.project(pull),
            "kinetic energy": unit * kinetic,
            "momentum": np.tile(unit * momentum, (3, 1)).T,
            "angular momentum": np.tile(unit * angular, (3, 1)).T,
        }
    return found


@final
@dataclass(frozen=True)
class _Rates:
    """Sums of magnitudes along the links, their lengths, ω, v, α and a, shape (n,) each."""

    way: Array
    spin: Array
    speed: Array
    turning: Array
    speeding: Array

    @property
    def tumbling(self) -> Array:
        """α + ω²."""
        return self.turning + self.spin**2

    def advance(self, step: Array, link: Link, u: Array, gamma: Array) -> _Rates:
        """Return the sums at the next link.

        Args:
            step: how far its origin is from the last one [m].
            link: which it is.
            u: magnitudes of its joint velocities, shape (n, velocities).
            gamma: of their rates, shape (n, velocities).
        """
        turns = _turns(link)
        turn, slide = u[:, turns].sum(axis=1), u[:, ~turns].sum(axis=1)
        faster, farther = gamma[:, turns].sum(axis=1), gamma[:, ~turns].sum(axis=1)
        return _Rates(
            self.way + step,
            self.spin + turn,
            self.speed + self.spin * step + slide,
            self.turning + (2 * self.spin + turn) * turn + faster,
            self.speeding + self.tumbling * step + (2 * self.spin + turn) * slide + farther,
        )


@final
@dataclass(frozen=True)
class _Chart:
    """Magnitudes of joint coordinates and velocities.

    Args:
        motions: the joint coordinates, with G replaced by its magnitude.
        sizes: magnitude of each joint coordinate, shape (n,).
        u: of the joint velocities, shape (n, nu).
        gamma: of their rates at constant generalized velocities, shape (n, nu).
        turns: which joint velocities turn, shape (nu,).
        turned: how much more than u the angles' own rounding makes, shape (n,).
        linear: whether joint coordinates are linear in the generalized ones.
    """

    motions: Motions
    sizes: dict[str, Array]
    u: Array
    gamma: Array
    turns: npt.NDArray[np.bool_]
    turned: Array
    linear: bool

    @classmethod
    def of(cls, mechanism: Mechanism, tree: tuple[Link, ...], states: States) -> _Chart:
        move = Chart(mechanism, tree).motions(states)
        n, linear = len(states), True
        sizes = {name: np.abs(np.broadcast_to(value, (n,))) for name, value in move.r.items()}
        if move.G is not None:
            G, names = np.abs(move.G), [name for link in tree for name in link.velocities]
            for name, driven in _drive(states).items():
                sizes[name] = driven.size
                G[:, names.index(f"{name}'")] = driven.slope
                linear = linear and driven.linear
            move = replace(move, G=G)
        angles = [sizes[link.coordinates[0]] for link in tree if link.kind == "turn"]
        turned = np.max([np.full(n, 1.0), *(angle / _TURN for angle in angles)], axis=0)
        turns = np.concatenate([np.zeros(0, dtype=bool), *map(_turns, tree)])
        return cls(
            motions=move,
            sizes=sizes,
            u=np.abs(move.u),
            gamma=np.abs(move.gamma),
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
    return np.array([bool(S[:3, :3].any()) for S in motions(link)], dtype=bool)


@final
@dataclass(frozen=True)
class _Driven:
    """A joint coordinate r that follows the coordinate map, with its own rounding for u = 1.

    Args:
        size: |r| and what its arguments' rounding makes of it, shape (n,).
        slope: the same of ∂r/∂q, shape (n, nv).
        linear: whether r is a linear function of q.
    """

    size: Array
    slope: Array
    linear: bool


def _drive(states: States) -> dict[str, _Driven]:
    """Return what follows the coordinate map, by name of the joint coordinate."""
    mechanism, n = states.mechanism, len(states)
    coordinates = mechanism.coordinates
    used = set[str]().union(*map(symbols_in, coordinates.driven.values()))
    places = {name: k for k, name in enumerate(mechanism.velocities)}
    # along a motion at rest, ∂/∂t; along one with v = q in one coordinate, q ∂/∂q as well
    v = np.zeros((1 + len(used), n, mechanism.nv))
    for k, name in enumerate(used & set(coordinates)):
        v[1 + k, :, places[f"{name}'"]] = states.q[:, coordinates.index(name)]
    q, t = np.tile(states.q, (len(v), 1)), np.tile(states.t, len(v))
    many = replace(states, q=q, v=v.reshape(-1, mechanism.nv), t=t, a=np.zeros((len(q), 0)))
    found = {}
    for name, c in driven_paths(many).items():
        parts = (c[0, 0], c[1, 0], c[0, 1:], c[1, 1:])
        r, rate, slope, bend = (part.reshape(*part.shape[:-1], len(v), n) for part in parts)
        size = np.abs(r[0]) + np.abs(rate[0] * states.t) + np.abs(rate[1:] - rate[0]).sum(axis=0)
        first = bend[:, 0]
        own = np.abs(slope[:, 0]) + np.abs(first * states.t)
        own += np.abs(bend[:, 1:] - first[:, None]).sum(axis=1)
        found[name] = _Driven(size, own.T, not (np.any(bend) or np.any(rate[0])))
    return found
