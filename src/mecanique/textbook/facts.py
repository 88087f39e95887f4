"""Closed-form facts about a system: what theory states, as pure data.

A fact has a statement, one line that can be read aloud, and a formula for the numbers.
`mecanique.verification.facts` checks whether it holds for the mechanism as described.

A formula is a function of `Values`, with parameters, options, coordinates and time as attributes
and velocities by name, so that `lambda s: -s.c * s["x'"] / s.m` reads like the formula it is.
Conserved quantities are also evaluated at complex numbers; write them with numpy's functions and
without `abs` or comparisons.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias, final

from mecanique.errors import UnknownNameError

Number: TypeAlias = Any
"""A float; a complex number where a conserved quantity is differentiated."""


@final
@dataclass(frozen=True)
class Values:
    """Numbers by name: `s.m` or `s["m"]`; a velocity is `s["q'"]`.

    Args:
        numbers: parameters, options, coordinates, velocities and t.
    """

    numbers: Mapping[str, Number]

    def __getitem__(self, name: str) -> Number:
        if name not in self.numbers:
            raise UnknownNameError("quantity of a fact", name, self.numbers)
        return self.numbers[name]

    def __getattr__(self, name: str) -> Number:
        # Python itself looks up names with underscores, e.g. to make a copy
        if name.startswith("_") or name not in self.numbers:
            raise AttributeError(
                f"a fact asks for {name!r}, which is no parameter, option, coordinate or t"
            )
        return self.numbers[name]


Formula: TypeAlias = Callable[[Values], Any]
"""Compute the numbers of a fact."""

State: TypeAlias = "Mapping[str, float] | Callable[[Values], Mapping[str, float]]"
"""Coordinates and velocities by name, zero where left out; or a function of the parameters."""


@dataclass(frozen=True)
class _Stated:
    """The fields common to all facts.

    Args:
        statement: the fact in one line, with its formula.
        given: parameters and options it assumes, by symbol, e.g. {"c": 0.0}; the others may have
            any value.
    """

    statement: str
    given: Mapping[str, float] = field(default_factory=dict, kw_only=True)


@final
@dataclass(frozen=True)
class Acceleration(_Stated):
    """The equations of motion solved for the accelerations, at any state.

    Args:
        formula: gives v', shape (nv,).
    """

    formula: Formula


@final
@dataclass(frozen=True)
class MassMatrix(_Stated):
    """The mass matrix at any state.

    Args:
        formula: gives M, shape (nv, nv).
    """

    formula: Formula


@final
@dataclass(frozen=True)
class KineticEnergy(_Stated):
    """The kinetic energy at any state.

    Args:
        formula: gives T [J].
    """

    formula: Formula


@final
@dataclass(frozen=True)
class Reaction(_Stated):
    """The force in a joint at any state; in all, where something not described guides across it.

    Args:
        joint: its name.
        formula: gives the force of the parent on the child in world axes, shape (3,) [N].
    """

    joint: str
    formula: Formula


@final
@dataclass(frozen=True)
class GuideForce(_Stated):
    """The force of an element that guides at any state, e.g. the tension of a cord.

    Args:
        force: its name.
        formula: gives its size [N].
    """

    force: str
    formula: Formula


@final
@dataclass(frozen=True)
class Conserved(_Stated):
    """Quantities that stay constant along every motion.

    Args:
        formula: gives one number or several, at any state.
    """

    formula: Formula


@final
@dataclass(frozen=True)
class Solution(_Stated):
    """A motion in closed form.

    Args:
        start: the state at t = 0.
        formula: gives coordinates and velocities by name at time t; missing ones are not compared.
        until: gives the end of the comparison [s].
    """

    start: State
    formula: Callable[[Values], Mapping[str, float]]
    until: Formula


@final
@dataclass(frozen=True)
class Period(_Stated):
    """A motion that returns to its start, with its period.

    Args:
        start: the state at t = 0.
        seconds: gives the period [s].
        advance: how far coordinates advance in a period, e.g. a full turn.
    """

    start: State
    seconds: Formula
    advance: State = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Frequencies(_Stated):
    """All natural frequencies of small undamped motion about an equilibrium.

    Args:
        formula: gives ω, in any order [rad/s]; zero for a coordinate without stiffness.
        at: the equilibrium.
    """

    formula: Formula
    at: State = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Eigenvalues(_Stated):
    """Exponents λ of small deviations e^(λ t) from an equilibrium or a steady motion.

    Args:
        formula: gives λ, complex [1/s]; not necessarily all of them.
        at: the equilibrium or steady motion.
    """

    formula: Formula
    at: State = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Steady(_Stated):
    """A state without acceleration: an equilibrium or a steady precession."""

    at: State


@final
@dataclass(frozen=True)
class StabilityLimit(_Stated):
    """The value of a parameter at which an equilibrium ceases to be stable.

    Args:
        parameter: its symbol.
        formula: gives the limit, from the other parameters.
        stable: the side on which the equilibrium is stable, "below" or "above".
        at: the equilibrium.
        period: gives the period of a parametric excitation [s]; stability is then Floquet's.
    """

    parameter: str
    formula: Formula
    stable: str
    at: State = field(default_factory=dict)
    period: Formula | None = None


@final
@dataclass(frozen=True)
class ModeAcceleration(_Stated):
    """The accelerations in one mode of what switches, at any state.

    Args:
        states: the state of each element, in order.
        formula: gives v', shape (nv,).
    """

    states: tuple[str, ...]
    formula: Formula


@final
@dataclass(frozen=True)
class Occurs(_Stated):
    """What is so when something happens in the default motion, for the typical values.

    Args:
        event: its name, or "end" for the end of the motion.
        formula: gives, by name, the time "t", coordinates and velocities there, and velocities
            after an impact as "after x'"; it may ask for the state there.
        which: which of the events of this name, counted from 0.
    """

    event: str
    formula: Callable[[Values], Mapping[str, float]]
    which: int = 0


@final
@dataclass(frozen=True)
class Lasting(_Stated):
    """Quantities that stay constant in the default motion, through all modes and impacts.

    Args:
        formula: gives one number or several, at any state.
    """

    formula: Formula


Fact: TypeAlias = (
    Acceleration
    | MassMatrix
    | KineticEnergy
    | Reaction
    | GuideForce
    | Conserved
    | Solution
    | Period
    | Frequencies
    | Eigenvalues
    | Steady
    | StabilityLimit
    | ModeAcceleration
    | Occurs
    | Lasting
)


def swing_period(length: Number, g: Number, amplitude: float) -> Number:
    """Return the period 4 sqrt(l/g) K(sin(A/2)) of a pendulum (Landau & Lifshitz, sect. 11).

    Args:
        length: of the mathematical pendulum that swings alike [m].
        g: acceleration of free fall [m/s²].
        amplitude: A [rad].
    """
    from scipy.special import ellipk

    return 4 * (length / g) ** 0.5 * ellipk(math.sin(amplitude / 2) ** 2)
