"""Elements that switch: dry friction, stops, and contacts that open and close.

Each is in one of a few states at a time: open or closed, sticking or slipping one way or the other.
A choice for all of them is a mode, in which the mechanism is smooth; which mode follows is a
complementarity problem (Pfeiffer & Glocker, Multibody Dynamics with Unilateral Contacts, 1996).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.constraint_base import JointRow, Rubbing, Striking
from mecanique.model.constraints.contacts import Rolling
from mecanique.model.expression import Scalar, Vector
from mecanique.model.placement import Placement
from mecanique.model.statements import FRAME, POINT, NumberRule, Stated, state

Restitution: TypeAlias = Literal["newton", "poisson"]
"""Whose law an impact obeys: Newton's of velocities or Poisson's of impulses."""

LAWS: tuple[Restitution, ...] = ("newton", "poisson")


@final
@dataclass(frozen=True)
class Friction(Rubbing):
    """Dry friction in a joint with one coordinate (Coulomb): it sticks, or slips one way or other.

    While it slips, the force on the child is μ times the load, against the rate of the joint's
    coordinate; while it sticks, whatever holds it, up to μ₀ times the load. What can stick, sticks.
    Viscous friction is a damper beside it, Stribeck's a coefficient that depends on the
    rate. Resistance to rolling or spinning is a couple in the joint that turns: a length in the
    place of μ, times the normal force of a contact.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        mu: coefficient μ of kinetic friction; an expression in parameters, coordinates and rates.
            For resistance to rolling, the lever of the normal force [m].
        load: the force that presses, or about an axis that force times its radius [N or N·m]; an
            expression in parameters, coordinates, rates and time. Or the name of the contact or
            stop whose normal force presses.
        mu_static: coefficient μ₀ of static friction; μ by default.
        speed: rate of the surface it rubs on, of a belt or a shaft [m/s or rad/s]; an expression in
            parameters.

    Example:
        >>> from dataclasses import replace
        >>> block = mq.textbook.load("two_blocks")
        >>> dry = replace(block, switching=(mq.Friction("dry", block.joints[0].name, 0.1, 9.81),))
        >>> dry.switching[0].states
        ('sticks', 'slips +', 'slips -')
    """

    joint: str = ""
    mu: Scalar = field(default=0.0, metadata=state("1", varies=True))
    load: Scalar | str = field(
        default=0.0, metadata=state("N", "N·m", named=True, varies=True, sign="of at least")
    )
    mu_static: Scalar = field(default=None, metadata=state("1", varies=True))
    speed: Scalar = field(default=0.0, metadata=state("m/s", "rad/s"))

    noun = "friction"
    states = ("sticks", "slips +", "slips -")

    @property
    def stated(self) -> tuple[Stated, ...]:
        """What its fields state; about an axis, coefficients of a normal force are levers [m]."""
        stated = super().stated
        if self.pressed_by is None:
            return stated
        return tuple(
            replace(its, units=("1", "m")) if its.units == ("1",) else its for its in stated
        )

    @property
    def pressed_by(self) -> str | None:
        """The contact or stop that presses, if it is named."""
        return self.load if isinstance(self.load, str) else None

    @property
    def joint_rows(self) -> tuple[JointRow, ...]:
        """The rate of its joint against the surface."""
        return (JointRow("R", ((self.joint, 1.0),), speed=self.speed),)

    @property
    def coefficients(self) -> tuple[Scalar, Scalar]:
        """The friction at its load, or at one newton of what presses."""
        load = 1.0 if isinstance(self.load, str) else self.load
        return (self.mu * load, self.mu_static * load)


@final
@dataclass(frozen=True)
class Stop(Striking):
    """A stop of a joint with one coordinate, rigid with restitution or elastic.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        at: the joint's coordinate at the stop [rad or m]; an expression in parameters.
        side: 1 for an upper stop, which keeps the coordinate below it, −1 for a lower one.
        restitution: e in 0…1, the ratio of the rates after and before an impact.
        stiffness: of an elastic stop [N·m/rad or N/m]; None for a rigid one.
        in_turn: as of a `Contact`.
        holds: the pull up to which a latch keeps what has come to it [N·m or N]; 0 for none.

    Example:
        >>> wall = mq.Stop("wall", "pin", at=0.5, restitution=0.8)
        >>> wall.states
        ('open', 'closed')
    """

    joint: str = ""
    at: Scalar = field(default=0.0, metadata=state("m", "rad"))
    side: int = 1
    restitution: Scalar = field(default=0.0, metadata=state("1"))
    stiffness: Scalar | None = field(default=None, metadata=state("N/m", "N·m/rad", sign="above"))
    in_turn: bool = False
    holds: Scalar = field(default=0.0, metadata=state("N", "N·m"))

    noun = "stop"
    states = ("open", "closed")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.side not in (1, -1):
            raise InputError(f"stop {self.name!r}: expected side 1 or -1, got {self.side!r}")
        if self.stiffness is not None and self.holds != 0:
            raise InputError(f"stop {self.name!r}: expected a stiffness or what it holds, got both")

    @property
    def joint_rows(self) -> tuple[JointRow, ...]:
        """What is left to the stop."""
        return (JointRow("N", ((self.joint, -self.side),), self.side * self.at),)

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to."""
        words = ": expected a pull that it holds of at least 0, got {}"
        yield NumberRule(self.title, words, (self.holds,), self.holds)
        yield from super().rules()


@final
@dataclass(frozen=True)
class Capstan(Rubbing, Striking):
    """A cord over a rough drum between two slides: slack, or taut and sticking or slipping.

    Where it slips, its tensions are as 1 to e^(μ φ) (Euler, 1769). Their mean is its normal force N
    and their difference its friction R, of at most 2 tanh(μ φ/2) N.

    Args:
        name: its name.
        joint: name of the slide at one end, along which the cord pulls.
        other: name of that at the other end. The coordinates are the lengths of the runs.
        length: of both runs together [m]; an expression in parameters.
        wrap: the angle φ of the drum that the cord touches [rad].
        mu: coefficient μ of kinetic friction; an expression in parameters.
        mu_static: coefficient μ₀ of static friction; μ by default.
        speed: of the drum's surface, towards the first slide [m/s]; an expression in parameters.
        restitution: e in 0…1 of the jerk by which it becomes taut.

    Example:
        >>> mq.textbook.load("capstan").switching[0].states
        ('open', 'sticks', 'slips +', 'slips -')
    """

    joint: str = ""
    other: str = ""
    length: Scalar = field(default=0.0, metadata=state("m", sign="above"))
    wrap: Scalar = field(default=0.0, metadata=state("rad", sign="above"))
    mu: Scalar = field(default=0.0, metadata=state("1"))
    mu_static: Scalar = field(default=None, metadata=state("1"))
    speed: Scalar = field(default=0.0, metadata=state("m/s"))
    restitution: Scalar = field(default=0.0, metadata=state("1"))

    noun = "capstan"
    states = ("open", "sticks", "slips +", "slips -")

    @property
    def joint_rows(self) -> tuple[JointRow, ...]:
        """The slack, and the rate of the cord over the drum."""
        ends = (self.joint, self.other)
        slack = JointRow("N", tuple((end, -1.0) for end in ends), self.length)
        return slack, JointRow("R", ((ends[0], 0.5), (ends[1], -0.5)), speed=self.speed)

    @property
    def coefficients(self) -> tuple[Scalar, Scalar]:
        """The difference of the tensions where it slips, or may slip, at a mean of one newton."""
        from sympy import exp

        ratios = exp(self.mu * self.wrap), exp(self.grip)
        kinetic, static = (2 * (ratio - 1) / (ratio + 1) for ratio in ratios)
        return kinetic, static

    @property
    def grip(self) -> Scalar:
        """The logarithm up to which the ratio of its tensions holds it."""
        return self.mu_static * self.wrap

    @property
    def pressed_by(self) -> str:
        """Itself."""
        return self.name


@final
@dataclass(frozen=True)
class Contact(Rubbing, Striking):
    """A contact that opens and closes, of a point, a ball or a wheel with a plane or a sphere.

    The body stays on the side of the plane's normal. A bowl around a point, of radius 0 for the
    body, is a cord that goes slack. A side with ends, of a table or a block, carries what touches
    it between them; beyond, nothing. There the corner in which it ends touches instead: it is a
    point of the body that has the side, in a contact with a side of the other body, or with a dome
    as large as the other body's ball.

    Args:
        name: its name.
        body: name of the body that has the point, the ball or the wheel.
        center: shape (3,), the point or the center, in the frame of the body [m].
        radius: of the ball or the wheel [m]; 0 for a point or a corner.
        axis: shape (3,), of a wheel in the frame of the body; None for a point or a ball.
        on: name of the body that has the plane.
        plane: frame of the plane in that body; its z axis is the normal, on the side of the body.
        bowl: radius of a sphere in the plane's place, which touches it at its origin [m]: of a bowl
            that the body is in, or minus that of a dome that it is on; zero for a plane.
        mu: coefficient μ of kinetic friction.
        mu_static: coefficient μ₀ of static friction; μ by default.
        restitution: e in 0…1 of its impacts.
        law: "newton", by which e is the ratio of normal velocities, or "poisson", that of impulses.
        in_turn: whether of several contacts that touch those that approach impact one after the
            other, the fastest first; together, as one complementarity problem, by default.
        length: of a side, from end to end along the plane's x axis, half of it to either side of
            the plane's origin [m]; zero for a plane without ends.

    Example:
        >>> floor = mq.Contact("floor", "ball", radius=0.1, mu=0.3, restitution=0.8)
        >>> floor.states
        ('open', 'sticks', 'slips')
    """

    body: str = ""
    center: Vector = field(default=(0.0, 0.0, 0.0), metadata=POINT)
    radius: Scalar = field(default=0.0, metadata=state("m"))
    axis: Vector | None = None
    on: str = "ground"
    plane: Placement = field(default=Placement(), metadata=FRAME)
    bowl: Scalar = field(default=0.0, metadata=state("m"))
    mu: Scalar = field(default=0.0, metadata=state("1"))
    mu_static: Scalar = field(default=None, metadata=state("1"))
    restitution: Scalar = field(default=0.0, metadata=state("1"))
    law: Restitution = "newton"
    in_turn: bool = False
    length: Scalar = field(default=0.0, metadata=state("m", sign="of at least"))

    noun = "contact"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.law not in LAWS:
            raise InputError(
                f"{self.title}: expected a law 'newton' or 'poisson', got {self.law!r}"
            )
        if self.closed.curved and self.ends:
            raise InputError(f"{self.title}: expected a length of a plane's side, not of a bowl")

    @property
    def ends(self) -> bool:
        """Whether its side has ends."""
        return not (isinstance(self.length, float) and self.length == 0)

    @property
    def states(self) -> tuple[str, ...]:
        """Open, or closed and sticking or slipping."""
        return ("open", "sticks", "slips") if self.rubs else ("open", "closed")

    @property
    def rubs(self) -> bool:
        """Whether it has friction."""
        return not (isinstance(self.mu, float) and self.mu == 0 and self.mu_static == 0)

    @property
    def closed(self) -> Rolling:
        """The contact that holds while this one is closed and sticks."""
        return Rolling(
            self.name,
            self.body,
            self.radius,
            self.center,
            self.axis,
            on=self.on,
            plane=self.plane,
            bowl=self.bowl,
        )

    @property
    def coefficients(self) -> tuple[Scalar, Scalar]:
        """Those of kinetic and static friction."""
        return (self.mu, self.mu_static)

    @property
    def pressed_by(self) -> str:
        """Itself."""
        return self.name

    @property
    def bodies(self) -> tuple[str, ...]:
        """The two bodies that touch."""
        return (self.body, self.on)

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to."""
        yield from self.closed.fit()
        yield from super().rules()


Switching: TypeAlias = Friction | Stop | Capstan | Contact
"""An element that switches."""
