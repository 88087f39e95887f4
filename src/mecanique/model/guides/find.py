"""Guides: what keeps joints on the coordinate map, where the description does not say what it is.

The map r = φ(q) ties joint coordinates together; cords, gears or contacts that a mechanism does not
describe hold them to it. All that is known of their forces is that they do no work in any virtual
displacement: as forces along the joints they lie in the null space of (∂φ/∂q)ᵀ. The joints that one
of its irreducible parts reaches are tied by one guide.

A guide of several joints may act on every body that these joints connect and on those between them,
hence across every joint on the tree's paths from one to another. There only the total of what the
joint and the guide transmit is determined. A guide of a single joint, a drive that prescribes its
motion, acts between parent and child, and its force is part of what the joint transmits.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mecanique.model.expression import evaluate, plain, symbols_in
from mecanique.model.guides.guide import Guide
from mecanique.model.mechanism import Mechanism

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
    rank = int((sizes > _NONE * sizes.max(initial=_NONE)).sum())
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
    from sympy import Symbol

    coordinates, driven = tuple(mechanism.coordinates), mechanism.coordinates.driven
    slopes = {
        (names.index(name), coordinates.index(symbol)): plain(law).diff(Symbol(symbol))
        for name, law in driven.items()
        for symbol in symbols_in(law) & set(coordinates)
    }
    here = {
        (names.index(name), coordinates.index(name)): 1.0 for name in coordinates if name in names
    }
    random = np.random.default_rng(1788)
    for near in _NEAR:
        at = {symbol.symbol: random.uniform(0.2, 1.0) for symbol in mechanism.inputs}
        places = mechanism.neutral() + near * random.uniform(0.2, 1.0, len(coordinates))
        at |= {
            **dict(zip(coordinates, places.tolist(), strict=True)),
            **mechanism.values,
            "t": near,
        }
        matrix = np.zeros((len(names), len(coordinates)))
        for place, slope in (here | slopes).items():
            try:
                matrix[place] = evaluate(slope, at)
            except (ArithmeticError, TypeError, ValueError):
                matrix[place] = np.nan
        if np.isfinite(matrix).all():
            return matrix
    # where no position will do, which coordinates meet must do
    for place in here | slopes:
        matrix[place] = random.uniform(0.5, 1.0)
    return matrix


def _find_crossed(mechanism: Mechanism, joints: tuple[str, ...]) -> Iterator[str]:
    """The joints on the paths between the bodies that some joints connect."""
    ends = {body for name in joints for body in _bodies(mechanism, name)}
    for joint in mechanism.joints:
        beyond = {joint.child}
        for next_joint in mechanism.tree:
            if next_joint.parent in beyond:
                beyond.add(next_joint.child)
        if ends & beyond and ends - beyond:
            yield joint.name


def _bodies(mechanism: Mechanism, name: str) -> tuple[str, str]:
    joint = mechanism.joint(name)
    return joint.parent, joint.child
