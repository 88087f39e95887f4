"""Why an element that guides cannot do so where the bodies are, in a sentence, or "".

Each side of the wall finds places, axes and work by its own means, and has them judged here.
"""

from __future__ import annotations

import numpy as np

from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.constraints.elements import Element, force_names
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.mechanism import Mechanism

_FIT = 1e-9
"""Tolerance of lengths, relative to 1 m plus the length they belong to."""

_WORK = 1e-8
"""An element whose unit force does more work than this in a motion of the map does not fit it."""


def cord_fault(mechanism: Mechanism, cord: Cord | Belt, stops: np.ndarray, n: np.ndarray) -> str:
    """Say why a cord has no straight runs in its plane; stops (..., stops, 3), n (..., 3)."""
    where = f"mechanism {mechanism.name!r}: {type(cord).__name__.lower()} {cord.name!r}"
    names = [stop.body for stop in cord.stops]
    reach = [mechanism.evaluate(stop.radius) * stop.sense for stop in cord.stops]
    for k in range(len(cord.parts)):
        d, h = stops[..., k + 1, :] - stops[..., k, :], reach[k + 1] - reach[k]
        square, level = np.sum(d * d, axis=-1), np.abs(np.sum(d * n, axis=-1))
        roomy = square > h * h
        loose = (level > _FIT * (1 + np.sqrt(square))) | ~roomy
        if loose.any():
            worst = loose.argmax()
            what = "leaves its plane" if roomy.flat[worst] else "has no straight run"
            return (
                f"{where} {what} from {names[k]!r} to {names[k + 1]!r}, "
                f"{np.sqrt(square.flat[worst]):.6g} m apart; correct its points, radii, senses or "
                "normal, or the position"
            )
        r, R = abs(reach[k]), abs(reach[k + 1])
        if isinstance(cord, Belt) and square.min() < (r + R) ** 2:
            return (
                f"{where}: the pulleys on {names[k]!r} and {names[k + 1]!r} overlap; they are "
                f"{np.sqrt(square.min()):.6g} m apart with radii {r:.6g} and {R:.6g} m; correct "
                "the radii, or the pulleys' positions"
            )
    return ""


def mesh_fault(
    mechanism: Mechanism,
    mesh: Gear | Rack,
    axes: tuple[np.ndarray, np.ndarray],
    centers: tuple[np.ndarray, np.ndarray],
) -> str:
    """Say why wheels in mesh, or a pinion and its rack, do not touch; axes (3,), centers [m]."""
    n, line = axes
    if isinstance(mesh, Gear) and float(np.linalg.norm(np.cross(n, line))) > _FIT:
        return _bevel_fault(mechanism, mesh, axes, centers)
    where = f"mechanism {mechanism.name!r}: {type(mesh).__name__.lower()} {mesh.name!r}"
    first, second = (repr(name) for name in mesh.joints)
    radius = mechanism.evaluate(mesh.radius)
    d = centers[1] - centers[0]
    if isinstance(mesh, Gear):
        wanted = mechanism.evaluate(mesh.distance)
    else:
        wanted, askew = radius, abs(float(n @ line))
        d = d - (d @ line) * line
        if askew > _FIT:
            return (
                f"{where}: the axes of {first} and {second} do not suit; expected a slide normal "
                "to the hinge"
            )
    distance = float(np.linalg.norm(d - (d @ n) * n))
    if abs(distance - wanted) > _FIT * (1 + radius):
        return (
            f"{where} does not fit its axes: they are {distance:.6g} m apart, its radii need "
            f"{wanted:.6g} m; correct the radii, or the origins of {first} and {second}"
        )
    return ""


def _bevel_fault(
    mechanism: Mechanism,
    gear: Gear,
    axes: tuple[np.ndarray, np.ndarray],
    centers: tuple[np.ndarray, np.ndarray],
) -> str:
    """Say why bevel wheels do not touch: their pitch circles do so in the plane of the axes."""
    (n, line), (start, end) = axes, centers
    where = f"mechanism {mechanism.name!r}: gear {gear.name!r}"
    first, second = (repr(name) for name in gear.joints)
    r, R = (mechanism.evaluate(x) for x in (gear.radius, gear.other_radius))
    across = np.cross(n, line)
    across = across / np.linalg.norm(across)
    passing = abs(float((end - start) @ across))
    if passing > _FIT * (1 + r):
        return (
            f"{where}: the axes of {first} and {second} do not suit; expected parallel or "
            f"intersecting axes, but they pass each other at a distance of {passing:.6g} m"
        )
    u, U = np.cross(across, n), np.cross(across, line)
    rims = [(start + i * r * u, end + k * R * U) for i in (1, -1) for k in (1, -1)]
    gap = min(float(np.linalg.norm(a - b)) for a, b in rims)
    if gap > _FIT * (1 + r):
        way, far = np.linalg.lstsq(np.array([-n, line]).T, end - start, rcond=None)[0]
        return (
            f"{where} does not fit its axes: its pitch cones do not share an apex. The wheels are "
            f"{abs(way):.6g} and {abs(far):.6g} m from where the axes meet, and their pitch "
            f"circles {gap:.6g} m apart; correct the radii, or the origins of {first} and {second}"
        )
    return ""


def work_fault(mechanism: Mechanism, work: np.ndarray) -> str:
    """Say which element does work in a motion of the coordinate map; work (..., nv, k)."""
    if not work.size or np.abs(work).max() <= _WORK:
        return ""
    worst = np.unravel_index(int(np.abs(work).argmax()), work.shape)
    velocity, force = mechanism.velocities[worst[-2]], int(worst[-1])
    element = _owner(mechanism, force)
    law = ""
    if isinstance(element, Cord):
        law = (
            ". A cord with a stretch that turns adds no law to the map: state it, "
            f"Coordinates(…, {{{velocity.removesuffix(chr(39))!r}: …}})"
        )
    return (
        f"mechanism {mechanism.name!r}: {type(element).__name__.lower()} {element.name!r} does "
        f"not fit the coordinate map, in which {force_names(mechanism.elements)[force]} does the "
        f"work {work[worst]:.3g} per unit of {velocity} but must do none; correct its bodies, "
        f"points, radii or senses, or the map{law}"
    )


def _owner(mechanism: Mechanism, force: int) -> Element:
    return [element for element in mechanism.elements for _ in element.forces][force]
