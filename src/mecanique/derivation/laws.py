"""The law of every force, stated once for all derivations and scalars: series, jets or floats.

A force between two ends acts along x, the distance between two points or the coordinate of a joint,
and pulls the ends together; the virtual work of a pull f is δW = −f δx. Lagrange's equations use
a spring's potential V, as −∂V/∂q, and a damper's Rayleigh function D, as −∂D/∂q'; the balances of
bodies cut free use the pull. A load on a single body needs no law: its components are given.

To add a force: its class in `mecanique.model.forces` and that module's export in the two
`__init__` files, its laws here and in `mecanique.reference.engine.forces.loads`, its tag in
`mecanique.urdf.write` and, if the tag is read back, `mecanique.urdf.reading.extensions`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, Protocol, TypeAlias, final

from mecanique.errors import DerivationError
from mecanique.model.expression import DISTANCE, POSITION, Scalar
from mecanique.model.force_base import AnyForce, BodyLoad
from mecanique.model.forces import (
    CentralForce,
    Damper,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    PotentialField,
    Spring,
)


class LineOfAction(Protocol):
    """The line that a force acts along; e is its unit vector, from end to end, or 1 in a joint."""

    @property
    def name(self) -> str:
        """What potentials call x."""

    @property
    def values(self) -> Mapping[str, Any]:
        """What potentials depend on that is no scalar of the description, by name."""

    @property
    def x(self) -> Any:
        """The distance, or the coordinate."""

    @property
    def square(self) -> Any:
        """x², computed without a square root."""

    @property
    def rate(self) -> Any:
        """The rate x'."""

    def direct(self, slope: Any | None, size: Any | None) -> Any:
        """Return (slope · x + size) e; without size no division by x is needed, as x e is known."""


@final
@dataclass(frozen=True)
class Travel:
    """A joint coordinate that a force acts along, and its rate, as scalars of any kind."""

    x: Any
    rate: Any
    name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def square(self) -> Any:
        """The coordinate's square."""
        return self.x * self.x

    def direct(self, slope: Any | None, size: Any | None) -> Any:
        """Return slope · x + size, leaving out a part that is None."""
        total: Any = 0.0 if slope is None else slope * self.x
        return total if size is None else total + size


@final
@dataclass(frozen=True)
class Elastic:
    """A linear spring: V = ½ k (x − x₀)²."""

    stiffness: Any
    rest: Any

    kind: ClassVar[Literal["potential"]] = "potential"

    def scalar(self, along: LineOfAction) -> Any:
        """Return V; for x₀ = 0 it is smooth where the ends meet."""
        if not self.rest:
            return along.square * self.stiffness / 2
        stretch = along.x - self.rest
        return stretch * stretch * self.stiffness / 2

    def pull(self, along: LineOfAction) -> Any:
        """Return k (x − x₀) e."""
        k = self.stiffness
        return along.direct(k, -(k * self.rest) if self.rest else None)


Number: TypeAlias = Callable[..., Any]
"""Makes a scalar of the description one of a derivation; values of more letters may follow it."""


@final
@dataclass(frozen=True)
class Stored:
    """A given potential V(q, t), of which x is one q, V(x, t) of a distance, or V(x, y, z, t)."""

    potential: Scalar
    number: Number

    kind: ClassVar[Literal["potential"]] = "potential"

    def scalar(self, along: LineOfAction) -> Any:
        """Return V; that of x² is smooth where the ends meet."""
        V = self._of_square(along.name)
        if V is not None:
            return self.number(V, {_SQUARE: along.square})
        return self.number(self.potential, along.values)

    def pull(self, along: LineOfAction) -> Any:
        """Return ∂V/∂x e, for V(x²) as 2 dV/d(x²) x e."""
        V = self._of_square(along.name)
        if V is not None:
            return along.direct(self.number(2 * _slope(V, _SQUARE), {_SQUARE: along.square}), None)
        return along.direct(None, self.number(_slope(self.potential, along.name), along.values))

    @property
    def gradient(self) -> list[Scalar]:
        """The components of grad V, in the letters of V."""
        return [_slope(self.potential, name) for name in POSITION]

    def _of_square(self, name: str) -> Scalar | None:
        """Return V of a distance as a function of its square, if it is one without roots."""
        import sympy

        if name != DISTANCE:
            return None
        s = sympy.Symbol(_SQUARE, positive=True)
        V = sympy.sympify(self.potential).subs(sympy.Symbol(name), sympy.sqrt(s))
        whole = all(power.exp.is_integer for power in V.atoms(sympy.Pow) if power.base == s)
        return V.subs(s, sympy.Symbol(_SQUARE)) if whole else None


_SQUARE = "distance^2"
"""Name of x² in a potential; no letter of a description has it."""


def _slope(V: Scalar, name: str) -> Scalar:
    import sympy

    # a real symbol, so that |x| has the derivative sign(x)
    x, real = sympy.Symbol(name), sympy.Symbol(name, real=True)
    return sympy.sympify(V).subs(x, real).diff(real).xreplace({real: x})


@final
@dataclass(frozen=True)
class Viscous:
    """A linear damper: Rayleigh's D = ½ c x'²."""

    damping: Any

    kind: ClassVar[Literal["dissipation"]] = "dissipation"

    def scalar(self, along: LineOfAction) -> Any:
        """Return D."""
        return along.rate * along.rate * self.damping / 2

    def pull(self, along: LineOfAction) -> Any:
        """Return c x' e."""
        return along.direct(None, along.rate * self.damping)


@final
@dataclass(frozen=True)
class Drive:
    """A given force F that drives x up: δW = F δx."""

    force: Any

    kind: ClassVar[Literal["work"]] = "work"

    def scalar(self, along: LineOfAction) -> None:
        """Return None: a drive has neither a potential nor a Rayleigh function."""

    def pull(self, along: LineOfAction) -> Any:
        """Return −F e."""
        return along.direct(None, -self.force)


Law: TypeAlias = Elastic | Stored | Viscous | Drive


def laws_of(force: AnyForce, number: Number) -> tuple[Law, ...]:
    """Return the laws by which a force pulls its ends together; none for a load on one body."""
    match force:
        case Spring():
            return (Elastic(number(force.stiffness), number(force.free_length)),)
        case JointSpring():
            return (Elastic(number(force.stiffness), number(force.reference)),)
        case CentralForce() | Potential() | PotentialField():
            return (Stored(force.potential, number),)
        case Damper() | JointDamper():
            return (Viscous(number(force.damping)),)
        case JointForce():
            return (Drive(number(force.force)),)
        case BodyLoad():
            return ()
    raise DerivationError(f"no law is known for force {force.name!r}, a {type(force).__name__}")
