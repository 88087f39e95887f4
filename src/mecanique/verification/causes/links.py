"""Mistakes in the mass, the center of mass and the inertia of a link."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from mecanique.arrays import Array
from mecanique.model.states import States
from mecanique.verification.causes.change import Change
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.moments import moments_of, parts_of

_FACTORS = ((1e3, "times 1000"), (1e-3, "divided by 1000"))
_INERTIA_FACTORS = (
    (1e3, "mass unit", "times 1000 (grams for kilograms)"),
    (1e-3, "mass unit", "divided by 1000 (kilograms for grams)"),
    (1e6, "length unit", "times 10⁶ (millimeters for meters)"),
    (1e-6, "length unit", "divided by 10⁶ (meters for millimeters)"),
    (1e9, "unit", "times 10⁹ (g·mm² for kg·m²)"),
    (1e-9, "unit", "divided by 10⁹ (kg·m² for g·mm²)"),
)
_SIGNS = np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]])
"""Which axes point the other way; the tensor does not feel all three."""


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
        for kind, text, other in _variants(J, standing[k], recursion.origins[k][:3, :3], root=root):
            effect = np.einsum("nvab,ab->nv", Y[:, :, k], other - J)
            answers = evidence.base + effect
            yield Change(kind, where, f"{text} of {where}", answers, moments={k: other})
            of_all[kind, text] = of_all.get((kind, text), 0.0) + effect
    if len(places) > 1:
        for (kind, text), effect in of_all.items():
            if kind not in ("link mass", "root mass"):
                yield Change(kind, "", f"{text} of every link", evidence.base + effect)


def _variants(
    J: Array, pose: Array, frame: Array, *, root: bool
) -> Iterator[tuple[str, str, Array]]:
    """Kind, text and mass moments of each way to get them wrong."""
    m, c, inertia = parts_of(J)
    lever = m * (c @ c * np.eye(3) - np.outer(c, c))
    yield "root mass" if root else "link mass", "mass and inertia left out", 0 * J
    yield "root mass" if root else "link mass", "mass and inertia counted twice", 2 * J
    for factor, said in _FACTORS:
        yield "mass unit", f"mass {said}", moments_of(factor * m, c, inertia)
        yield "mass unit", f"mass and inertia {said}", factor * J
        if c.any():
            yield "length unit", f"center of mass {said}", moments_of(m, factor * c, inertia)
            yield (
                "length unit",
                f"center of mass {said} and inertia by the square of that",
                moments_of(m, factor * c, factor**2 * inertia),
            )
    if inertia.any():
        for factor, kind, said in _INERTIA_FACTORS[:4]:
            yield kind, f"inertia {said}", moments_of(m, c, factor * inertia)
    if lever.any():
        text = (
            "parallel-axis term missing "
            "(inertia about the center of mass taken as that about the origin)"
        )
        yield "parallel axis", text, moments_of(m, c, inertia - lever)
        text = (
            "parallel-axis term added twice "
            "(inertia about the origin taken as that about the center of mass)"
        )
        yield "parallel axis", text, moments_of(m, c, inertia + lever)
        yield "center of mass", "center of mass left at the origin", moments_of(m, 0 * c, inertia)
        yield (
            "center of mass",
            "center of mass on the other side of the origin",
            moments_of(m, -c, inertia),
        )
        for axis, name in zip(np.eye(3), "xyz", strict=True):
            if c @ axis and np.count_nonzero(c) > 1:
                mirrored = c - 2 * (c @ axis) * axis
                said = f"{name} of the center of mass of the other sign"
                yield "center of mass", said, moments_of(m, mirrored, inertia)
    turn, away = pose[:3, :3], pose[:3, :3] @ c + pose[:3, 3]
    far = m * (away @ away * np.eye(3) - np.outer(turn.T @ away, turn.T @ away))
    if far.any() and not np.allclose(far, lever, rtol=0, atol=1e-12 * np.abs(lever).max()):
        yield "wrong point", "inertia about the world's origin", moments_of(m, c, inertia + far)
        yield (
            "wrong point",
            "inertia moved from the world's origin though given elsewhere",
            moments_of(m, c, inertia - far),
        )
    yield from _products(m, c, inertia)
    yield from _axes(m, c, inertia, turn, frame)
    if inertia.any():
        for factor, kind, said in _INERTIA_FACTORS[4:]:
            yield kind, f"inertia {said}", moments_of(m, c, factor * inertia)


def _products(m: float, c: Array, inertia: Array) -> Iterator[tuple[str, str, Array]]:
    off = inertia - np.diag(np.diag(inertia))
    if not off.any():
        return
    yield (
        "product sign",
        "products of inertia of the other sign",
        moments_of(m, c, inertia - 2 * off),
    )
    if np.count_nonzero(np.triu(off)) > 1:
        for i, k in ((0, 1), (0, 2), (1, 2)):
            other = inertia.copy()
            other[i, k] = other[k, i] = -inertia[i, k]
            yield (
                "product sign",
                f"product of inertia i{'xyz'[i]}{'xyz'[k]} of the other sign",
                moments_of(m, c, other),
            )
    yield "product sign", "products of inertia left out", moments_of(m, c, inertia - off)


def _axes(
    m: float, c: Array, inertia: Array, turn: Array, frame: Array
) -> Iterator[tuple[str, str, Array]]:
    turns = [("in the world's axes", turn), ("in the parent's axes", frame)]
    found = [(said, R.T @ inertia @ R) for said, R in turns] + [
        (f"{said}, turned the wrong way", R @ inertia @ R.T) for said, R in turns
    ]
    for order in permutations(range(3)):
        for turned in _SIGNS if order != (0, 1, 2) else ():
            P = np.eye(3)[list(order)] * turned
            called = ", ".join(f"{'−' if turned[k] < 0 else ''}{'xyz'[k]}" for k in order)
            found.append((f"with its axes x, y, z taken from {called}", P @ inertia @ P.T))
    principal, axes = np.linalg.eigh(inertia)
    off = np.abs(inertia - np.diag(np.diag(inertia))).max()
    if off > 1e-12 * np.abs(inertia).max():
        found.append(("in its axes of figure", axes.T @ inertia @ axes))
        for order in permutations(range(3)):
            name = "in its axes of figure"
            found.append((name, np.diag(principal[list(order)])))
    seen = [inertia]
    for said, other in found:
        if all(
            np.abs(other - one).max() > 1e-12 * max(np.abs(inertia).max(), 1e-300) for one in seen
        ):
            seen.append(other)
            yield "wrong axes", f"inertia {said}", moments_of(m, c, other)
