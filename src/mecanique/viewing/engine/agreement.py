"""Compare what a page's program gives with the scene, whose numbers Pinocchio gave."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mecanique.errors import DerivationError
from mecanique.model.quaternions import to_matrices
from mecanique.viewing.scene.scene import Floats, Scene

TOLERANCE = 1e-7
"""Largest difference, relative to the largest number of its kind, that counts as agreement."""


def find_unknown(
    scene: Scene, numbers: Floats, chosen: np.ndarray, missing: Sequence[bool]
) -> tuple[int, ...]:
    """Return the columns of the scene's table that the program does not give.

    Args:
        scene: the scene.
        numbers: what the program gives, with rotation matrices, shape (chosen, columns + 5 nb).
        chosen: at which instants.
        missing: whether each number is unknown to the program.

    Raises:
        DerivationError: if bodies or coordinates are elsewhere.
    """
    unknown: list[int] = []
    at, column = 0, 0
    for what, group, scale in _groups(scene):
        width = group.shape[1]
        ours = numbers[:, at : at + width]
        pose = what.startswith("turn of ")
        if any(missing[at : at + width]):
            unknown += range(column, column + width)
        else:
            difference = float(np.abs(ours - group[chosen]).max(initial=0.0))
            if not difference <= TOLERANCE * scale:
                if what.startswith(("pose of ", "turn of ", "series of motion", "points of ")):
                    raise DerivationError(
                        f"the program gives another {what} than the motion, by {difference:.1e}"
                    )
                unknown += range(column, column + width)
        at += width
        column += 4 if pose else width
    return tuple(unknown)


def _groups(scene: Scene) -> Iterator[tuple[str, Floats, float]]:
    """Columns that belong together, and how large such numbers are."""
    n = len(scene.t)
    points = [scene.positions, *(line.points for line in scene.lines)]
    points += [trace.points for trace in scene.traces]
    extent = max(1e-9, *(float(np.abs(each).max(initial=0.0)) for each in points))
    for k, body in enumerate(scene.bodies):
        turn = to_matrices(scene.quaternions[:, k]).reshape(n, 9)
        yield f"pose of {body.name}", scene.positions[:, k], extent
        yield f"turn of {body.name}", turn, 1.0
    force = max((float(np.abs(a.vector).max()) for a in scene.arrows), default=0.0)
    for arrow in scene.arrows:
        yield f"arrow {arrow.name}", np.hstack([arrow.origin, arrow.vector]), max(force, extent)
    for line in scene.lines:
        yield f"points of {line.name}", line.points.reshape(n, 6), extent
    for trace in scene.traces:
        yield f"points of {trace.name}", trace.points, extent
    sizes: dict[str, float] = {}
    for each in scene.series:
        size = float(np.abs(each.values).max())
        sizes[each.unit] = max(sizes.get(each.unit, 1e-9), size)
    for each in scene.series:
        what = "series of motion" if each.group == "Coordinates" else "series"
        yield f"{what} {each.name}", each.values[:, None], sizes[each.unit]
    work = max((float(np.abs(row.values).max()) for row in scene.document.ledger.rows), default=0.0)
    for row in scene.document.ledger.rows:
        yield f"work of {row.name}", row.values, max(work, 1e-9)
