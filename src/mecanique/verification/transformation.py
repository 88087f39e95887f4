"""Compare the equations of one system in two sets of generalized coordinates.

With x = φ(y, t) and J = ∂φ/∂y, equations M(x) x'' + b = Q become Jᵀ M J y'' + Jᵀ (b + M γ) = Jᵀ Q,
where x'' = J y'' + γ: the equations in y are Jᵀ times those in x (Fundamentals of Dynamics, sect.
1.3.4; Goldstein, Classical Mechanics, 1980, ch. 1, derivation 10).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.derivation.numeric.paths import constant_jet, coordinate_paths
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.expression import Scalar, evaluate, plain, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.rows import differ_by, moving_mass
from mecanique.verification.states import random_states
from mecanique.verification.verdict import SOLVED_ALIKE

Expressions: TypeAlias = list[Any]


@final
@dataclass(frozen=True)
class Transformation:
    """How well the equations in one set of coordinates follow from those in another."""

    first: str  # name of the mechanism with the coordinates x
    second: str  # name of the mechanism with the coordinates y
    map: Mapping[str, Any]  # x = φ(y, t), the expression of each coordinate by its name
    rows: tuple[str, ...]  # names of x
    columns: tuple[str, ...]  # names of y
    jacobian: tuple[tuple[Any, ...], ...]  # J = ∂φ/∂y, sympy expressions, by row
    worst: Mapping[str, float]  # largest relative difference of each quantity over the states
    samples: int  # number of states

    @property
    def agrees(self) -> bool:
        """Whether Jᵀ times the first equations gives the second ones."""
        return all(value <= SOLVED_ALIKE for value in self.worst.values())

    def __str__(self) -> str:
        lines = [
            f"{self.second} from {self.first}:",
            *(f"  {name} = {self.map[name]}" for name in self.rows),
        ]
        width = max(len(name) for name in self.rows)
        lines.append(f"  J = d({', '.join(self.rows)})/d({', '.join(self.columns)}):")
        lines += [
            f"    {name:<{width}}  [{', '.join(map(str, row))}]"
            for name, row in zip(self.rows, self.jacobian, strict=True)
        ]
        lines.append("  The transpose of J times the first equations of motion gives the second:")
        lines += [f"    {name:<14} {value:.1e}" for name, value in self.worst.items()]
        verdict = "agree" if self.agrees else "DISAGREE"
        lines.append(
            f"  They {verdict} at {self.samples} random states (largest relative differences)."
        )
        return "\n".join(lines)


class _Motion(NamedTuple):
    """x = φ(y, t), x' = J y' + ∂φ/∂t, J and γ of x'' = J y'' + γ, at n states."""

    q: Array
    v: Array
    jacobian: Array
    gamma: Array


def compare_coordinates(
    first: Mechanism,
    second: Mechanism,
    relations: Mapping[str, Scalar],
    samples: int = 100,
    seed: int = 0,
) -> Transformation:
    """Compare the equations of motion of one system in two sets of generalized coordinates."""
    # a coordinate that the relations leave out has the same name in both
    x, y = first.coordinates.names, second.coordinates.names
    phi, jacobian = _differentiate(first, second, relations)
    states = random_states(second, samples, seed)
    motion = _evaluate(phi, states)
    if not all(np.isfinite(part).all() for part in motion):
        raise InputError(
            f"the map of {first.name!r} has no finite value at some states of {second.name!r}"
        )
    transformed = _transform(first, motion, states)
    equations, (q, v, t) = derive(second), (states.q, states.v, states.t)
    expected = {
        "mass matrix": equations.mass_matrix(q, t),
        "bias": equations.bias(q, v, t) - equations.forces(q, v, t),
        "acceleration": equations.acceleration(q, v, t),
    }
    mass = moving_mass(second)
    worst = {}
    for quantity, values in transformed.items():
        least = 1.0 if quantity == "mass matrix" else mass**0.5
        M = expected["mass matrix"]
        worst[quantity] = float(differ_by(quantity, values, expected[quantity], M, least).max())
    return Transformation(
        first=first.name,
        second=second.name,
        map=dict(zip(x, phi, strict=True)),
        rows=tuple(x),
        columns=tuple(y),
        jacobian=tuple(map(tuple, jacobian)),
        worst={
            "mass matrix": worst["mass matrix"],
            "all other terms": worst["bias"],
            "acceleration": worst["acceleration"],
        },
        samples=len(states),
    )


def _differentiate(
    first: Mechanism, second: Mechanism, relations: Mapping[str, Scalar]
) -> tuple[Expressions, list[Expressions]]:
    """Check the map between two sets of coordinates; return φ and ∂φ/∂y."""
    from sympy import Symbol, diff, sympify

    x, y = first.coordinates.names, second.coordinates.names
    if len(first.velocities) != len(x) or len(second.velocities) != len(y):
        raise InputError(
            "expected coordinates whose rates are the velocities, got those of a quaternion's joint"
        )
    for name in relations:
        if name not in x:
            raise UnknownNameError("coordinate", name, x)
    phi = {
        name: sympify(plain(relations[name])) if name in relations else Symbol(name) for name in x
    }
    known = {*y, *second.values, "t"}
    for name, expression in phi.items():
        for symbol in sorted(symbols_in(expression) - known):
            raise UnknownNameError(f"symbol in the map of {name!r}", symbol, sorted(known))
    # the expressions' own symbols, whatever is assumed of them
    symbols = {symbol.name: symbol for e in phi.values() for symbol in e.free_symbols}
    variables = [symbols.get(name, Symbol(name)) for name in y]
    jacobian = []
    for name in x:
        jacobian.append([diff(phi[name], variable) for variable in variables])
    return [phi[name] for name in x], jacobian


def _evaluate(phi: Expressions, states: States) -> _Motion:
    """Differentiate the map along the motion, on jets."""
    paths = coordinate_paths(states)
    shape = (3, 1 + states.mechanism.nv, len(states))
    with np.errstate(all="ignore"):
        values = [evaluate(expression, paths, function=function) for expression in phi]
    jets = [x if isinstance(x, Jet) else constant_jet(x, shape) for x in values]
    c = np.stack([jet.c for jet in jets], axis=-1)
    return _Motion(c[0, 0], c[1, 0], np.moveaxis(c[0, 1:], 0, -1), 2 * c[2, 0])


def _transform(first: Mechanism, motion: _Motion, states: States) -> dict[str, Array]:
    """Return Jᵀ times the equations of the first: M_y = Jᵀ M J, bias Jᵀ (M γ + bias − forces)."""
    equations, (q, v, J, gamma) = derive(first), motion
    M = equations.mass_matrix(q, states.t)
    rest = (
        equations.bias(q, v, states.t)
        - equations.forces(q, v, states.t)
        + np.einsum("nij,nj->ni", M, gamma)
    )
    mass = np.einsum("nki,nkl,nlj->nij", J, M, J)
    bias = np.einsum("nki,nk->ni", J, rest)
    acceleration = np.linalg.solve(mass, -bias[..., None])[..., 0]
    return {"mass matrix": mass, "bias": bias, "acceleration": acceleration}
