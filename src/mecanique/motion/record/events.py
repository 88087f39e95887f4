"""Events of a motion: zero crossings to record, to stop at, or to treat as impacts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias, cast, final

import numpy as np

from mecanique.arrays import Flags
from mecanique.errors import InputError
from mecanique.model.expression import Scalar, compile_scalars, finite, plain
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import find_name
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import UNYIELDING
from mecanique.wording import Legible

Quantity: TypeAlias = Callable[[float, np.ndarray, np.ndarray], float]
"""A function of t, q and v."""

Impact: TypeAlias = Callable[
    [float, np.ndarray, np.ndarray, Callable[[np.ndarray], np.ndarray]], np.ndarray
]
"""A function of t, q, v and a function that returns the velocities after an impulse."""


@final
@dataclass(frozen=True)
class Event:
    """Where a quantity passes zero.

    Args:
        name: its name.
        when: the quantity: the name of a coordinate or velocity, an expression in them, parameters,
            inputs and t, or a function of t, q and v.
        direction: +1 for rising through zero, −1 for falling, 0 for both.
        stop: whether the motion ends there.
        restitution: e in 0…1 for an impact there: the quantity's rate is reversed and multiplied by
            e, by an impulse along the quantity's gradient. The quantity must then depend on
            positions (and t) alone.

    Raises:
        InputError: if a value is not one of these.

    Example:
        >>> bottom = mq.Event("bottom", when="q", direction=-1)
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> motion = mq.simulate(pendulum, q={"q": 0.1}, duration=3.0, events=[bottom])
        >>> motion.times("bottom").round(3)
        array([0.41 , 2.049])
    """

    name: str
    when: Scalar | str | Quantity
    direction: int = 0
    stop: bool = False
    restitution: float | None = None

    def __post_init__(self) -> None:
        if self.direction not in (-1, 0, 1):
            raise InputError(
                f"event {self.name!r}: expected direction -1, 0 or 1, got {self.direction!r}"
            )
        if not isinstance(self.when, str) and not callable(self.when):
            object.__setattr__(self, "when", plain(self.when))
        if self.restitution is not None:
            restitution = finite(self.restitution, f"restitution of event {self.name!r}")
            if not 0 <= restitution <= 1:
                raise InputError(
                    f"event {self.name!r}: expected a restitution in 0…1, got {restitution:g}"
                )
            if self.stop:
                raise InputError(f"event {self.name!r}: expected stop or restitution, not both")
            if callable(self.when) and not hasattr(self.when, "free_symbols"):
                raise InputError(
                    f"event {self.name!r}: expected an expression for an impact, got a function"
                )

    def quantity(self, mechanism: Mechanism) -> Quantity:
        """Return the quantity as a function of t, q and v.

        Raises:
            UnknownNameError: if the mechanism has no such name.
        """
        expression = self.expression(mechanism)
        if expression is None:
            return cast("Quantity", self.when)
        call = _functions(mechanism, [expression])
        return lambda t, q, v: float(call(t, q, v)[0])

    def impact(self, mechanism: Mechanism, rates: Rates) -> Impact:
        """Return the function of t, q, v and W that gives the velocities after the impact.

        With n the quantity's gradient by v-directions and ġ its rate, v⁺ = v − W n (1 + e) ġ / (nᵀ
        W n), where W gives the velocities that an impulse causes: M⁻¹, or what the loops leave of
        it (Newton's law of restitution; Greenwood, Principles of Dynamics, 1988, sect. 4-8).

        Args:
            mechanism: the mechanism that moves.
            rates: the maps between v and q̇.

        Raises:
            InputError: if the quantity depends on velocities.
        """
        from sympy import Symbol, diff

        expression = self.expression(mechanism)
        assert expression is not None, "an impact's quantity is an expression"
        held = sorted({symbol.name for symbol in expression.free_symbols} & {*mechanism.velocities})
        if held:
            raise InputError(
                f"event {self.name!r}: an impact depends on positions alone, "
                f"got {', '.join(held)} in it"
            )
        gradient = [diff(expression, Symbol(name)) for name in (*mechanism.coordinates, "t")]
        slope = _functions(mechanism, gradient)
        e = 0.0 if self.restitution is None else self.restitution
        nv = mechanism.nv

        def after(
            t: float, q: np.ndarray, v: np.ndarray, W: Callable[[np.ndarray], np.ndarray]
        ) -> np.ndarray:
            *by_q, by_t = slope(t, q, v)
            n = rates.first(np.repeat(q[None], nv, axis=0), np.eye(nv)) @ np.array(by_q)
            rate = n @ v + by_t
            direction = W(n)
            yielding = float(n @ direction)
            if not yielding > UNYIELDING * float(np.abs(n) @ np.abs(direction)):
                raise InputError(
                    f"event {self.name!r}: no impulse changes its quantity at t = {t:.6g} s; "
                    "it cannot move"
                )
            velocities: np.ndarray = v - direction * ((1 + e) * rate / yielding)
            return velocities

        return after

    def expression(self, mechanism: Mechanism) -> Scalar | None:
        """Return the quantity as an expression; None if it is a function.

        Raises:
            UnknownNameError: if the mechanism has no such name.
        """
        from sympy import Symbol, sympify

        if callable(self.when) and not hasattr(self.when, "free_symbols"):
            return None
        if isinstance(self.when, str):
            names = (*mechanism.coordinates.names, *mechanism.velocities)
            return Symbol(find_name(mechanism, self.when, names, "coordinate or velocity"))
        return sympify(self.when)


class Margins(Protocol):
    """What the conditions of a mode leave in a state, an array that is positive while they hold."""

    def margins(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return it."""


@final
@dataclass(frozen=True)
class Margin:
    """What one condition of a mode leaves, as the quantity of an event."""

    source: Margins
    index: tuple[int, ...]
    switches: bool = False  # whether another mode follows where it is used up

    def __call__(self, t: float, q: np.ndarray, v: np.ndarray) -> float:
        """Return it."""
        return float(self.source.margins(t, q, v)[self.index])


def is_switch(event: Event) -> bool:
    """Return whether another mode follows at an event."""
    return isinstance(event.when, Margin) and event.when.switches


def is_halt(event: Event) -> bool:
    """Return whether integration halts at an event; others are looked for afterwards."""
    return event.stop or event.restitution is not None or is_switch(event)


@final
@dataclass(frozen=True, eq=False, repr=False)
class Occurrence(Legible):
    """An event that took place.

    Args:
        name: of the event.
        t: when [s].
        q: shape (nq,), positions.
        v: shape (nv,), velocities, just before.
        after: shape (nv,), velocities just after; v unless it was an impact.
    """

    name: str
    t: float
    q: np.ndarray
    v: np.ndarray
    after: np.ndarray

    @property
    def impact(self) -> bool:
        """Whether the velocities jump."""
        return not np.array_equal(self.v, self.after)

    def __str__(self) -> str:
        return f"{self.name}: t = {self.t:.9g} s"


@final
@dataclass(frozen=True, repr=False)
class ModeSpan(Legible):
    """A mode and when it held.

    Args:
        begin: when it began [s].
        end: when it ended [s].
        states: the state of each element, by name: "open", "closed", "sticks", "slips +",
            "slips -", or "slips" in space.
    """

    begin: float
    end: float
    states: dict[str, str]

    def __str__(self) -> str:
        listed = ", ".join(f"{name} {state}" for name, state in self.states.items())
        return f"{self.begin:.6g} to {self.end:.6g} s: {listed}"


class Switches(Protocol):
    """What switched on the way of a motion, `switching.corners.Corners`."""

    mechanism: Mechanism  # with its elements that switch
    rubbing: dict[str, list[int]]  # rows of the elements that rub, by name

    def push(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray
    ) -> tuple[dict[str, np.ndarray], dict[str, Flags], dict[str, np.ndarray]]:
        """Return wrenches of contacts, which parts are shared, and forces in joints, by name."""

    def powers(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the heat of each of them, then the power of all elements, shape (n, k) [W]."""


def break_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of the events at which contacts and cords cease to hold, in order."""
    tensions = [name for element in mechanism.elements for name in element.tensions]
    breaks = [name for contact in mechanism.contacts for name in contact.breaks]
    return (*breaks, *(f"{name} would push" for name in tensions))


def _functions(
    mechanism: Mechanism, expressions: list[Scalar]
) -> Callable[[float, np.ndarray, np.ndarray], tuple[float, ...]]:
    values = mechanism.values
    constants = list(values.values())
    signals = [signal.function(values) for signal in mechanism.inputs]
    names = [
        *mechanism.coordinates,
        *mechanism.velocities,
        "t",
        *values,
        *(signal.symbol for signal in mechanism.inputs),
    ]
    function = compile_scalars(expressions, names)

    def call(t: float, q: np.ndarray, v: np.ndarray) -> tuple[float, ...]:
        return function(*q.tolist(), *v.tolist(), t, *constants, *(signal(t) for signal in signals))

    return call
