"""Shapes as meshcat's objects, under node names that are safe whatever the bodies' names.

Meshes are not sent as meshcat's objects: `mecanique.viewing.page.meshes` packs them, and the page
attaches them to the bodies' nodes.
"""

from __future__ import annotations

import uuid
from typing import Any, final

import numpy as np

from mecanique.viewing.page.window import RecorderWindow, meshcat, visualizer
from mecanique.viewing.scene.scene import GREY, Floats, Rgba, SceneBody, Shape

__all__ = ["draw_bodies"]

# cylinders of three.js point along y, those of a mechanism along z
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


def draw_bodies(bodies: tuple[SceneBody, ...], window: RecorderWindow) -> None:
    """Send all shapes except meshes to a window; body k becomes node `n<k>`."""
    root = visualizer(window)
    for k, body in enumerate(bodies):
        root[f"n{k}"].set_transform(np.eye(4))
        solids = [shape for shape in body.shapes if shape.kind != "mesh"]
        for j, shape in enumerate(solids):
            node = root[f"n{k}/s{j}"]
            node.set_object(_geometry(shape), _material(shape.rgba or GREY))
            node.set_transform(shape.pose @ _UPRIGHT if shape.kind == "cylinder" else shape.pose)


def _geometry(shape: Shape) -> Any:
    """One of meshcat's geometries."""
    geometry, size = meshcat().geometry, tuple(map(float, shape.size))
    match shape.kind:
        case "box":
            return geometry.Box(size)
        case "sphere":
            return _Ball(*size)
        case "cylinder":
            radius, length = size
            return geometry.Cylinder(length, radius)
    raise ValueError(f"no geometry of kind {shape.kind!r}")


def _material(rgba: Rgba) -> Any:
    red, green, blue, opacity = (min(max(float(c), 0.0), 1.0) for c in rgba)
    color = (round(red * 255) << 16) | (round(green * 255) << 8) | round(blue * 255)
    return meshcat().geometry.MeshPhongMaterial(
        color=color, opacity=opacity, shininess=18, specular=0x222222
    )


@final
class _Ball:
    """A sphere with enough facets to look round; meshcat's own has 20."""

    def __init__(self, radius: float) -> None:
        self.uuid = str(uuid.uuid4())
        facets = {"widthSegments": 40, "heightSegments": 28}
        self._data = {"uuid": self.uuid, "type": "SphereGeometry", "radius": radius, **facets}

    def intrinsic_transform(self) -> Floats:
        return np.eye(4)

    def lower_in_object(self, data: dict[str, Any]) -> str:
        data["geometries"].append(self._data)
        return self.uuid
