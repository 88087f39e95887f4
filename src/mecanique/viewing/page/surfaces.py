"""The meshes of a scene for its page, in few bytes: corners on a fine grid, as differences.

Every coordinate is rounded to 1/8192 of the mesh's longest edge, finer than any screen shows.
Equal points become one. Triangles are put in an order in which neighbors follow one another, and
most share an edge with the one before, so that one number says which. Points are numbered in the
order in which triangles first use them; any other corner is written by how far back it was used, 0
for a new one. The new corner of a triangle lies near the far corner of a parallelogram with the
triangle before; what is written is how it differs. Normals are not written: the page computes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import InputError
from mecanique.urdf.meshes import Surface, read_mesh
from mecanique.viewing.page.keyframes import varints
from mecanique.viewing.scene.scene import GREY, Floats, Rgba, SceneBody, Shape

STEPS = 2**13
_BITS = 20  # of a coordinate on the grid, where three are one key

_OVER_LAST, _OVER_FIRST, _ELSEWHERE = 0, 1, 2
"""The edge of the triangle before over which the walk came: third to second corner, or first to
third; or the triangle's edge is written out."""


@final
@dataclass(frozen=True)
class PackedSurface:
    """A surface for the page."""

    points: int
    triangles: int
    step: float  # the grid's [file's units]
    low: tuple[float, float, float]
    rgba: Rgba | None  # color and opacity; None if the file gives none
    body: bytes


def pack_surfaces(surfaces: Sequence[Surface], *, quick: bool = False) -> tuple[PackedSurface, ...]:
    """Pack the surfaces of one file on one grid, so that they still fit together."""
    if not surfaces:
        return ()
    low = np.min([surface.corners.min(axis=(0, 1)) for surface in surfaces], axis=0)
    high = np.max([surface.corners.max(axis=(0, 1)) for surface in surfaces], axis=0)
    step = max(float(np.max(high - low)) / STEPS, 1e-300)
    packed = (_pack_surface(surface, low, step, quick) for surface in surfaces)
    return tuple(each for each in packed if each.triangles)


def _pack_surface(surface: Surface, low: Floats, step: float, quick: bool) -> PackedSurface:
    whole = np.round((surface.corners - low) / step).astype(np.int64).reshape(-1, 3)
    keys = (whole[:, 0] << 2 * _BITS) | (whole[:, 1] << _BITS) | whole[:, 2]
    _, place, numbers = np.unique(keys, return_index=True, return_inverse=True)
    a, b, c = (triangles := numbers.reshape(-1, 3)).T
    walked = triangles[(a != b) & (b != c) & (c != a)]
    if not quick:
        walked = _side_by_side(walked, len(place))
    used, first = np.unique(walked, return_index=True)
    order = used[np.argsort(first)]
    rank = np.empty(len(place), dtype=np.int64)
    rank[order] = np.arange(len(order))
    triangles, points = rank[walked], whole[place[order]]
    flat = triangles.ravel()
    met = np.maximum.accumulate(np.concatenate([[-1], flat]))[:-1] + 1
    back = (met - flat).reshape(-1, 3)
    way, opposite = _ways_in(triangles)
    written = way == _ELSEWHERE
    moves = points - _guess(points, triangles, back == 0, opposite)
    columns = [way, *back[written, :2].T, back[:, 2], *moves.T]
    body = b"".join(map(varints, columns))
    x, y, z = low.tolist()
    return PackedSurface(
        points=len(points),
        triangles=len(triangles),
        step=step,
        low=(x, y, z),
        rgba=surface.rgba,
        body=body,
    )


def _side_by_side(triangles: NDArray[np.int64], points: int) -> NDArray[np.int64]:
    """The triangles in the order of a walk, each from the edge over which the walk enters it."""
    # edge 3 k + i of triangle k runs from its corner i to the next
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    edges, owner = np.unique(start * points + end, return_index=True)
    # a neighbor runs along the common edge the other way
    turned = end * points + start
    seat = np.minimum(np.searchsorted(edges, turned), max(len(edges) - 1, 0))
    across = np.where(edges[seat] == turned, owner[seat], -1) if len(edges) else owner
    beyond: list[int] = across.tolist()
    new, entered = [True] * len(triangles), list[int]()
    for first in range(0, 3 * len(triangles), 3):
        waiting = [first]
        while waiting:
            edge = waiting.pop()
            k, i = divmod(edge, 3)
            if edge < 0 or not new[k]:
                continue
            new[k] = False
            entered.append(edge)
            if edge == first:
                waiting.append(beyond[edge])
            waiting.append(beyond[3 * k + (i + 2) % 3])
            waiting.append(beyond[3 * k + (i + 1) % 3])
    edges = np.array(entered, dtype=np.int64)[:, None]
    ordered: NDArray[np.int64] = triangles[edges // 3, (edges % 3 + np.arange(3)) % 3]
    return ordered


def _ways_in(triangles: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """How each triangle is entered, and the corner of the triangle before that is left behind."""
    before = np.concatenate([np.full((1, 3), -1), triangles[:-1]])
    (a, b, c), (i, j, _) = before.T, triangles.T
    way = np.select([(i == c) & (j == b), (i == a) & (j == c)], [_OVER_LAST, _OVER_FIRST], 2)
    return way, np.where(way == _OVER_LAST, a, np.where(way == _OVER_FIRST, b, -1))


def _guess(
    points: NDArray[np.int64],
    triangles: NDArray[np.int64],
    new: NDArray[np.bool_],
    opposite: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Where a reader expects each point when its first triangle is read."""
    guessed = np.zeros_like(points)
    first, second, third = (triangles[new[:, k], k] for k in range(3))
    guessed[first[1:]] = points[first[1:] - 1]
    guessed[second] = points[triangles[new[:, 1], 0]]
    i, j, _ = triangles[new[:, 2]].T
    left = opposite[new[:, 2]]
    corner = points[i] + points[j] - points[left]
    guessed[third] = np.where(left[:, None] < 0, points[j], corner)
    return guessed


def mesh_parcel(
    bodies: Sequence[SceneBody], *, quick: bool = False
) -> tuple[dict[str, Any], bytes]:
    """Return the meshes of a scene's bodies as plain data for the page's header, and as bytes."""
    places: dict[Path, range] = {}
    surfaces: list[PackedSurface] = []
    drawn = []
    for k, path, shape in _meshes(bodies):
        if path not in places:
            packed = _pack(path, quick)
            places[path] = range(len(surfaces), len(surfaces) + len(packed))
            surfaces += packed
        matrix = (shape.pose @ np.diag([*map(float, shape.size), 1.0])).ravel().tolist()
        for place in places[path]:
            in_file, given = surfaces[place].rgba, shape.rgba
            # one color must not paint over a mesh that has several
            rgba = (in_file or given if len(places[path]) > 1 else given or in_file) or GREY
            kept = [min(max(float(c), 0.0), 1.0) for c in rgba]
            drawn.append({"body": k, "surface": place, "rgba": kept, "matrix": matrix})
    heads = [
        {"points": s.points, "triangles": s.triangles, "step": s.step, "low": s.low}
        for s in surfaces
    ]
    return {"surfaces": heads, "drawn": drawn}, b"".join(surface.body for surface in surfaces)


def _meshes(bodies: Sequence[SceneBody]) -> Iterator[tuple[int, Path, Shape]]:
    for k, body in enumerate(bodies):
        for shape in body.shapes:
            if shape.path is not None:
                yield k, shape.path, shape


def _pack(path: Path, quick: bool) -> tuple[PackedSurface, ...]:
    """A file's surfaces; a file is packed again only if it has changed."""
    if not path.is_file():
        raise InputError(f"mesh file {path}: there is no such file")
    return _remember(path, path.stat().st_mtime_ns, quick)


@lru_cache(maxsize=64)
def _remember(path: Path, changed: int, quick: bool) -> tuple[PackedSurface, ...]:
    del changed  # enough to tell one version of the file from the next
    return pack_surfaces(read_mesh(path), quick=quick)
