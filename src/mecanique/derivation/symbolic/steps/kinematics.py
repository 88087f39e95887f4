"""Write the steps from the coordinates to the velocities of all bodies."""

from __future__ import annotations

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.symbolic.derivation import Left, Result, Stage
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra

_MOST_LISTED = 600
"""Positions and velocities are listed if they have at most this many terms in total."""


def quaternion_stages(algebra: Algebra) -> list[Stage]:
    """Return the step that gives the rates of quaternions and positions by the velocities."""
    names = algebra.mechanism.coordinates
    free = [name for name in names if f"{name}'" not in algebra.velocities]
    if not free:
        return []
    sentence = (
        "The velocities of a body that rotates freely are components in its own axes. Its unit "
        "quaternion p has the rate p' = p w / 2, a product of quaternions with the angular "
        "velocity w, and the rate of its position is its velocity in the axes of the world."
    )
    ring = algebra.ring
    results = tuple(Result(Left(f"{name}'"), ring.rates[ring.index(name)]) for name in free)
    return [Stage("Rates of the coordinates", sentence, results)]


def geometry_stages(kinematics: Kinematics) -> list[Stage]:
    """Return the step from the coordinates to the velocities of all bodies."""
    mechanism, results = kinematics.algebra.mechanism, list[Result]()
    for body in kinematics.bodies:
        given = mechanism.body(body)
        found = {}
        if given.mass != 0:
            found["r"] = kinematics.point(body, given.center)
            found["v"] = kinematics.velocity(body, given.center)
        if any(entry != 0 for entry in given.inertia):
            found["omega"] = kinematics.spin(body)
        for letter, vector in found.items():
            for axis, part in zip("xyz", vector, strict=True):
                if part:
                    results.append(Result(Left(f"{letter}_{body}_{axis}"), tidy(part)))
    if not results or sum(len(result.right) for result in results) > _MOST_LISTED:
        return []
    sentence = (
        "The poses of the bodies as functions of the coordinates give the position r of each "
        "center of mass; its rate is the velocity v, and the rates of the axes give the angular "
        "velocity omega. Components along x, y and z of the world that are not listed are zero."
    )
    if any(joint.quaternion for joint in mechanism.joints):
        sentence += (
            " Velocities of a body that rotates freely, and of bodies it carries, are in its axes."
        )
    return [Stage("Positions and velocities", sentence, tuple(results))]
