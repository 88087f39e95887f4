"""Mistakes in the mass, the center of mass and the inertia of a link."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from mecanique.arrays import Array
from mecanique.model.states import States
from mecanique.verification.causes.change import Change, fit
from mecanique.verification.causes.evidence import Evidence

__all__ = ["link_changes"]

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

_BASIS = np.array(
    [
        (np.eye(4)[i][:, None] * np.eye(4)[k] + np.eye(4)[k][:, None] * np.eye(4)[i])
        / (2 if i == k else 1)
        for i in range(4)
        for k in range(i, 4)
    ]
)
"""The ten directions of symmetric mass moments."""


def link_changes(evidence: Evidence) -> Iterator[Change]:
    """Wrong points, axes, signs and units of inertias, wrong masses, of one link and of all."""
    inputs, recursion = evidence.inputs, evidence.recursion
    if not inputs.inertia.any():
        return
    states = States(evidence.mechanism, inputs.q, inputs.v, inputs.t, inputs.a)
    pulled = recursion.vary(gravity=evidence.gravity * inputs.heavy[:, None])
    Y = pulled.regressor(states, inputs.a) * inputs.inertia[:, None, None, None, None]
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
            yield Change(kind, where, f"{text} of {where}", evidence.base + effect)
            of_all[kind, text] = of_all.get((kind, text), 0.0) + effect
        m, c, _ = _parts(J)
        for point, name in ((np.zeros(3), "origin"), (c, "center of mass")):
            column = np.einsum("nvab,ab->nv", Y[:, :, k], _moments(1.0, point, np.zeros((3, 3))))
            amounts, answers = fit(evidence, column[None])
            text = (
                f"a point mass of {amounts[0]:.6g} kg more at the {name} of {where} "
                f"(mass {m:.6g} kg)"
            )
            yield Change("root mass" if root else "link mass", where, text, answers, 1)
        amounts, answers = fit(evidence, np.einsum("nvab,kab->knv", Y[:, :, k], _BASIS))
        text = f"mass, center or inertia of {where} differ, in no way known as a mistake"
        yield Change("other inertia", where, text, answers, 10)
    if len(places) > 1:
        for (kind, text), effect in of_all.items():
            if kind not in ("link mass", "root mass"):
                yield Change(kind, "", f"{text} of every link", evidence.base + effect)


def _variants(
    J: Array, pose: Array, frame: Array, *, root: bool
) -> Iterator[tuple[str, str, Array]]:
    """Kind, text and mass moments of each way to get them wrong."""
    m, c, inertia = _parts(J)
    lever = m * (c @ c * np.eye(3) - np.outer(c, c))
    yield "root mass" if root else "link mass", "mass and inertia left out", 0 * J
    yield "root mass" if root else "link mass", "mass and inertia counted twice", 2 * J
    for factor, said in _FACTORS:
        yield "mass unit", f"mass {said}", _moments(factor * m, c, inertia)
        yield "mass unit", f"mass and inertia {said}", factor * J
        if c.any():
            yield "length unit", f"center of mass {said}", _moments(m, factor * c, inertia)
            yield (
                "length unit",
                f"center of mass {said} and inertia by the square of that",
                _moments(m, factor * c, factor**2 * inertia),
            )
    if inertia.any():
        for factor, kind, said in _INERTIA_FACTORS[:4]:
            yield kind, f"inertia {said}", _moments(m, c, factor * inertia)
    if lever.any():
        text = (
            "parallel-axis term missing "
            "(inertia about the center of mass taken as that about the origin)"
        )
        yield "parallel axis", text, _moments(m, c, inertia - lever)
        text = (
            "parallel-axis term added twice "
            "(inertia about the origin taken as that about the center of mass)"
        )
        yield "parallel axis", text, _moments(m, c, inertia + lever)
        yield "center of mass", "center of mass left at the origin", _moments(m, 0 * c, inertia)
        yield (
            "center of mass",
            "center of mass on the other side of the origin",
            _moments(m, -c, inertia),
        )
    turn, away = pose[:3, :3], pose[:3, :3] @ c + pose[:3, 3]
    far = m * (away @ away * np.eye(3) - np.outer(turn.T @ away, turn.T @ away))
    if far.any() and not np.allclose(far, lever, atol=1e-12 * np.abs(lever).max()):
        yield "wrong point", "inertia about the world's origin", _moments(m, c, inertia + far)
        yield (
            "wrong point",
            "inertia moved from the world's origin though given elsewhere",
            _moments(m, c, inertia - far),
        )
    yield from _products(m, c, inertia)
    yield from _axes(m, c, inertia, turn, frame)
    if inertia.any():
        for factor, kind, said in _INERTIA_FACTORS[4:]:
            yield kind, f"inertia {said}", _moments(m, c, factor * inertia)


def _products(m: float, c: Array, inertia: Array) -> Iterator[tuple[str, str, Array]]:
    off = inertia - np.diag(np.diag(inertia))
    if not off.any():
        return
    yield "product sign", "products of inertia of the other sign", _moments(m, c, inertia - 2 * off)
    if np.count_nonzero(np.triu(off)) > 1:
        for i, k in ((0, 1), (0, 2), (1, 2)):
            other = inertia.copy()
            other[i, k] = other[k, i] = -inertia[i, k]
            yield (
                "product sign",
                f"product of inertia i{'xyz'[i]}{'xyz'[k]} of the other sign",
                _moments(m, c, other),
            )
    yield "product sign", "products of inertia left out", _moments(m, c, inertia - off)


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
            yield "wrong axes", f"inertia {said}", _moments(m, c, other)


def _parts(J: Array) -> tuple[float, Array, Array]:
    """Mass, center of mass and inertia about it."""
    m = float(J[3, 3])
    c = J[:3, 3] / m if m else np.zeros(3)
    second = J[:3, :3] - m * np.outer(c, c)
    return m, c, np.trace(second) * np.eye(3) - second


def _moments(m: float, c: Array, inertia: Array) -> Array:
    J = np.empty((4, 4))
    J[:3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia + m * np.outer(c, c)
    J[:3, 3] = J[3, :3] = m * c
    J[3, 3] = m
    return J
