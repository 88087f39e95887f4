"""A robot as another engine reads it from its file.

Each engine's `read` takes the text, gravity (3,) [m/s²], positions and velocities of joints; it
raises EngineError with the engine's own reason if the engine refuses the text.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from mecanique.arrays import Array

ByJoint: TypeAlias = Mapping[str, Sequence[float]]
"""A number in each of n states, by name of the joint."""


@final
@dataclass(frozen=True)
class Original:
    """An engine's results for a robot with a fixed root; only joints with one coordinate move."""

    joints: tuple[str, ...]  # names of the joints with one coordinate, in the order of the results
    mass: Array  # mass matrices, shape (n, k, k)
    bias: Array  # shape (n, k)
    complaints: tuple[str, ...]  # the engine's own messages about the file
    passive: Array | None = None  # forces of springs and dampers, shape (n, k), if it has any


def form_of(text: bytes) -> str:
    """Return the format of a text by its outermost element: "URDF", "MJCF" or "SDF"."""
    bare = re.sub(rb"<!--.*?-->", b"", text, flags=re.DOTALL)
    root = re.search(rb"<(robot|mujoco|sdf)\b", bare)
    forms = {b"mujoco": "MJCF", b"sdf": "SDF"}
    return "URDF" if root is None else forms.get(root[1], "URDF")


def columns(values: ByJoint, joints: Sequence[str]) -> Array:
    """Return the numbers of some joints in all states, shape (n, k); zero where none is given."""
    count = max(map(len, values.values()), default=1)
    nothing = [0.0] * count
    by_joint = [values.get(name, nothing) for name in joints]
    columns_: Array = np.array(by_joint, dtype=float).reshape(len(joints), count).T
    return columns_
