"""Equations of one system in two sets of generalized coordinates: identical up to a linear transformation.

With x = φ(y, t) and J = ∂φ/∂y, equations M(x) x'' + b = Q become Jᵀ M J y'' + Jᵀ (b + M γ) = Jᵀ Q,
where x'' = J y'' + γ: the equations in y are Jᵀ times those in x (Fundamentals of Dynamics, sect.
1.3.4; Goldstein, Classical Mechanics, 1980, ch. 1, derivation 10).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.derivation import derive
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.expression import Scalar, evaluate, plain, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.verification.difference import relative_difference, scaled
from mecanique.verification.rows import TOLERANCE
from mecanique.verification.states.random import random_states

__all__ = ["Transformation", "transformation"]

Array = npt.NDArray[np.float64]


@final
@dataclass(frozen=True)
class Transformation:
    """How the equations in one set of coordinates follow from those in another, and how well they do.

    Args:
        first: name of the mechanism with the coordinates x.
        second: name of the mechanism with the coordinates y.
        map: x = φ(y, t), the expression of each coordinate by its name.
        rows: names of x.
        columns: names of y.
        jacobian: J = ∂φ/∂y, sympy expressions, by row.
        worst: largest relative difference of each quantity over the states.
        samples: number of states.
    """

    first: str
    second: str
    map: Mapping[str, Any]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    jacobian: tuple[tuple[Any, ...], ...]
    worst: Mapping[str, float]
    samples: int

    @property
    def agrees(self) -> bool:
        """Whether Jᵀ times the first equations are the second ones, within the tolerance of a verdict."""
        return all(value <= TOLERANCE for value in self.worst.values())

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
        return "\n".join(
            [
                *lines,
                f"  They {verdict} at {self.samples} random states (largest relative differences).",
            ]
        )


def transformation(
    first: Mechanism,
    second: Mechanism,
    relations: Mapping[str, Scalar],
    samples: int = 100,
    seed: int = 0,
) -> Transformation:
    """Compare the equations of motion of one system in two sets of generalized coordinates.

    Args:
        first: the system in coordinates x.
        second: the same system in coordinates y.
        relations: each coordinate of the first as an expression in those of the second, its
            parameters and time; a coordinate that is left out has the same name in both.
        samples: number of random states of the second, at least 1.
        seed: of the random states.

    Raises:
        InputError: if a coordinate is a quaternion's, or an expression has no value.
        UnknownNameError: if a name is no coordinate.
        DerivationError: if a system cannot be derived.
    """
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
    by_name = {symbol.name: symbol for e in phi.values() for symbol in e.free_symbols}
    variables = [by_name.get(name, Symbol(name)) for name in y]
    time = by_name.get("t", Symbol("t"))
    rates = [Symbol(f"{name}'") for name in y]
    J = [[diff(phi[name], variable) for variable in variables] for name in x]
    drift = [diff(phi[name], time) for name in x]
    velocity = [
        sum(slope * rate for slope, rate in zip(row, rates, strict=True)) + d
        for row, d in zip(J, drift, strict=True)
    ]
    gamma = [
        sum(diff(v, variable) * rate for variable, rate in zip(variables, rates, strict=True))
        + diff(v, time)
        for v in velocity
    ]
    states = random_states(second, samples, seed)
    n = len(states)
    values = {**second.values, "t": states.t, **dict(zip(y, states.q.T, strict=True))}
    values |= dict(zip(second.velocities, states.v.T, strict=True))

    def numbers(expressions: list[Any]) -> Array:
        with np.errstate(all="ignore"):
            columns = [
                np.broadcast_to(np.asarray(evaluate(e, values), dtype=float), (n,))
                for e in expressions
            ]
        return np.stack(columns, axis=1)

    q, v, turn = (
        numbers([phi[name] for name in x]),
        numbers(velocity),
        numbers([e for row in J for e in row]),
    )
    bent, slope = numbers(gamma), turn.reshape(n, len(x), len(y))
    if not all(np.isfinite(part).all() for part in (q, v, slope, bent)):
        raise InputError(
            f"the map of {first.name!r} has no finite value at some states of {second.name!r}"
        )
    one, other = derive(first), derive(second)
    M = one.mass_matrix(q, states.t)
    rest = one.bias(q, v, states.t) - one.forces(q, v, states.t) + np.einsum("nij,nj->ni", M, bent)
    found = {
        "mass matrix": np.einsum("nki,nkl,nlj->nij", slope, M, slope),
        "bias": np.einsum("nki,nk->ni", slope, rest),
        "acceleration": np.zeros((n, len(y))),
    }
    expected = {
        "mass matrix": other.mass_matrix(states.q, states.t),
        "bias": other.bias(states.q, states.v, states.t)
        - other.forces(states.q, states.v, states.t),
        "acceleration": other.acceleration(states.q, states.v, states.t),
    }
    found["acceleration"] = np.linalg.solve(found["mass matrix"], -found["bias"][..., None])[..., 0]
    weight = (
        sum(second.evaluate(body.mass) for body in second.bodies if body.name != second.ground)
        or 1.0
    )
    worst = {}
    for quantity in found:
        a, b = (
            scaled(quantity, part[quantity], expected["mass matrix"]) for part in (found, expected)
        )
        worst[quantity] = float(
            relative_difference(a, b, 1.0 if quantity == "mass matrix" else weight**0.5).max()
        )
    return Transformation(
        first.name,
        second.name,
        phi,
        tuple(x),
        tuple(y),
        tuple(tuple(row) for row in J),
        {
            "mass matrix": worst["mass matrix"],
            "all other terms": worst["bias"],
            "acceleration": worst["acceleration"],
        },
        n,
    )
