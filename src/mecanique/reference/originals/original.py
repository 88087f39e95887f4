"""A robot as another engine reads it from its file.

Each engine's `read` takes the text, gravity (3,) [m/s²], positions and velocities of joints; it
raises EngineError with the engine's own reason if the engine refuses the text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.arrays import Array, cross
from mecanique.reference.vectors import turn_of

ByJoint: TypeAlias = Mapping[str, Sequence[Any]]
"""In each of n states, by name of the joint: a number, or the numbers of several coordinates.

A ball has a unit quaternion x, y, z, w and its angular velocity in the child's axes; a body that
moves freely, its origin in the world and such a quaternion, and the velocity of its origin and its
angular velocity, both in its own axes; planar and universal joints, their coordinates and rates.
"""

WIDTHS = {"single": 1, "universal": 2, "planar": 3, "ball": 3, "free": 6}
"""Number of velocities of each kind of joint."""


@final
@dataclass(frozen=True)
class Original:
    """An engine's results for a robot, in the velocities of the joints that it was asked about."""

    joints: tuple[str, ...]  # names of the joints, in the order of the results
    mass: Array  # mass matrices, shape (n, k, k)
    bias: Array  # shape (n, k)
    complaints: tuple[str, ...]  # the engine's own messages about the file
    passive: Array | None = None  # forces of springs and dampers, shape (n, k), if it has any
    others: tuple[str, ...] = ()  # joints that it moves and was not asked about


Chart: TypeAlias = Callable[[Array, Array], tuple[Array, Array, Array]]
"""From positions and velocities of a joint: the engine's positions p, and T and Ṫ v, where its
velocities are u = T v."""


@final
@dataclass(frozen=True)
class EngineJoint:
    """A joint as an engine has it."""

    name: str
    at: slice  # where its positions stand among the engine's
    rate: int  # where its velocities begin among the engine's
    kind: str  # one of `WIDTHS`
    chart: Chart


def same(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Chart of coordinates and rates that an engine counts alike."""
    return q, np.eye(len(v)), np.zeros(len(v))


def ball_w_first(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Chart of a ball whose quaternion begins with w."""
    return q[[3, 0, 1, 2]], np.eye(3), np.zeros(3)


def turning(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Rotation matrix of a free body, and T and Ṫ v of its origin's velocity in world axes."""
    R = turn_of(q[3:])
    return R, np.hstack([R, np.zeros((3, 3))]), R @ cross(v[3:], v[:3])


def pair(v: ByJoint, joints: Sequence[EngineJoint]) -> list[str]:
    """Return by which name each joint of an engine is asked about; empty for those that are not.

    It is the longest end of a scoped name, or that name in an inner scope, where an engine has a
    joint to a model's model. Joints without such names are taken in their order.
    """
    waiting = {name: np.size(rows[0]) for name, rows in v.items()}
    names = [""] * len(joints)
    for likeness in (_ends_with, _stands_within, None):
        for k, joint in enumerate(joints):
            if names[k]:
                continue
            fitting = [name for name, width in waiting.items() if width == WIDTHS[joint.kind]]
            if likeness is None:
                names[k] = next(iter(fitting), "")
            else:
                alike = (name for name in fitting if likeness(joint.name, name))
                names[k] = max(alike, key=len, default="")
            waiting.pop(names[k], None)
    return names


def _ends_with(scoped: str, name: str) -> bool:
    return f"::{scoped}".endswith(f"::{name}")


def _stands_within(scoped: str, name: str) -> bool:
    """Whether a name stands in a model inside that of another, equal name."""
    scope, _, bare = name.rpartition("::")
    return _ends_with(scoped, bare) and f"::{scope}::" in f"::{scoped}"


def evaluate(
    q: ByJoint,
    v: ByJoint,
    joints: Sequence[EngineJoint],
    rest: Array,
    answer: Callable[[Array, Array], tuple[Array, ...]],
    complaints: Sequence[str] = (),
) -> Original:
    """Return an engine's answers, M, bias and passive forces if any, in velocities asked about.

    Joints that are not asked about stay where they rest.
    """
    pairs = [*zip(pair(v, joints), joints, strict=True)]
    paired = {name: joint for name, joint in pairs if name}
    others = tuple(joint.name for name, joint in pairs if not name)
    nu = sum(WIDTHS[joint.kind] for joint in joints)
    results: list[list[Array]] = []
    for state in range(max(map(len, q.values()), default=1)):
        places, columns, drift = rest.copy(), [np.zeros((nu, 0))], np.zeros(nu)
        rates = [np.zeros(0)]
        for name, joint in paired.items():
            mine, speed = (np.atleast_1d(np.asarray(x[name][state], dtype=float)) for x in (q, v))
            span = slice(joint.rate, joint.rate + WIDTHS[joint.kind])
            block = np.zeros((nu, len(speed)))
            places[joint.at], block[span], drift[span] = joint.chart(mine, speed)
            columns.append(block)
            rates.append(speed)
        T = np.hstack(columns)
        M, bias, *passive = answer(places, T @ np.concatenate(rates))
        results.append([T.T @ M @ T, T.T @ (M @ drift + bias), *(T.T @ f for f in passive)])
    mass, bias, *passive = map(np.array, zip(*results, strict=True))
    held = passive[0] if passive else None
    return Original(tuple(paired), mass, bias, tuple(complaints), held, others)


def form_of(text: bytes) -> str:
    """Return the format of a text by its outermost element: "URDF", "MJCF" or "SDF"."""
    bare = re.sub(rb"<!--.*?-->", b"", text, flags=re.DOTALL)
    root = re.search(rb"<(robot|mujoco|sdf)\b", bare)
    forms = {b"mujoco": "MJCF", b"sdf": "SDF"}
    return "URDF" if root is None else forms.get(root[1], "URDF")


def attributes_of(text: bytes, tag: str, name: str) -> list[str]:
    """Return what an attribute of the elements with a tag says."""
    pattern = rb"""<%b\b[^>]*?\b%b\s*=\s*["']([^"']*)""" % (tag.encode(), name.encode())
    return [value.decode("utf-8", "replace") for value in re.findall(pattern, text)]


def free_root_of(text: bytes, v: ByJoint) -> str | None:
    """Return the joint in which the root of a URDF moves freely, which its text does not name."""
    if form_of(text) != "URDF":
        return None
    known = attributes_of(text, "joint", "name")
    free = (name for name, rows in v.items() if np.size(rows[0]) == WIDTHS["free"])
    return next((name for name in free if name not in known), None)
