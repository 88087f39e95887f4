"""A surface of triangles with one color, whatever file it came from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from mecanique.viewing.scene.scene import Floats, Rgba


@final
@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles, each by its corners; normals follow from them.

    Args:
        corners: shape (m, 3, 3), in the file's units; counterclockwise from outside.
        rgba: color and opacity, each from 0 to 1; None if the file gives none.
    """

    corners: Floats
    rgba: Rgba | None = None


def by_color(surfaces: Iterable[Surface]) -> tuple[Surface, ...]:
    """Join surfaces of one color, in the order in which the colors appear.

    Args:
        surfaces: those without a triangle are left out.
    """
    found: dict[Rgba | None, list[Floats]] = {}
    for surface in surfaces:
        if len(surface.corners):
            found.setdefault(surface.rgba, []).append(surface.corners)
    return tuple(Surface(np.concatenate(parts), rgba) for rgba, parts in found.items())


def fan(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut polygons into triangles that share each polygon's first corner.

    Args:
        counts: shape (k,), number of corners of each polygon; fewer than three give no triangle.

    Returns:
        Shape (m, 3), places of the triangles' corners in the row of all corners.
    """
    starts = np.cumsum(counts) - counts
    triangles = np.maximum(counts - 2, 0)
    first = np.repeat(starts, triangles)
    step = np.arange(len(first)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)
