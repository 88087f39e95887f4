"""The nearest inertia that a real body can have, for one that none has.

Principal moments of a real body obey a + b ≥ c, b + c ≥ a and c + a ≥ b: a convex cone. The nearest
symmetric matrix by the Frobenius norm keeps the principal axes (Hoffman & Wielandt, 1953), so that
the three moments are projected onto the cone: onto a face, an edge (a thin rod) or its tip.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.model.bodies.tensor import entries_of, tensor_of
from mecanique.model.mechanism.validation import inertia_fault
from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.fields import number
from mecanique.urdf.reading.links import ENTRIES

_FACES = np.array([[1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]])
"""Each product with the moments is at least zero."""


@final
@dataclass(frozen=True)
class Balance:
    """An inertia that no real body has, and the nearest one that a body can have.

    Args:
        link: name of the link.
        element: its <inertia>.
        before: ixx, iyy, izz, ixy, ixz, iyz as written [kg·m²].
        after: the same of the nearest real body.
    """

    link: str
    element: Element
    before: tuple[float, ...]
    after: tuple[float, ...]

    def __str__(self) -> str:
        changed = [
            f"{name} {old:.6g} → {new:.6g}"
            for name, old, new in zip(ENTRIES, self.before, self.after, strict=True)
            if f"{old:.6g}" != f"{new:.6g}"
        ]
        most = max(abs(new - old) for old, new in zip(self.before, self.after, strict=True))
        part = 100 * most / max(map(abs, self.before))
        what = ", ".join(changed) or "its last digits"
        return (
            f"line {self.element.line}: link {self.link!r}: {what} kg·m² "
            f"(at most {part:.2g} % of its largest entry)"
        )


def balances(robot: Element) -> Iterator[Balance]:
    """Yield every inertia of a robot that no real body has, with the nearest one.

    Args:
        robot: the <robot> element.
    """
    for link in robot.all("link"):
        inertial = link.child("inertial")
        mass, inertia = (
            (None, None) if inertial is None else map(inertial.child, ("mass", "inertia"))
        )
        if mass is None or inertia is None:
            continue
        unheard = Report(None)
        kilograms = number(mass, "value", unheard, "")
        given = [number(inertia, name, unheard, "") for name in ENTRIES]
        before = tuple(entry for entry in given if entry is not None)
        if kilograms is None or kilograms < 0 or len(before) < len(ENTRIES):
            continue
        if inertia_fault(kilograms, before):
            yield Balance(link.attributes.get("name", ""), inertia, before, nearest_inertia(before))


def nearest_inertia(inertia: Sequence[float]) -> tuple[float, ...]:
    """Return the nearest inertia that a real body can have, by the Frobenius norm.

    Args:
        inertia: ixx, iyy, izz, ixy, ixz, iyz [kg·m²].
    """
    moments, axes = np.linalg.eigh(tensor_of(inertia))
    return entries_of(axes @ np.diag(_project(moments)) @ axes.T)


def _project(moments: np.ndarray) -> np.ndarray:
    """Return the nearest point of the cone: the nearest feasible foot on a face, edge or tip."""
    feet = [moments, np.zeros(3)]
    for faces in ([0], [1], [2], [0, 1], [0, 2], [1, 2]):
        normals = _FACES[faces]
        feet.append(moments - np.linalg.pinv(normals) @ (normals @ moments))
    slack = 1e-12 * np.abs(moments).max()
    feasible = [foot for foot in feet if (_FACES @ foot >= -slack).all()]
    return min(feasible, key=lambda foot: float(np.linalg.norm(foot - moments)))
