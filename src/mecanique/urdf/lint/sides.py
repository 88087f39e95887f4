"""Links of the left and right side that differ although their names match."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.placement import pose_of
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.document import UrdfDocument
from mecanique.urdf.solids import Mass

_MASS, _MOMENT = 0.01, 0.05
"""Relative differences of masses and moments of inertia that drawings of two sides may have."""

_NEAR = 2e-3
"""Distance by which mirrored points may differ [m]."""

_LIGHT = 1e-3
"""Links of less than this part of the robot's mass are left out."""

_MIRROR = np.array([1.0, -1.0, 1.0])
"""Left and right lie on either side of the root link's plane x–z (REP 103)."""

_OTHER = {"left": "right", "l": "r", "fl": "fr", "rl": "rr", "hl": "hr", "bl": "br"}
_OTHER |= {"lf": "rf", "lr": "rr", "lh": "rh", "lb": "rb"}
_OTHER |= {left.upper(): right.upper() for left, right in _OTHER.items()}
_OTHER |= {"Left": "Right"}
"""What words of a name on the left are called on the right."""

_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+|[^A-Za-z0-9]+")


def mirror_name(name: str) -> str:
    """Return what the same part of the right side is called; "" for one that is not on the left."""
    words = _WORDS.findall(name)
    count = sum(word in _OTHER for word in words)
    if count == 1:
        return "".join(_OTHER.get(word, word) for word in words)
    # LLEG_LINK1, lhip
    first = {"L": "R", "l": "r"}.get(name[:1], "")
    return first + name[1:] if first and not count else ""


def check(document: UrdfDocument, report: Report) -> None:
    """Note links of the right side that do not mirror those of the left."""
    if document.root is None:
        return
    links = {link.name: link for link in document.links}
    poses = {document.root: np.eye(4)}  # with all joints at zero, in the root
    for joint in document.tree:
        poses[joint.child] = poses[joint.parent] @ pose_of(joint.origin)
    least = _LIGHT * sum(link.mass for link in document.links)
    for left in document.links:
        right = links.get(mirror_name(left.name))
        if right is None or max(left.mass, right.mass) <= least:
            continue
        a, b = poses[left.name], poses[right.name]
        # what only bears such a name, as on a robot with two arms side by side
        if np.linalg.norm(b[:3, 3] - _MIRROR * a[:3, 3]) > _NEAR:
            continue
        differences = list(_differences(left.mass_at(a), right.mass_at(b), a, b))
        if differences:
            message = f"it is not link {left.name!r} mirrored: {'; '.join(differences)}"
            report.add("M212", right, message)


def _differences(left: Mass, right: Mass, a: Array, b: Array) -> Iterator[str]:
    """Yield what differs between masses on both sides, with the poses of their links."""
    if abs(left.mass - right.mass) > _MASS * max(left.mass, right.mass):
        yield f"{right.mass:g} kg, not {left.mass:g} kg"
    sides = ((left, a), (right, b))
    reach = max(float(np.linalg.norm(mass.center - pose[:3, 3])) for mass, pose in sides)
    off = float(np.linalg.norm(right.center - _MIRROR * left.center))
    if off > max(_NEAR, _MOMENT * reach):
        yield f"its center of mass is {1000 * off:.3g} mm away from there"
        return
    inertia = np.outer(_MIRROR, _MIRROR) * left.inertia
    size = max(np.abs(left.inertia).max(), np.abs(right.inertia).max())
    if np.abs(right.inertia - inertia).max() > _MOMENT * size:
        ours, theirs = np.linalg.eigvalsh(right.inertia), np.linalg.eigvalsh(inertia)
        if np.abs(ours - theirs).max() > _MOMENT * size:
            yield f"principal moments {_list(ours)}, not {_list(theirs)} kg·m²"
        else:
            yield "the same principal moments of inertia, about other axes"


def _list(values: npt.NDArray[np.floating[Any]]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)
