"""The inputs of a program: time, coordinates, velocities, torques, accelerations, parameters."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property, partial
from math import inf
from typing import Any, NamedTuple, Protocol, final

from mecanique.derivation.tree.poses import (
    Arithmetic,
    combination,
    quaternion_product,
    quaternion_rotation,
)
from mecanique.errors import DerivationError
from mecanique.model.expression import Scalar, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.program.sweeps import push_forward
from mecanique.program.tape import Tape, Value
from mecanique.program.traced import call, trace, values_of


class DrivenPath(NamedTuple):
    """A joint coordinate r = φ(q, t) that the coordinate map drives."""

    r: Any
    rate: Any
    second: Any  # rate of the rate at constant generalized velocities
    slopes: Any  # derivatives of the rate by the generalized velocities


class LetterValues(Protocol):
    """The values of a mechanism's letters, on a tape or as arrays of many states."""

    mechanism: Mechanism
    arithmetic: Arithmetic
    values: dict[str, Any]

    def number(self, scalar: Scalar, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar of the description."""

    def call(self, function: str, *arguments: Any) -> Any:
        """Return a function's value, e.g. "sqrt" of one argument."""

    def vector(self, components: Sequence[Any]) -> Any:
        """Return scalars, or vectors of them, as one vector of the kind that laws compute with."""

    def driven_paths(self) -> dict[str, DrivenPath]:
        """Return the path of each coordinate that the coordinate map drives, by name."""


@final
class Letters:
    """A mechanism's inputs on a tape."""

    def __init__(
        self,
        mechanism: Mechanism,
        open: Collection[str] = (),  # noqa: A002
        most: float = inf,
    ) -> None:
        mechanism.refuse_switching("programs are written for one mode alone")
        self.mechanism = mechanism
        self.tape = Tape(most=most)
        self.arithmetic = Arithmetic(lambda name: partial(call, self.tape, name))
        self.t = self._input("t")
        self.q = [self._input(name) for name in mechanism.coordinates]
        self.v = [self._input(name) for name in mechanism.velocities]
        self.tau = [self._input(f"tau {name}") for name in mechanism.velocities]
        self.a = [self._input(f"a {name}") for name in mechanism.velocities]
        self.values: dict[str, Any] = {
            "t": self.t,
            **dict(zip(mechanism.coordinates, self.q, strict=True)),
            **dict(zip(mechanism.velocities, self.v, strict=True)),
        }
        """The value of time and of each coordinate, velocity, parameter and signal, by name."""
        for parameter in mechanism.parameters:
            kept = parameter.symbol in open
            self.values[parameter.symbol] = (
                self._input(parameter.symbol) if kept else parameter.value
            )
        self.signals: list[str] = []
        """Signals that remain inputs: constants, which a controller may set, and functions of t."""
        for signal in mechanism.inputs:
            symbol = signal.symbol
            if callable(signal.signal) or (isinstance(signal.signal, float) and symbol in open):
                self.signals.append(symbol)
                self.values[symbol] = self._input(symbol)
            else:
                self.values[symbol] = self.arithmetic(signal.signal, self.values)
        self.open = (
            *(p.symbol for p in mechanism.parameters if p.symbol in open),
            *self.signals,
        )
        """Symbols of the parameters and signals that are inputs, in order."""

    def differentiate(self, scalar: Any, letter: Any) -> Any:
        """Return the derivative of a scalar by an input."""
        (slope,) = push_forward(self.tape, values_of([scalar]), {letter.place: 1.0})
        return trace(self.tape, slope)

    def slopes(self, scalar: Any, rate: Any) -> list[Any]:
        """Return the derivatives of a scalar's rate by each velocity."""
        plain = {f"{name}'": q for name, q in zip(self.mechanism.coordinates, self.q, strict=True)}
        return [
            self.differentiate(*((scalar, plain[name]) if name in plain else (rate, v)))
            for name, v in zip(self.mechanism.velocities, self.v, strict=True)
        ]

    @cached_property
    def rates(self) -> list[Any]:
        """The rates of the coordinates: q' = v, and p' = ½ p ⊗ ω for a quaternion p."""
        values, rates_of = self.values, dict[str, Any]()
        for joint in self.mechanism.joints:
            if not joint.quaternion:
                continue
            p = [values[name] for name in joint.quaternion]
            omega = [values[name] for name in joint.angular_velocities]
            halves = [part * 0.5 for part in quaternion_product(p, omega)]
            rates_of |= zip(joint.quaternion, halves, strict=True)
            velocity = [values[name] for name in joint.linear_velocities]
            for name, row in zip(joint.linear_coordinates, quaternion_rotation(*p), strict=False):
                rates_of[name] = combination(row, velocity)
        return [
            rates_of[name] if name in rates_of else values[f"{name}'"]
            for name in self.mechanism.coordinates
        ]

    def number(self, scalar: Scalar, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar of the description."""
        return self.arithmetic(scalar, values)

    def call(self, function: str, *arguments: Any) -> Any:
        """Return a function's value on the tape, e.g. "sqrt" of one argument."""
        return call(self.tape, function, *arguments)

    def vector(self, components: Sequence[Any]) -> list[Any]:
        """Return scalars as a list."""
        return list(components)

    def driven_paths(self) -> dict[str, DrivenPath]:
        """Return the path of each coordinate that the coordinate map drives, by name."""
        mechanism, paths = self.mechanism, dict[str, DrivenPath]()
        for name, scalar in mechanism.coordinates.driven.items():
            for symbol in self.signals:
                if symbol in symbols_in(scalar):
                    raise DerivationError(
                        f"the map of coordinate {name!r} depends on input {symbol!r}, whose rates "
                        "are not known; give it as an expression in t"
                    )
            r = self.arithmetic(scalar, self.values)
            (rate,) = self.along([r])
            (second,) = self.along([rate])
            paths[name] = DrivenPath(r, rate, second, self.slopes(r, rate))
        return paths

    def along(self, scalars: Sequence[Any], known: Mapping[int, Value] | None = None) -> list[Any]:
        """Return the rates of scalars at constant v; those known on the tape are taken as given."""
        places = [q.place for q in self.q]
        rates: dict[int, Value] = dict(known or {})
        rates |= zip(places, values_of(self.rates), strict=True)
        rates[self.t.place] = 1.0
        moved = push_forward(self.tape, values_of(scalars), rates)
        return [trace(self.tape, value) for value in moved]

    def _input(self, name: str) -> Any:
        return trace(self.tape, self.tape.input(name))
