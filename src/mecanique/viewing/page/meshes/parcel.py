"""All meshes of a scene for its page: each file's surfaces once, and where they are drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from mecanique.errors import InputError
from mecanique.urdf.meshes import read_mesh
from mecanique.viewing.page.meshes.packing import PackedSurface, pack_surfaces
from mecanique.viewing.scene.scene import GREY, SceneBody, Shape


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
