"""Meshcat's viewer, and the commands that put the solids of bodies into it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mecanique.errors import EngineError
from mecanique.viewing.scene.scene import GREY, Floats, Rgba, SceneBody, SceneShape


def viewer_directory() -> Path:
    """Return the directory of meshcat's built viewer."""
    from importlib.util import find_spec

    spec = find_spec("meshcat")
    for place in (spec.submodule_search_locations or []) if spec else []:
        folder = Path(place) / "viewer" / "dist"
        if (folder / "main.min.js").is_file():
            return folder
    raise EngineError(
        "meshcat's viewer (viewer/dist/main.min.js) is not installed; try: pip install meshcat"
    )


# cylinders of three.js point along y, those of a mechanism along z
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])

_RING = 0.92
"""Inner radius of a ring, in its outer one."""

_ROUND = 50
"""Facets around a cylinder."""


def draw_bodies(bodies: Sequence[SceneBody]) -> list[bytes]:
    """Return the packed commands that draw all shapes but meshes; body k becomes node `n<k>`."""
    import umsgpack

    objects, places = list[dict[str, Any]](), list[dict[str, Any]]()
    for k, body in enumerate(bodies):
        places.append(_move(f"/meshcat/n{k}", np.eye(4)))
        solids = [shape for shape in body.shapes if shape.kind != "mesh"]
        for j, shape in enumerate(solids):
            path = f"/meshcat/n{k}/s{j}"
            objects.append(
                {"type": "set_object", "path": path, "object": _object(shape, f"{k}.{j}")}
            )
            upright = shape.pose @ _UPRIGHT if shape.kind == "cylinder" else shape.pose
            places.append(_move(path, upright))
    return [umsgpack.packb(command) for command in (*objects, *places)]


def solids_of(body: SceneBody) -> list[dict[str, Any]] | None:
    """A body's solids in plain numbers, for the page's first sketch; None where it has a mesh."""
    if any(shape.kind == "mesh" for shape in body.shapes):
        return None
    return [_solid(shape) for shape in body.shapes]


def _solid(shape: SceneShape) -> dict[str, Any]:
    """A solid: turned by a matrix, row by row, and placed in its body's frame."""
    material = _material(shape.rgba or GREY)
    return {
        "kind": shape.kind,
        "size": list(map(float, shape.size)),
        "profile": _profile(shape) if shape.kind == "cylinder" else [],
        "turn": shape.pose[:3, :3].ravel().tolist(),
        "place": shape.pose[:3, 3].tolist(),
        "color": f"#{material['color']:06x}",
        "opacity": material["opacity"],
    }


def _move(path: str, pose: Floats) -> dict[str, Any]:
    return {"type": "set_transform", "path": path, "matrix": pose.T.ravel().tolist()}


def _object(shape: SceneShape, identity: str) -> dict[str, Any]:
    """A solid as three.js reads it."""
    geometry, material = f"geometry {identity}", f"material {identity}"
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": geometry, **_geometry(shape)}],
        "materials": [{"uuid": material, **_material(shape.rgba or GREY)}],
        "object": {
            "uuid": f"solid {identity}",
            "type": "Mesh",
            "geometry": geometry,
            "material": material,
            "matrix": np.eye(4).ravel().tolist(),
        },
    }


def _geometry(shape: SceneShape) -> dict[str, Any]:
    size = tuple(map(float, shape.size))
    match shape.kind:
        case "box":
            width, height, depth = size
            return {"type": "BoxGeometry", "width": width, "height": height, "depth": depth}
        case "sphere":
            (radius,) = size  # meshcat's own 20 segments do not look round
            facets = {"widthSegments": 40, "heightSegments": 28}
            return {"type": "SphereGeometry", "radius": radius, **facets}
        case "cylinder":
            # every corner twice, so that edges are sharp
            points = [{"x": x, "y": y} for x, y in _profile(shape) for _ in (0, 1)]
            return {"type": "LatheGeometry", "points": points, "segments": _ROUND}
    raise ValueError(f"no geometry of kind {shape.kind!r}")


def _profile(shape: SceneShape) -> list[tuple[float, float]]:
    """The distance from its axis and the height of the corners that turn into a round solid."""
    radius, length = map(float, shape.size)
    low, high = -length / 2, length / 2
    match shape.form:
        case "thin ring":
            inner = _RING * radius
            corners = [(inner, low), (radius, low), (radius, high), (inner, high), (inner, low)]
        case "solid cone":  # drawn by its base, an eighth as high as it is
            corners = [(0.0, high - 8 * length), (radius, high), (0.0, high)]
        case _:
            corners = [(0.0, low), (radius, low), (radius, high), (0.0, high)]
    return corners


def _material(rgba: Rgba) -> dict[str, Any]:
    red, green, blue, opacity = (min(max(float(c), 0.0), 1.0) for c in rgba)
    return {
        "type": "MeshPhongMaterial",
        "color": (round(red * 255) << 16) | (round(green * 255) << 8) | round(blue * 255),
        "specular": 0x222222,
        "shininess": 18,
        "reflectivity": 0.5,
        "opacity": opacity,
        "transparent": opacity < 1,
        "side": 2,
    }
