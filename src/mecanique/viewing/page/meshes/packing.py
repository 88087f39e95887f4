"""Surfaces in few bytes: corners on a fine grid, each point once, all as differences.

Every coordinate is rounded to 1/16384 of the mesh's longest edge, finer than any screen shows.
Equal points become one. Triangles are put in an order in which neighbors follow one another; points
are numbered in the order in which triangles first use them, and a triangle states how far back each
of its points was used, 0 for a new one. Most such numbers are small. Normals are not written: the
page computes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from mecanique.viewing.page.keyframes import varints
from mecanique.viewing.page.meshes.surface import Surface
from mecanique.viewing.scene.scene import Floats, Rgba

__all__ = ["PackedSurface", "pack_surfaces"]

STEPS = 2**14


@final
@dataclass(frozen=True)
class PackedSurface:
    """A surface for the page.

    Args:
        points: how many.
        triangles: how many.
        step: the grid's [file's units].
        low: origin of the grid.
        rgba: color and opacity; None if the file gives none.
        body: the points' coordinates, axis by axis, then the triangles, corner by corner, as
            variable-length integers.
    """

    points: int
    triangles: int
    step: float
    low: tuple[float, float, float]
    rgba: Rgba | None
    body: bytes


def pack_surfaces(surfaces: Sequence[Surface]) -> tuple[PackedSurface, ...]:
    """Pack the surfaces of one file on one grid, so that they still fit together.

    Args:
        surfaces: with at least one triangle each.
    """
    if not surfaces:
        return ()
    low = np.min([surface.corners.min(axis=(0, 1)) for surface in surfaces], axis=0)
    high = np.max([surface.corners.max(axis=(0, 1)) for surface in surfaces], axis=0)
    step = max(float(np.max(high - low)) / STEPS, 1e-300)
    packed = (_pack(surface, low, step) for surface in surfaces)
    return tuple(each for each in packed if each.triangles)


def _pack(surface: Surface, low: Floats, step: float) -> PackedSurface:
    whole = np.round((surface.corners - low) / step).astype(np.int64)
    points, numbers = np.unique(whole.reshape(-1, 3), axis=0, return_inverse=True)
    triangles = _side_by_side(numbers.reshape(-1, 3))
    flat = triangles.ravel()
    used, first = np.unique(flat, return_index=True)
    order = used[np.argsort(first)]
    rank = np.empty(len(points), dtype=np.int64)
    rank[order] = np.arange(len(order))
    met = np.maximum.accumulate(np.concatenate([[-1], rank[flat]]))[:-1] + 1
    moves = np.diff(points[order], axis=0, prepend=0)
    back = (met - rank[flat]).reshape(-1, 3)
    body = b"".join(varints(column) for column in (*moves.T, *back.T))
    x, y, z = low.tolist()
    return PackedSurface(len(order), len(triangles), step, (x, y, z), surface.rgba, body)


def _side_by_side(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles that have an area, each from the edge over which a walk enters it."""
    a, b, c = triangles.T
    corners: list[list[int]] = triangles[(a != b) & (b != c) & (c != a)].tolist()
    beside: dict[tuple[int, int], int] = {}
    for k, (i, j, m) in enumerate(corners):
        for edge in ((i, j), (j, m), (m, i)):
            beside.setdefault(edge, k)
    new, ordered = [True] * len(corners), []
    for start, (i, j, _) in enumerate(corners):
        edges = [(i, j)] if new[start] else []
        while edges:
            edge = edges.pop()
            k = start if new[start] else beside.get(edge, start)
            if not new[k]:
                continue
            new[k] = False
            i, j, m = corners[k]
            while (i, j) != edge:
                i, j, m = j, m, i
            ordered.append((i, j, m))
            # a neighbor runs along the common edge the other way
            edges += [(i, m), (m, j)] if k != start else [(j, i), (i, m), (m, j)]
    return np.array(ordered, dtype=np.int64).reshape(-1, 3)
