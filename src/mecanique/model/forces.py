"""Forces: all actions on the bodies besides gravity and the reactions.

Every scalar may be a number or an expression in parameters, inputs, the generalized coordinates q,
their velocities q' and time t. Points are given in the frame of the body they belong to.

A force acts in one of four ways, its base class: along the line between two points (`LineLoad`), in
a joint (`JointLoad`), on one body (`BodyLoad`) or by where a point is (`FieldLoad`). It describes
itself, who, where and with which expressions; what it does, its law, is written twice, in
`mecanique.derivation.laws` and in `mecanique.reference.engine.forces.loads`, independently.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from mecanique.model.expression import Scalar
from mecanique.model.force_base import (
    BodyLoad,
    FieldLoad,
    JointLoad,
    LineLoad,
    Point,
    WrenchOnBody,
)
from mecanique.model.statements import LENGTH, POINT, state


@final
@dataclass(frozen=True)
class Spring(LineLoad):
    """A linear spring between two points: it pulls with k (length − free length).

    Args:
        name: its name.
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
        stiffness: k [N/m].
        free_length: length without force [m].

    Example:
        >>> from dataclasses import replace
        >>> coil = mq.Spring("coil", "ground", (0, 0, 1), "particle", (0, 0, 0), 80.0, 0.5)
        >>> ball = replace(mq.textbook.load("free_particle"), forces=(coil,))
        >>> mq.Reference(ball).energy([0.0, 0.0, 0.0]).potential
        10.0
    """

    kind = "spring"
    conservative = True
    letter = "stiffness"

    stiffness: Scalar = field(metadata=state("N/m", sign="of at least"))
    free_length: Scalar = field(default=0.0, metadata=LENGTH)


@final
@dataclass(frozen=True)
class Damper(LineLoad):
    """A linear damper between two points: it resists with c times the rate of the length.

    Args:
        name: its name.
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
        damping: c [N·s/m].

    Example:
        >>> from dataclasses import replace
        >>> oil = mq.Damper("oil", "ground", (0, 0, 1.0), "particle", (0, 0, 0), damping=0.3)
        >>> ball = replace(mq.textbook.load("free_particle"), forces=(oil,))
        >>> mq.Reference(ball).acceleration([0, 0, 0], [0, 0, 2.0]).round(3)
        array([  0.  ,   0.  , -10.41])
    """

    kind = "damper"
    letter = "damping"

    damping: Scalar = field(metadata=state("N·s/m", sign="of at least"))


@final
@dataclass(frozen=True)
class CentralForce(LineLoad):
    """A force between two points by a potential V of their distance: it pulls with dV/d(distance).

    Gravitation has V = -G m1 m2/distance, Coulomb's force V = k q1 q2/distance, Hooke's law in
    space V = k distance²/2 (Goldstein, Classical Mechanics, 3rd ed., sect. 3.2).

    Args:
        name: its name.
        body_a: name of one body.
        point_a: shape (3,), in the frame of body a [m].
        body_b: name of the other body.
        point_b: shape (3,), in the frame of body b [m].
        potential: V, in parameters, `distance()` and time [J].

    Example:
        >>> from dataclasses import replace
        >>> pull = -10.0 / mq.distance()
        >>> sun = mq.CentralForce("sun", "ground", (0, 0, 0), "particle", (0, 0, 0), pull)
        >>> planet = replace(mq.textbook.load("free_particle"), forces=(sun,), gravity=(0, 0, 0))
        >>> mq.Reference(planet).energy([2.0, 0.0, 0.0]).potential
        -5.0
    """

    kind = "load"
    conservative = True
    letter = "name"

    potential: Scalar = field(metadata=state("J", stores=True))


@final
@dataclass(frozen=True)
class PotentialField(FieldLoad):
    """A potential V(x, y, z, t) of where a body's point is in the world: it pushes with -grad V.

    Where V depends on time, it does work on the mechanism, and the energy is no integral
    (Goldstein, Classical Mechanics, 3rd ed., sect. 1.4).

    Args:
        name: its name.
        body: name of the body.
        point: shape (3,), in the body's frame [m].
        potential: V, in parameters, the point's `position()` in world axes and time [J].

    Example:
        >>> from dataclasses import replace
        >>> x, y, z = mq.position()
        >>> trap = mq.PotentialField("trap", "particle", (0, 0, 0), 2.0 * x**2 * y)
        >>> print(mq.derive(replace(mq.textbook.load("free_particle"), forces=(trap,))))
        m x'' + 4 x y = 0
        m y'' + 2 x^2 = 0
        z'' + g = 0
    """

    kind = "load"
    conservative = True
    letter = "name"

    potential: Scalar = field(metadata=state("J", stores=True))


@final
@dataclass(frozen=True)
class JointSpring(JointLoad):
    """A linear spring in a joint with one coordinate: force −k (coordinate − reference).

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        stiffness: k [N·m/rad or N/m].
        reference: the joint coordinate without force [rad or m].

    Example:
        >>> from dataclasses import replace
        >>> coil = mq.JointSpring("coil", "pin", 3.0, reference=0.5)
        >>> print(mq.derive(replace(mq.textbook.load("rigid_bar_pendulum"), forces=(coil,))))
        q'' + 9 q/(m l^2) - 9/(2 m l^2) + 3 g sin(q)/(2 l) = 0
    """

    kind = "spring"
    conservative = True
    letter = "stiffness"

    joint: str
    stiffness: Scalar = field(metadata=state("N/m", "N·m/rad", sign="of at least"))
    reference: Scalar = field(default=0.0, metadata=state("m", "rad"))


@final
@dataclass(frozen=True)
class Potential(JointLoad):
    """A potential V(q, t) of the coordinates of joints: it drives each with -∂V/∂(coordinate).

    Where V depends on time, it does work on the mechanism, and the energy is no integral.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint, or of several.
        potential: V, in parameters, the coordinates of these joints and time [J].

    Example:
        >>> from dataclasses import replace
        >>> q = mq.coordinate("q")
        >>> well = mq.Potential("well", "pin", 2.0 * q**4 - q**2)
        >>> print(mq.derive(replace(mq.textbook.load("rigid_bar_pendulum"), forces=(well,))))
        q'' - 6 q/(m l^2) + 24 q^3/(m l^2) + 3 g sin(q)/(2 l) = 0
    """

    kind = "spring"
    conservative = True
    letter = "name"

    potential: Scalar = field(metadata=state("J", stores=True))


@final
@dataclass(frozen=True)
class JointDamper(JointLoad):
    """A linear damper in a joint with one coordinate: force −c times its rate.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        damping: c [N·m·s/rad or N·s/m].

    Example:
        >>> from dataclasses import replace
        >>> grease = mq.JointDamper("grease", "pin", damping=0.5)
        >>> print(mq.derive(replace(mq.textbook.load("rigid_bar_pendulum"), forces=(grease,))))
        q'' + 3 q'/(2 m l^2) + 3 g sin(q)/(2 l) = 0
    """

    kind = "damper"
    letter = "damping"

    joint: str
    damping: Scalar = field(metadata=state("N·s/m", "N·m·s/rad", sign="of at least"))


@final
@dataclass(frozen=True)
class JointForce(JointLoad):
    """A drive in a joint with one coordinate, between parent and child.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        force: along or about the joint's axis, on the child [N or N·m].

    Example:
        >>> from dataclasses import replace
        >>> tau = mq.Input("tau", 1.5, "N·m")
        >>> motor = mq.JointForce("motor", "pin", tau)
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> print(mq.derive(replace(pendulum, forces=(motor,), inputs=(tau,))))
        q'' + 3 g sin(q)/(2 l) = 3 tau/(m l^2)
    """

    kind = "load"
    letter = "force"

    joint: str
    force: Scalar = field(metadata=state("N", "N·m", varies=True))


@final
@dataclass(frozen=True)
class Force(BodyLoad):
    """A force at a point of a body; nothing takes the reaction.

    Args:
        name: its name.
        body: name of the body.
        point: shape (3,), in the body's frame [m].
        force: shape (3,), components [N].
        axes: the body in whose axes the components are; "world" for fixed axes.

    Example:
        >>> from dataclasses import replace
        >>> wind = mq.Force("wind", "particle", (0, 0, 0), (3.0, 0, 0))
        >>> print(mq.derive(replace(mq.textbook.load("free_particle"), forces=(wind,))))
        m x'' - 3 = 0
        y'' = 0
        z'' + g = 0
    """

    kind = "load"
    letter = "force"

    point: Point = field(metadata=POINT)
    force: Point = field(metadata=state("N", vector=True, varies=True))
    axes: str = "world"

    @property
    def wrench(self) -> WrenchOnBody:
        """The force at its point."""
        return WrenchOnBody(self.body, self.axes, point=self.point, force=self.force)


@final
@dataclass(frozen=True)
class Torque(BodyLoad):
    """A pure torque on a body; nothing takes the reaction.

    Args:
        name: its name.
        body: name of the body.
        torque: shape (3,), components [N·m].
        axes: the body in whose axes the components are; "world" for fixed axes.

    Example:
        >>> from dataclasses import replace
        >>> motor = mq.Torque("motor", "rod", (0, -0.5, 0))
        >>> print(mq.derive(replace(mq.textbook.load("rigid_bar_pendulum"), forces=(motor,))))
        q'' - 3/(2 m l^2) + 3 g sin(q)/(2 l) = 0
    """

    kind = "load"
    letter = "torque"

    torque: Point = field(metadata=state("N·m", vector=True, varies=True))
    axes: str = "world"

    @property
    def wrench(self) -> WrenchOnBody:
        """The torque."""
        return WrenchOnBody(self.body, self.axes, torque=self.torque)
