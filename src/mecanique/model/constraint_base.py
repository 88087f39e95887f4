"""What contacts and guiding elements say of themselves, whatever asks them.

As forces act in one of three ways, their base class, so do contacts and elements: what rolls
presses (`PressingContact`), a blade holds sideways (`EdgeContact`), a cord pulls along straight
runs (`Strung`). A class says which lengths it states, what they keep to, which of its forces have
one sign only and what these are called; its law stands in `mecanique.derivation.mechanics` and, on
the other side of the wall, in `mecanique.reference`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, final

from mecanique.model.expression import Scalar, Vector, plain
from mecanique.model.placement import Placement
from mecanique.model.statements import MechanismPart, NumberRule, Stated


@dataclass(frozen=True)
class ContactBase(MechanismPart):
    """What every contact says of itself."""

    body: str

    noun = "contact"

    forces_of: ClassVar[Mapping[str, str]]
    """Its force of each row and the way it acts, in words, with {} for the bodies and its name."""

    @property
    @abstractmethod
    def seat(self) -> Vector:
        """The point its force is referred to, in the frame of the body [m]."""

    @property
    def sizes(self) -> tuple[Scalar, ...]:
        """Lengths that are typical of it [m]."""
        return ()

    @property
    def breaks(self) -> tuple[str, ...]:
        """Names of the events at which it ceases to hold."""
        return ()


class PressingContact(ContactBase):
    """A contact that presses along a normal and rubs along two directions, and so may let go."""

    radius: Scalar
    center: Vector
    axis: Vector | None
    crown: Scalar
    plane: Placement
    stretch: Vector
    bowl: Scalar
    friction: Scalar | None

    @property
    @abstractmethod
    def curved(self) -> bool:
        """Whether it rolls in a bowl or on a dome."""

    @property
    def stretched(self) -> bool:
        """Whether it is an ellipsoid."""
        return self.stretch != (1.0, 1.0, 1.0)

    @property
    def seat(self) -> Vector:
        """Its center."""
        return self.center

    @property
    def sizes(self) -> tuple[Scalar, ...]:
        """Its radius."""
        return (self.radius,)

    @property
    def breaks(self) -> tuple[str, ...]:
        """Where it would pull, and where it would slip if that is asked."""
        slip = () if self.friction is None else (f"{self.name} would slip",)
        return (f"{self.name} would pull", *slip)

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to."""
        yield from self.fit()
        yield from super().rules()

    def fit(self) -> Iterator[NumberRule]:
        """Yield what its sizes keep to among themselves."""
        where, radius, crown = self.title, self.radius, self.crown
        # a ball of radius 0 is a point
        bound = "of at least" if self.axis is None else "above"
        words = f": expected a radius {bound} 0, got {{}}"
        yield NumberRule(where, words, (radius,), radius, strict=self.axis is not None)
        words = ": expected a crown radius from 0, a sharp edge, to the radius {1}, a ball, got {0}"
        for gap in (crown, plain(radius) - plain(crown)):
            yield NumberRule(where, words, (crown, radius), gap, follows=True)
        if self.friction is not None:
            words = ": expected a coefficient of friction of at least 0, got {}"
            yield NumberRule(where, words, (self.friction,), self.friction, endless=True)
        if self.curved:
            words = (
                ": expected a bowl's radius above the ball's {1}, or minus that of a dome, got {0}"
            )
            bowl = plain(self.bowl)
            # above 0 for a dome, below 0, and for a bowl wider than the ball
            outside = bowl * (bowl - plain(radius))
            yield NumberRule(where, words, (bowl, radius), outside, strict=True, endless=True)


class EdgeContact(ContactBase):
    """A contact at a point of the body, which holds it in one direction."""

    point: Vector

    @property
    def seat(self) -> Vector:
        """Its point."""
        return self.point


@dataclass(frozen=True)
class GuidingElement(MechanismPart):
    """What every element that guides says of itself."""

    noun = "element"

    @property
    def tensions(self) -> tuple[str, ...]:
        """Names of those of its forces that can only pull."""
        return ()


@final
@dataclass(frozen=True)
class JointRow:
    """A direction in which an element in joints presses or rubs.

    Args:
        letter: of its force, "N" if it presses and "R" if it rubs.
        weights: of the coordinate of each joint in the gap, or in the rate of slip.
        offset: the gap where the coordinates are zero; None for friction.
        speed: what the rate of slip lacks [m/s or rad/s].
    """

    letter: str
    weights: tuple[tuple[str, float], ...]
    offset: Scalar | None = None
    speed: Scalar = 0.0


@dataclass(frozen=True)
class SwitchingElement(MechanismPart):
    """What every element that switches between states says of itself."""

    @property
    def joint_rows(self) -> tuple[JointRow, ...]:
        """Its directions if it sits in joints, the one that presses first."""
        return ()

    @property
    def coefficients(self) -> tuple[Scalar, Scalar]:
        """Kinetic and static friction, for each newton that presses or, of a stated load, in N."""
        return (0.0, 0.0)

    @property
    def pressed_by(self) -> str | None:
        """The element whose normal force its friction goes by; None if its load is stated."""
        return None

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies it refers to by itself; of an element in a joint, none."""
        return ()

    @property
    def varying(self) -> tuple[Scalar, ...]:
        """Scalars that may depend on the state and time."""
        return tuple(x for stated in self.stated if stated.varies for x in stated.scalars)

    @property
    def constants(self) -> tuple[Scalar, ...]:
        """Scalars in the parameters alone."""
        return tuple(x for stated in self.stated if not stated.varies for x in stated.scalars)


def list_cord_runs(element: SwitchingElement) -> tuple[str, ...]:
    """Return the slides along which a cord runs that becomes taut; none if it is no cord."""
    gaps = [row.weights for row in element.joint_rows if row.offset is not None]
    return tuple(joint for weights in gaps if len(weights) > 1 for joint, _ in weights)


class Rubbing(SwitchingElement):
    """An element that rubs; its static coefficient is the kinetic one if none is given."""

    mu: Scalar
    mu_static: Scalar

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mu_static is None:
            object.__setattr__(self, "mu_static", self.mu)

    @property
    def holding(self) -> Scalar:
        """The coefficient of static friction."""
        return self.mu_static

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to."""
        words = ": expected a coefficient of friction of at least 0, got {}"
        yield NumberRule(self.title, words, (self.mu,), self.mu)
        words = ": expected a static coefficient of at least the kinetic {}, got {}"
        more = plain(self.mu_static) - plain(self.mu)
        yield NumberRule(self.title, words, (self.mu, self.mu_static), more, follows=True)
        yield from super().rules()


class Striking(SwitchingElement):
    """An element that closes with an impact."""

    restitution: Scalar

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to."""
        e = plain(self.restitution)
        yield NumberRule(self.title, ": expected a restitution in 0…1, got {}", (e,), e * (1.0 - e))
        yield from super().rules()


class CordStop(NamedTuple):
    """A place that a cord runs to: an end of it, or a pulley.

    Args:
        body: its name.
        center: shape (3,), in the frame of the body [m].
        radius: of the cord's line around it, zero at an end [m].
        sense: 1 counterclockwise, −1 clockwise.
    """

    body: str
    center: Vector
    radius: Scalar = 0.0
    sense: int = 1


class Strung(GuidingElement):
    """An element of straight runs from stop to stop, which pull."""

    normal: tuple[float, float, float]
    axes: str

    @property
    @abstractmethod
    def stops(self) -> tuple[CordStop, ...]:
        """Where it runs."""

    @property
    @abstractmethod
    def parts(self) -> tuple[int, ...]:
        """Which of its tensions each run has."""

    @property
    @abstractmethod
    def forces(self) -> tuple[str, ...]:
        """Names of its tensions."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies it touches, and the one in whose axes its normal is."""
        touched = dict.fromkeys(stop.body for stop in self.stops)
        return tuple(touched if self.axes == "world" else touched | {self.axes: None})

    @property
    def tensions(self) -> tuple[str, ...]:
        """All of its forces."""
        return self.forces

    @property
    def stated(self) -> tuple[Stated, ...]:
        """What its fields state, and its points and radii."""
        stated = list(super().stated)
        for stop in self.stops:
            stated.append(Stated("point", tuple(stop.center), ("m",)))
            stated.append(Stated("radius", (stop.radius,), ("m",)))
        return tuple(stated)
