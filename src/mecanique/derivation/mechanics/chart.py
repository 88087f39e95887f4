"""Map generalized to joint coordinates on a tape: u = G v + φ_t, u̇ = G a + γ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.vectors import Rows, dot, products, transpose
from mecanique.derivation.tree.links import Link
from mecanique.errors import DerivationError
from mecanique.model.expression import symbols_in
from mecanique.program.sweeps import push_forward
from mecanique.program.tape import Value
from mecanique.program.traced import Traced, trace, value_of


@final
@dataclass(frozen=True)
class JointMotion:
    """The motion of the joints."""

    r: dict[str, Any]  # value of each joint coordinate and of every input, by name
    u: list[Any]  # joint velocities, in the order of the tree
    gamma: list[Any]  # their rates at constant generalized velocities
    G: Rows  # rows of ∂u/∂v

    def spread(self, a: Sequence[Any]) -> list[Any]:
        """Return G a + γ."""
        return [dot(row, a) + rest for row, rest in zip(self.G, self.gamma, strict=True)]

    def project(self, tau: Sequence[Any]) -> list[Any]:
        """Return Gᵀ τ."""
        return [dot(column, tau) for column in zip(*self.G, strict=True)]

    def project_matrix(self, M: Rows) -> Rows:
        """Return Gᵀ M G."""
        columns = transpose(self.G)
        return products(columns, products(columns, M))


def along(
    letters: Letters, scalars: Sequence[Any], known: Mapping[int, Value] | None = None
) -> list[Any]:
    """Return the rates of scalars at constant v; those known on the tape are taken as they are."""
    tape = letters.tape
    rates = {
        name.place: value_of(rate) for name, rate in zip(letters.q, letters.rates, strict=True)
    }
    rates[letters.t.place] = 1.0
    outputs = [value_of(scalar) for scalar in scalars]
    return [trace(tape, value) for value in push_forward(tape, outputs, {**(known or {}), **rates})]


def chart_of(letters: Letters, tree: Sequence[Link]) -> JointMotion:
    """Compute the motion of the joints of a tree."""
    mechanism, tape = letters.mechanism, letters.tape
    r = dict(letters.values)
    u: list[Any] = []
    gamma: list[Any] = []
    G: Rows = []
    place = {name: k for k, name in enumerate(mechanism.velocities)}
    for name, scalar in mechanism.coordinates.driven.items():
        for symbol in letters.signals:
            if symbol in symbols_in(scalar):
                raise DerivationError(
                    f"the map of coordinate {name!r} depends on input {symbol!r}, whose rates are "
                    "not known; give it as an expression in t"
                )
        r[name] = letters.arithmetic(scalar, letters.values)
    for name in (name for link in tree for name in link.velocities):
        driven = name.removesuffix("'")
        row: list[Any] = [0.0] * mechanism.nv
        if driven in mechanism.coordinates.driven and name.endswith("'"):
            (rate,) = along(letters, [r[driven]])
            (second,) = along(letters, [rate])
            u.append(rate)
            gamma.append(second)
            for k, q in enumerate(mechanism.coordinates):
                if f"{q}'" in place and isinstance(r[driven], Traced):
                    slope = push_forward(tape, [r[driven].place], {letters.q[k].place: 1.0})
                    row[place[f"{q}'"]] = trace(tape, slope[0])
        else:
            u.append(letters.values[name])
            gamma.append(0.0)
            row[place[name]] = 1.0
        G.append(row)
    return JointMotion(r, u, gamma, G)
