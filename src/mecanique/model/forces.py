"""Forces: all actions on the bodies besides gravity and the reactions.

Every scalar may be a number or an expression in parameters, inputs, the generalized coordinates q,
their velocities q' and time t. Points are given in the frame of the body they belong to.

A force acts in one of three ways, its base class: along the line between two points (`LineLoad`),
in a joint (`JointLoad`) or on one body (`BodyLoad`). It describes itself, who, where and with which
expressions; what it does, its law, is written twice, in `mecanique.derivation.laws` and in
`mecanique.reference.engine.forces.laws`, independently.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from mecanique.model.expression import Scalar
from mecanique.model.force_base import (
    LENGTH,
    POINT,
    BodyLoad,
    JointLoad,
    LineLoad,
    Point,
    WrenchOnBody,
    state,
)

__all__ = ["Damper", "Force", "JointDamper", "JointForce", "JointSpring", "Spring", "Torque"]


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
    """

    kind = "spring"
    conservative = True
    letter = "stiffness"

    stiffness: Scalar = field(metadata=state("N/m", positive=True))
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
    """

    kind = "damper"
    letter = "damping"

    damping: Scalar = field(metadata=state("N·s/m", positive=True))


@final
@dataclass(frozen=True)
class JointSpring(JointLoad):
    """A linear spring in a joint with one coordinate: force −k (coordinate − reference).

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        stiffness: k [N·m/rad or N/m].
        reference: the joint coordinate without force [rad or m].
    """

    kind = "spring"
    conservative = True
    letter = "stiffness"

    stiffness: Scalar = field(metadata=state("N/m", "N·m/rad", positive=True))
    reference: Scalar = field(default=0.0, metadata=state("m", "rad"))


@final
@dataclass(frozen=True)
class JointDamper(JointLoad):
    """A linear damper in a joint with one coordinate: force −c times its rate.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        damping: c [N·m·s/rad or N·s/m].
    """

    kind = "damper"
    letter = "damping"

    damping: Scalar = field(metadata=state("N·s/m", "N·m·s/rad", positive=True))


@final
@dataclass(frozen=True)
class JointForce(JointLoad):
    """A drive in a joint with one coordinate, between parent and child.

    Args:
        name: its name.
        joint: name of a revolute or prismatic joint.
        force: along or about the joint's axis, on the child [N or N·m].
    """

    kind = "load"
    letter = "force"

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
    """

    kind = "load"
    letter = "torque"

    torque: Point = field(metadata=state("N·m", vector=True, varies=True))
    axes: str = "world"

    @property
    def wrench(self) -> WrenchOnBody:
        """The torque."""
        return WrenchOnBody(self.body, self.axes, torque=self.torque)
