"""The steps from the coordinates to the velocities of all bodies."""

from __future__ import annotations

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.symbolic.derivation import Left, Result, Stage
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra

__all__ = ["geometry_stages", "quaternion_stages"]


_MOST_LISTED = 600
"""Most terms of positions and velocities that are listed."""


def quaternion_stages(algebra: Algebra) -> list[Stage]:
    """Return the step that says how quaternions and positions follow from the velocities."""
    names = algebra.mechanism.coordinates
    free = [name for name in names if f"{name}'" not in algebra.velocities]
    if not free:
        return []
    sentence = (
        "The velocities of a body that turns freely are components in its own axes. Its unit "
        "quaternion p follows the angular velocity w by p' = p w / 2, a product of quaternions, "
        "and its position follows the turned velocity."
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
        "center of mass, its rate the velocity v, and the turning axes the angular velocity omega. "
        "Components along x, y and z of the world that are not listed are zero."
    )
    if any(joint.quaternion for joint in mechanism.joints):
        sentence += (
            " Velocities of a body that turns freely, and of what hangs on it, are in its own axes."
        )
    return [Stage("Positions and velocities", sentence, tuple(results))]
