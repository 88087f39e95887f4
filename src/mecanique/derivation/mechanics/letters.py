"""The inputs of a program: time, coordinates, velocities, torques, accelerations, parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import cached_property
from math import inf
from typing import Any, Protocol, final

from mecanique.derivation.tree.poses import Arithmetic
from mecanique.derivation.tree.quaternions import quaternion_rotation
from mecanique.model.expression import Scalar
from mecanique.model.mechanism import Mechanism
from mecanique.program.tape import Tape
from mecanique.program.traced import trace, value_of


class Values(Protocol):
    """The values of a mechanism's letters, on a tape or as arrays of many states."""

    mechanism: Mechanism
    arithmetic: Arithmetic
    values: dict[str, Any]

    def number(self, scalar: Scalar, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar of the description."""

    def call(self, function: str, *arguments: Any) -> Any:
        """Return a function's value, e.g. "sqrt" of one argument."""


@final
class Letters:
    """A mechanism's inputs on a tape."""

    def __init__(
        self,
        mechanism: Mechanism,
        open: Collection[str] = (),  # noqa: A002
        most: float = inf,
    ) -> None:
        mechanism.refuse_switching("generated programs do")
        self.mechanism = mechanism
        self.tape = Tape(most=most)
        self.arithmetic = arithmetic_on(self.tape)
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

    @cached_property
    def rates(self) -> list[Any]:
        """The rates of the coordinates: q' = v, and p' = ½ p ⊗ ω for a quaternion p."""
        values, rates_of = self.values, dict[str, Any]()
        for joint in self.mechanism.joints:
            if not joint.quaternion:
                continue
            *position, px, py, pz, pw = joint.coordinates
            x, y, z, w = (values[name] for name in (px, py, pz, pw))
            a, b, c = (values[name] for name in joint.angular_velocities)
            rates_of[px] = (w * a + y * c - z * b) * 0.5
            rates_of[py] = (w * b + z * a - x * c) * 0.5
            rates_of[pz] = (w * c + x * b - y * a) * 0.5
            rates_of[pw] = (x * a + y * b + z * c) * -0.5
            turn = quaternion_rotation(x, y, z, w)
            velocity = [values[name] for name in joint.linear_velocities]
            for name, row in zip(position, turn, strict=False):
                rates_of[name] = sum((r * u for r, u in zip(row, velocity, strict=True)), 0.0)
        return [
            rates_of[name] if name in rates_of else values[f"{name}'"]
            for name in self.mechanism.coordinates
        ]

    def number(self, scalar: Scalar, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar of the description."""
        return self.arithmetic(scalar, values)

    def call(self, function: str, *arguments: Any) -> Any:
        """Return a function's value on the tape, e.g. "sqrt" of one argument."""
        return trace(self.tape, self.tape.call(function, *map(value_of, arguments)))

    def _input(self, name: str) -> Any:
        return trace(self.tape, self.tape.input(name))


def arithmetic_on(tape: Tape) -> Arithmetic:
    """Return the arithmetic of poses and expressions on a tape."""

    def function(name: str) -> Callable[..., Any]:
        return lambda *a: trace(tape, tape.call(name, *map(value_of, a)))

    return Arithmetic(function)
