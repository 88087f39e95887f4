"""Adjoin the symbols of a mechanism to the ring of Poisson series."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import chain, count
from typing import Any, final

import numpy as np

from mecanique.derivation.numeric.newton_euler import refuse_misfits
from mecanique.derivation.scalars.elementary import sqrt
from mecanique.derivation.scalars.evaluation import evaluate as value_of
from mecanique.derivation.scalars.functions import function_without_arcs
from mecanique.derivation.scalars.polynomials import REACH
from mecanique.derivation.scalars.series import CONSTANTS, FOLLOWER, Ring, Series
from mecanique.derivation.tree.links import links
from mecanique.derivation.tree.poses import (
    Arithmetic,
    combination,
    joint_values,
    quaternion_product,
    quaternion_rotation,
)
from mecanique.model import Joint, Mechanism
from mecanique.model.expression import Scalar, evaluate, symbols_in
from mecanique.model.mechanism.letters import letters_of_words
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.random_positions import draw_positions

MOST_TERMS = 5_000
"""The longest series: enough for a robot with six hinges; longer ones are refused in seconds."""

_GRAVITY, _LENGTH, _RATE = 1, 2, 3
"""Positions in a product, after masses and forces: m g l, m l², m l Ω²."""


@final
class Algebra:
    """The symbols of a mechanism as series."""

    # Velocities are q' for a coordinate q and quasi-velocities for a quaternion joint;
    # accelerations are their rates

    def __init__(self, mechanism: Mechanism) -> None:
        refuse_misfits(mechanism)
        self.mechanism = mechanism
        self.ring = ring = Ring(most_terms=MOST_TERMS)
        ring.letters = letters_of_words(mechanism)
        self.arithmetic = Arithmetic(function_without_arcs, self.number)
        self.velocities = mechanism.velocities
        self.accelerations = tuple(f"{name}'" for name in self.velocities)
        self._swings: dict[Series, Series] = {}
        values: dict[str, Any] = {}
        quasi = {joint.coordinates[0]: joint for joint in mechanism.joints if joint.quaternion}
        for name in mechanism.coordinates:
            if name in quasi:
                values |= self._quaternion(quasi[name])
            elif name not in values:
                values[name] = ring.coordinate(name)
                values[f"{name}'"] = ring[f"{name}'"]
        for parameter in mechanism.parameters:
            values[parameter.symbol] = ring.parameter(parameter.symbol)
            ring.places[parameter.symbol] = _place(parameter.unit)
        mapped = frozenset().union(
            *(symbols_in(scalar) for scalar in mechanism.coordinates.driven.values())
        )
        for signal in mechanism.inputs:
            values[signal.symbol] = ring.input(signal.symbol, 2 if signal.symbol in mapped else 0)
        values["t"] = ring.time
        self.values: dict[str, Any] = joint_values(mechanism, values, self.arithmetic)
        """Each parameter, input, generalized or joint coordinate, velocity and t, by name."""
        # joints turn by multiples of an angle: of q/20 for joints at 0.3 q and q/4
        units: dict[int, int] = {}
        for link in links(self.mechanism):
            angle = self.values.get(link.coordinates[0]) if link.kind == "turn" else None
            if isinstance(angle, Series) and angle.parts.keys() <= {0}:
                for _, monomial, multiple in angle.terms():
                    units[monomial] = math.lcm(units.get(monomial, 1), multiple.denominator)
        for monomial, unit in units.items():
            if monomial and 1 < unit <= REACH:
                self.ring.angle(monomial, Fraction(1, unit))
        self._name_angles()

    def say(self, sentence: str, **names: Sequence[str]) -> str:
        """Return a sentence with letters for those in brackets, or names if they have a meaning."""
        # " [a]" becomes " a", or " a_crank" in a mechanism with a length a
        taken = {*self.values, *self.mechanism.coordinates}

        def choose(marked: re.Match[str]) -> str:
            listed = names.get(marked[1], ()) if marked[1] in taken else marked[1]
            joint = " and " if len(listed) == 2 else " to "
            return " " * bool(listed) + joint.join(dict.fromkeys([*listed[:1], *listed[-1:]]))

        return re.sub(r" \[(\w)\]", choose, sentence)

    def _name_angles(self) -> None:
        """Name joint angles that swing, such as B cos(W t), so that they have sine and cosine."""
        for link in links(self.mechanism):
            name = link.coordinates[0] if link.kind == "turn" else ""
            angle = self.values.get(name)
            if not isinstance(angle, Series) or angle.parts.keys() <= {0}:
                continue
            for atom, named in self._swings.items():
                if angle in (atom, -atom):
                    self.values[name] = named if angle == atom else -named
                    break
            else:
                self._swings[angle] = self.values[name] = self.ring.adjoin(
                    FOLLOWER, angle, lambda _: self.ring.number(1), lambda u: u, name
                )

    def number(self, constant: Any) -> Series:
        """Return a constant as a series, exact if it is recognized as a root or a fraction."""
        if isinstance(constant, Fraction):
            return self.ring.number(constant)
        if isinstance(constant, (int, float)) or constant.is_Float:
            return self._float(float(constant))
        if constant.is_Rational:
            return self.ring.number(Fraction(int(constant.p), int(constant.q)))
        if constant.is_NumberSymbol:
            name = str(constant)
            return self.ring.constant(name) if name in CONSTANTS else self._float(float(constant))
        # a compound number, e.g. sqrt(2) pi, is evaluated as an expression in its parts
        from sympy import Symbol

        base, *rest = constant.args
        if constant.is_Pow and rest[0].is_Rational:
            whole, parts = Symbol("#0") ** rest[0], {"#0": self.number(base)}
        else:
            parts = {f"#{k}": self.number(part) for k, part in enumerate(constant.args)}
            whole = constant.func(*map(Symbol, parts))
        series: Series = evaluate(whole, parts, function=function_without_arcs, number=self.number)
        return series

    def series(self, scalar: Scalar, given: Mapping[str, Series] | None = None) -> Series:
        """Return a scalar of the description as a series; `given` are values of more letters."""
        values = {**self.values, **given} if given else self.values
        return self.lift(self.arithmetic(scalar, values))

    def lift(self, value: Any) -> Series:
        """Return a plain number as a series; return a series unchanged."""
        return value if isinstance(value, Series) else self.ring.number(value)

    def root(self, square: Series) -> Series:
        """Return the square root of a squared distance, positive where all coordinates are zero."""
        names = chain(["rho"], (f"rho{k}" for k in count(2)))
        root: Series = sqrt(square, name=self.ring.choose_name(names))
        return -root if self.at_rest(root) < 0 else root

    def at_rest(self, series: Series) -> float:
        """Return the value of a series with all coordinates zero, at t = 0."""
        zeros = zip(self.mechanism.coordinates, self.mechanism.neutral().tolist(), strict=True)
        values = {**dict(zeros), **self.mechanism.values, "t": 0.0}
        for signal in self.mechanism.inputs:
            values[signal.symbol] = signal.function(self.mechanism.values)(0.0)
        return float(value_of(series, values))

    @cached_property
    def generic(self) -> dict[str, float]:
        """Values of parameters, coordinates, inputs and t at which nothing holds by chance."""
        mechanism = self.mechanism
        random, length = np.random.default_rng(0), characteristic_length(mechanism)
        (q,) = draw_positions(mechanism, 1, random, length).tolist()
        given = {
            name: (value or 0.1) * random.uniform(1.0, 1.1)
            for name, value in mechanism.values.items()
        }
        given |= {"t": 0.3, **dict.fromkeys((s.symbol for s in mechanism.inputs), 0.2)}
        return given | dict(zip(mechanism.coordinates, q, strict=True))

    def _float(self, value: float) -> Series:
        """Return a float as the fraction, or the square root of a fraction, that it represents."""
        series = self.ring.number(value)
        square = Fraction(value * value).limit_denominator(1000)
        if (
            series.denominator > 1_000_000
            and abs(float(square) - value * value) <= 2e-15 * value * value
        ):
            root: Series = sqrt(self.ring.number(square))
            return root if value > 0 else -root
        return series

    def _quaternion(self, joint: Joint) -> dict[str, Series]:
        """Adjoin a quaternion joint's coordinates and velocities, with p' = ½ p ⊗ ω."""
        ring = self.ring
        moved, velocities = ring.quasi_coordinates(joint.coordinates, joint.velocities)
        ring.bind(*joint.coordinates[-4:])
        rates = [part / 2 for part in quaternion_product(moved[-4:], velocities[-3:])]
        if joint.linear_velocities:
            turn = quaternion_rotation(*moved[-4:])
            rates = [combination(row, velocities[:3]) for row in turn] + rates
        for coordinate, rate in zip(moved, rates, strict=True):
            ring.rates[ring.index(coordinate)] = rate
        return dict(
            zip((*joint.coordinates, *joint.velocities), (*moved, *velocities), strict=True)
        )


def _place(unit: str) -> int:
    """Return the position of a parameter within a product, by its unit."""
    if unit in ("m/s²", "m/s^2"):
        return _GRAVITY
    if unit.startswith(("rad/s", "1/s", "m/s", "Hz")):
        return _RATE
    return _LENGTH if unit in ("m", "m²", "m/rad") else 0


def coordinate_of(velocity: str) -> str:
    """Return the coordinate whose rate a velocity is, or a quasi-velocity's own name."""
    return velocity.removesuffix("'")
