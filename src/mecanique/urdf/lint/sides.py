"""Links of the left and right side that differ although their names match."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.bodies.tensor import tensor_of
from mecanique.urdf.findings import Report
from mecanique.urdf.reading.document import UrdfDocument
from mecanique.urdf.reading.links import UrdfLink

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


@final
@dataclass(frozen=True, eq=False)
class _Seen:
    """A link in the root's axes, with all joints at zero."""

    origin: Array  # of its frame, shape (3,) [m]
    center: Array  # of mass, shape (3,) [m]
    inertia: Array  # about the center, shape (3, 3) [kg·m²]


def mirror_name(name: str) -> str:
    """Return what the same part of the right side is called; "" for one that is not on the left."""
    words = _WORDS.findall(name)
    count = sum(word in _OTHER for word in words)
    if count == 1:
        return "".join(_OTHER.get(word, word) for word in words)
    # LLEG_LINK1, lhip
    return (
        {"L": "R", "l": "r"}[name[0]] + name[1:]
        if not count and name.startswith(("L", "l"))
        else ""
    )


def check(document: UrdfDocument, report: Report) -> None:
    """Note links of the right side that do not mirror those of the left."""
    links = {link.name: link for link in document.links}
    seen = _look(document, links)
    least = _LIGHT * sum(link.mass for link in document.links)
    for left in document.links:
        right = links.get(mirror_name(left.name))
        if right is None or left.name not in seen or right.name not in seen:
            continue
        if max(left.mass, right.mass) <= least:
            continue
        a, b = seen[left.name], seen[right.name]
        # what only bears such a name, as on a robot with two arms side by side
        if np.linalg.norm(b.origin - _MIRROR * a.origin) > _NEAR:
            continue
        differences = list(_differences(left, right, a, b))
        if differences:
            message = f"it is not link {left.name!r} mirrored: {'; '.join(differences)}"
            report.add("M212", right, message)


def _differences(left: UrdfLink, right: UrdfLink, a: _Seen, b: _Seen) -> Iterator[str]:
    if abs(left.mass - right.mass) > _MASS * max(left.mass, right.mass):
        yield f"{right.mass:g} kg, not {left.mass:g} kg"
    expected = _MIRROR * a.center
    reach = max(float(np.linalg.norm(link.center - link.origin)) for link in (a, b))
    off = float(np.linalg.norm(b.center - expected))
    if off > max(_NEAR, _MOMENT * reach):
        yield f"its center of mass is {1000 * off:.3g} mm away from there"
        return
    inertia = np.outer(_MIRROR, _MIRROR) * a.inertia
    size = max(np.abs(a.inertia).max(), np.abs(b.inertia).max())
    if np.abs(b.inertia - inertia).max() > _MOMENT * size:
        ours, theirs = np.linalg.eigvalsh(b.inertia), np.linalg.eigvalsh(inertia)
        if np.abs(ours - theirs).max() > _MOMENT * size:
            yield f"principal moments {_list(ours)}, not {_list(theirs)} kg·m²"
        else:
            yield "the same principal moments of inertia, about other axes"


def _look(document: UrdfDocument, links: Mapping[str, UrdfLink]) -> dict[str, _Seen]:
    """Return every link as seen from the root with all joints at zero."""
    if document.root is None:
        return {}
    poses = {document.root: (np.eye(3), np.zeros(3))}
    below: dict[str, list[tuple[str, Array, Array]]] = {}
    for joint in document.joints:
        turn, shift = np.array(joint.origin.rotation, float), np.array(joint.origin.xyz, float)
        below.setdefault(joint.parent, []).append((joint.child, turn, shift))
    seen = {}
    order = [document.root]
    for name in order:
        turn, origin = poses[name]
        for child, rotation, shift in below.get(name, ()):
            poses[child] = turn @ rotation, origin + turn @ shift
            order.append(child)
        link = links[name]
        axes = turn @ np.array(link.frame.rotation, float)
        center = origin + turn @ np.array(link.frame.xyz, float)
        seen[name] = _Seen(origin, center, axes @ tensor_of(link.inertia) @ axes.T)
    return seen


def _list(values: npt.NDArray[np.floating[Any]]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)
