"""Mistakes in the mass, the center of mass and the inertia of a link."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from mecanique.arrays import Array
from mecanique.model import slips
from mecanique.model.slips import Slip, say_factor
from mecanique.model.states import States
from mecanique.verification.causes.change import Change
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.moments import moments_of, parts_of


def link_changes(evidence: Evidence) -> Iterator[Change]:
    """Wrong points, axes, signs and units of inertias, wrong masses, of one link and of all."""
    Y, recursion = evidence.regressor, evidence.recursion
    if not evidence.inputs.inertia.any():
        return
    neutral = States.of(evidence.mechanism, None)
    standing = [pose[0] for pose in recursion.poses(neutral)]
    of_all: dict[tuple[str, str], Array] = {}
    places = [
        k
        for k, link in enumerate(recursion.tree)
        if link.body is not None and recursion.moments[k].any()
    ]
    for k in places:
        link, J = recursion.tree[k], recursion.moments[k]
        where, root = f"link {link.body!r}", link.parent < 0
        for what, slip in _variants(J, standing[k], recursion.origins[k][:3, :3], root=root):
            effect = np.einsum("nvab,ab->nv", Y[:, :, k], slip.value - J)
            answers, text = evidence.base + effect, f"{what} of {where}: {slip.text}"
            yield Change(slip.kind, where, text, answers, moments={k: slip.value})
            key = slip.kind, f"{what} of every link: {slip.text}"
            of_all[key] = of_all.get(key, 0.0) + effect
    if len(places) > 1:
        for (kind, text), effect in of_all.items():
            if kind not in ("link mass", "root mass"):
                yield Change(kind, "", text, evidence.base + effect)


def _variants(J: Array, pose: Array, frame: Array, *, root: bool) -> Iterator[tuple[str, Slip]]:
    """Yield each way to get a link's mass moments wrong: what is wrong, and the moments."""
    m, c, inertia = parts_of(J)
    mass, both, center, tensor = "mass", "mass and inertia", "center of mass", "inertia"
    yield both, Slip("root mass" if root else "link mass", slips.LEFT_OUT, 0 * J)
    yield both, Slip("root mass" if root else "link mass", slips.TWICE, 2 * J)
    for factor, kind, text in slips.GRAMS:
        text = f"{text} ({say_factor(factor)})"
        yield mass, Slip(kind, text, moments_of(factor * m, c, inertia))
        yield both, Slip(kind, text, factor * J)
    for factor, kind, text in slips.MILLIMETERS if c.any() else ():
        text = f"{text} ({say_factor(factor)})"
        yield center, Slip(kind, text, moments_of(m, factor * c, inertia))
        squared = moments_of(m, factor * c, factor**2 * inertia)
        yield f"{center} and, squared, inertia", Slip(kind, text, squared)
    units = [
        Slip(unit.kind, f"{unit.text} ({say_factor(unit.factor)})", unit.factor * inertia)
        for unit in slips.INERTIA
        if inertia.any()
    ]
    # a unit of both mass and length is rarer than one of them, and stands last
    found = [*units[:4], *slips.mistake_point(m, c, inertia)]
    for slip in found:
        yield tensor, slip._replace(value=moments_of(m, c, slip.value))
    if c.any():
        yield center, Slip("center of mass", slips.LEFT_OUT, moments_of(m, 0 * c, inertia))
        for slip in slips.mistake_vector("center of mass", c):
            yield center, slip._replace(value=moments_of(m, slip.value, inertia))
    turn, away = pose[:3, :3], pose[:3, :3] @ c + pose[:3, 3]
    far = slips.lever_of(m, turn.T @ away)
    found = []
    lever = slips.lever_of(m, c)
    if far.any() and not np.allclose(far, lever, rtol=0, atol=1e-12 * np.abs(lever).max()):
        about, moved = "about the world's origin", "moved from the world's origin, in vain"
        found = [
            Slip("wrong point", about, inertia + far),
            Slip("wrong point", moved, inertia - far),
        ]
    found += [*slips.mistake_products(inertia), *_in_other_axes(inertia, turn, frame), *units[4:]]
    for slip in found:
        yield tensor, slip._replace(value=moments_of(m, c, slip.value))


def _in_other_axes(inertia: Array, turn: Array, frame: Array) -> Iterator[Slip]:
    """Yield the inertia given in other axes than the link's."""
    turns = [("in the world's axes", turn), ("in the parent's axes", frame)]
    found = [(said, R.T @ inertia @ R) for said, R in turns]
    found += [(f"{said}, turned the wrong way", R @ inertia @ R.T) for said, R in turns]
    found += [(slip.text, slip.value) for slip in slips.mistake_axes(inertia)]
    principal, axes = np.linalg.eigh(inertia)
    size = np.abs(inertia).max()
    if np.abs(inertia - np.diag(np.diag(inertia))).max() > 1e-12 * size:
        found.append(("in its axes of figure", axes.T @ inertia @ axes))
        for order in permutations(range(3)):
            found.append(("in its axes of figure", np.diag(principal[list(order)])))
    yield from slips.list_once("wrong axes", found, inertia, 1e-12 * max(size, 1e-300))
