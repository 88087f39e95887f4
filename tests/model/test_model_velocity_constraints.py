"""Constraints on velocities: accepted, and declined where a constraint on positions says it."""

from __future__ import annotations

import pytest

from mecanique.errors import MechanismError
from mecanique.model import (
    Body,
    Mechanism,
    Parameter,
    Planar,
    Prismatic,
    Revolute,
    VelocityConstraint,
    box,
    coordinate,
    disk,
    time,
)

HOLONOMIC = (
    "is the rate of a constraint on positions; state that one instead, "
    "by the coordinate map or a loop"
)
r = Parameter("r", 0.3, "m", "radius")


def vehicle(*constraints: VelocityConstraint) -> Mechanism:
    """A box in a plane with a wheel."""
    return Mechanism(
        "vehicle",
        (Body("ground"), Body("body", box(1.0, (1, 1, 1))), Body("wheel", disk(1.0, 0.3))),
        (
            Planar("plane", "ground", "body", names=("x", "y", "theta")),
            Revolute("axle", "body", "wheel", coordinate="phi"),
        ),
        parameters=(r,),
        velocity_constraints=constraints,
    )


def blade() -> VelocityConstraint:
    """No sideways motion: Chaplygin's sleigh."""
    from sympy import cos, sin

    theta = coordinate("theta")
    return VelocityConstraint("blade", {"x": sin(theta), "y": -cos(theta)})


def rolling() -> tuple[VelocityConstraint, VelocityConstraint]:
    """A disk upright on a plane."""
    from sympy import cos, sin

    theta = coordinate("theta")
    return (
        VelocityConstraint("roll_x", {"x": 1.0, "phi": -r * cos(theta)}),
        VelocityConstraint("roll_y", {"y": 1.0, "phi": -r * sin(theta)}),
    )


def test_the_sleigh_and_the_rolling_disk_are_accepted() -> None:
    assert vehicle(blade()).rolls
    assert len(vehicle(*rolling()).velocity_constraints) == 2


def test_a_bicycle_is_accepted() -> None:
    """Two blades a length apart, the front one steered by phi."""
    from sympy import cos, sin

    theta, steer = coordinate("theta"), coordinate("phi")
    front = VelocityConstraint(
        "front", {"x": sin(theta + steer), "y": -cos(theta + steer), "theta": -cos(steer)}
    )
    assert vehicle(blade(), front).constrained


def test_a_given_speed_is_the_rate_of_a_prescribed_position() -> None:
    with pytest.raises(MechanismError, match=HOLONOMIC):
        vehicle(VelocityConstraint("drive", {"x": 1.0}, rate=time()))


def test_velocities_may_stand_for_their_coordinates() -> None:
    from sympy import cos, sin

    theta = coordinate("theta")
    named = vehicle(VelocityConstraint("blade", {"x'": sin(theta), "y'": -cos(theta)}))
    assert named.velocity_constraints[0].along(named.velocities)[2:] == [0.0, 0.0]


def test_rolling_along_a_line_is_holonomic_and_told_so() -> None:
    with pytest.raises(MechanismError, match=f"velocity constraint 'roll' {HOLONOMIC}"):
        Mechanism(
            "wheel",
            (Body("ground"), Body("hub"), Body("wheel", disk(1.0, 0.3))),
            (
                Prismatic("s", "ground", "hub", coordinate="x"),
                Revolute("axle", "hub", "wheel", coordinate="phi"),
            ),
            parameters=(r,),
            velocity_constraints=(VelocityConstraint("roll", {"x": 1.0, "phi": -r}),),
        )


def test_a_rate_that_depends_on_time_counts_with_its_sign() -> None:
    """(x θ + y t)' = 0 is θ x' + x θ' + t y' = -y; with y on the right it is no such rate."""
    x, y, theta = map(coordinate, ("x", "y", "theta"))
    slopes = {"x": theta, "theta": x, "y": time()}
    with pytest.raises(MechanismError, match=HOLONOMIC):
        vehicle(VelocityConstraint("led", slopes, -y))
    assert vehicle(VelocityConstraint("led", slopes, y)).velocity_constraints


def test_an_integrating_factor_does_not_hide_what_is_holonomic() -> None:
    with pytest.raises(MechanismError, match=HOLONOMIC):
        vehicle(
            VelocityConstraint(
                "circle",
                {
                    "x": coordinate("x") * (1 + coordinate("y") ** 2),
                    "y": coordinate("y") * (1 + coordinate("y") ** 2),
                },
            )
        )


def test_a_blade_that_cannot_turn_is_holonomic() -> None:
    with pytest.raises(MechanismError, match=HOLONOMIC):
        vehicle(blade(), VelocityConstraint("straight", {"theta": 1.0}))


def test_faults_of_the_description_are_told_first() -> None:
    with pytest.raises(
        MechanismError, match="velocity constraint 'v' depends on 'w', no coordinate or parameter"
    ):
        vehicle(VelocityConstraint("v", {"w": 1.0}))
    with pytest.raises(MechanismError, match="velocity constraint 'v' is empty"):
        vehicle(VelocityConstraint("v", {}))


def test_without_constraints_nothing_changes() -> None:
    assert vehicle().velocity_constraints == ()
