"""Guides: what keeps joints on the coordinate map, where the description does not say what it is.

The map r = φ(q) ties joint coordinates together; cords, gears or contacts that a mechanism does not
describe hold them to it. All that is known of their forces is that they do no work in any virtual
displacement: as forces along the joints they lie in the null space of (∂φ/∂q)ᵀ. The joints that one
of its irreducible parts reaches are tied by one guide.

A guide of several joints may act on every body that these joints connect and on those between them,
hence across every joint on the tree's paths from one to another. There only the total of what the
joint and the guide transmit is determined. A guide of a single joint, a drive that prescribes its
motion, acts between parent and child, and its force is part of what the joint transmits.

Why an element that guides cannot do so where the bodies are is said here, too; each side of the
wall finds places, axes and work by its own means.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.constraints.elements import force_names
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.expression import evaluate, plain, symbols_in
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.wording import enumerate_words


@final
@dataclass(frozen=True)
class Guide:
    """Something not described that ties joints of a mechanism."""

    coordinates: tuple[str, ...]  # the joint coordinates it ties
    laws: tuple[str, ...]  # how they follow the generalized coordinates, e.g. "x2 = -x"
    joints: tuple[str, ...]  # the joints they belong to
    # the joints across which it may act; none if it ties the coordinates of one joint
    crossed: tuple[str, ...]

    @property
    def reason(self) -> str:
        """Why the reactions in the joints it crosses are undetermined, in a sentence."""
        return (
            f"the coordinate map guides {enumerate_words(self.joints)} together "
            f"({', '.join(self.laws)}) and does not say by what: cords, gears or contacts may act "
            f"across {enumerate_words(self.crossed)}"
        )


def explain_joint(guides: Sequence[Guide], joint: str) -> str:
    """Return why the reaction in a joint is undetermined; empty if no guide crosses it."""
    return "; ".join(guide.reason for guide in guides if joint in guide.crossed)


def idle_coordinates(guides: Sequence[Guide], joint: Joint) -> frozenset[str]:
    """Return the coordinates of a joint along or about which the joint itself transmits nothing.

    Left out are those that a guide of this joint alone holds, and those that turn a rotor.
    """
    if joint.followers or getattr(joint, "armature", 0.0) != 0:
        return frozenset()
    held = {name for guide in guides if not guide.crossed for name in guide.coordinates}
    return frozenset(joint.coordinates) - held


_NONE = 1e-9
"""Shares of a coordinate in a guide below this count as none."""

_NEAR = (0.3, 0.1, 0.03, 0.01, 0.001)
"""How far from the neutral position the map is differentiated; closer where it is not defined."""


def guides_of(mechanism: Mechanism) -> tuple[Guide, ...]:
    """Return what ties the joints of a mechanism by its coordinate map without being described."""
    driven = mechanism.coordinates.driven
    if not driven:
        return ()
    owner = {name: joint.name for joint in mechanism.joints for name in joint.coordinates}
    guides = []
    for tied in _ties(mechanism, tuple(owner)):
        joints = tuple(dict.fromkeys(owner[name] for name in tied))
        laws = tuple(f"{name} = {driven[name]}" for name in tied if name in driven)
        crossed = tuple(_find_crossed(mechanism, joints)) if len(joints) > 1 else ()
        guides.append(Guide(tied, laws, joints, crossed))
    return tuple(guides)


def _ties(mechanism: Mechanism, names: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """The joint coordinates that guides tie together, group by group."""
    left, sizes, _ = np.linalg.svd(_slopes(mechanism, names))
    rank = rank_of(sizes, _NONE)
    # onto the forces that do no work; it splits into blocks where they do
    projector = np.abs(left[:, rank:] @ left[:, rank:].T) > _NONE
    waiting = [k for k in range(len(names)) if projector[k, k]]
    while waiting:
        group, edge = set[int](), {waiting[0]}
        while edge:
            group |= edge
            edge = {int(j) for k in edge for j in np.flatnonzero(projector[k])} - group
        yield tuple(names[k] for k in sorted(group))
        waiting = [k for k in waiting if k not in group]


def _slopes(mechanism: Mechanism, names: tuple[str, ...]) -> np.ndarray:
    """∂r/∂q in a position like any other, shape (joint coordinates, nq)."""
    from sympy import cse, numbered_symbols, sympify

    coordinates, driven = tuple(mechanism.coordinates), mechanism.coordinates.driven
    # differentiated step by step, as the derivatives of a long chain grow with its length
    laws = [sympify(plain(law)) for law in driven.values()]
    steps, results = cse(laws, numbered_symbols("step "), order="none")
    chain = [(symbol.name, law, _partial_derivatives(law)) for symbol, law in steps]
    chain += [
        (name, law, _partial_derivatives(law)) for name, law in zip(driven, results, strict=True)
    ]
    random = np.random.default_rng(1788)
    for near in _NEAR:
        at = {symbol.symbol: random.uniform(0.2, 1.0) for symbol in mechanism.inputs}
        places = mechanism.neutral() + near * random.uniform(0.2, 1.0, len(coordinates))
        at |= {
            **dict(zip(coordinates, places.tolist(), strict=True)),
            **mechanism.values,
            "t": near,
        }
        slopes = dict(zip(coordinates, np.eye(len(coordinates)), strict=True))
        with suppress(ArithmeticError, TypeError, ValueError), np.errstate(all="ignore"):
            for name, law, partial in chain:
                at[name] = evaluate(law, at)
                parts = (evaluate(s, at) * slopes[x] for x, s in partial.items() if x in slopes)
                slopes[name] = sum(parts, np.zeros(len(coordinates)))
            matrix = np.array([slopes[name] for name in names])
            if np.isfinite(matrix).all():
                return matrix
    # where no position will do, which coordinates meet must do
    matrix = np.zeros((len(names), len(coordinates)))
    for k, name in enumerate(names):
        met = symbols_in(driven[name]) if name in driven else {name}
        for symbol in met & set(coordinates):
            matrix[k, coordinates.index(symbol)] = random.uniform(0.5, 1.0)
    return matrix


def _partial_derivatives(law: Any) -> dict[str, Any]:
    """Return the derivatives of an expression by each of its symbols, by name."""
    return {symbol.name: law.diff(symbol) for symbol in law.free_symbols}


def _find_crossed(mechanism: Mechanism, joints: tuple[str, ...]) -> Iterator[str]:
    """The joints on the paths between the bodies that some joints connect."""
    tied = map(mechanism.joint, joints)
    ends = {body for joint in tied for body in (joint.parent, joint.child)}
    for joint in mechanism.joints:
        beyond = {joint.child}
        for next_joint in mechanism.tree:
            if next_joint.parent in beyond:
                beyond.add(next_joint.child)
        if ends & beyond and ends - beyond:
            yield joint.name


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
    element = [element for element in mechanism.elements for _ in element.forces][force]
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
