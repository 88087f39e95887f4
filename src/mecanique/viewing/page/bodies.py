"""From shapes to meshcat's objects, under node names that are safe whatever the bodies are called.

Meshes are no objects of meshcat's: `mecanique.viewing.page.meshes` packs them, and the page hangs
them into the bodies' nodes.
"""

from __future__ import annotations

import uuid
from typing import Any, final

import numpy as np

from mecanique.viewing.page.window import RecorderWindow, meshcat, visualizer
from mecanique.viewing.scene.scene import GREY, Floats, Rgba, SceneBody, Shape

__all__ = ["draw_bodies"]

# three.js builds cylinders and cones along y, a mechanism's shapes stand along z
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


def draw_bodies(bodies: tuple[SceneBody, ...], window: RecorderWindow) -> None:
    """Send every shape of every body but meshes to a window; body k becomes node `n<k>`.

    Args:
        bodies: what to draw.
        window: where to.
    """
    root = visualizer(window)
    for k, body in enumerate(bodies):
        root[f"n{k}"].set_transform(np.eye(4))
        for j, (thing, material, pose) in enumerate(
            part for shape in body.shapes for part in _parts(shape)
        ):
            node = root[f"n{k}/s{j}"]
            node.set_object(thing, material)
            node.set_transform(pose)


def _parts(shape: Shape) -> list[tuple[Any, Any, Floats]]:
    """The objects, materials and poses that make one shape."""
    g, size, pose = meshcat().geometry, tuple(map(float, shape.size)), shape.pose
    paint = _material(shape.rgba or GREY)
    if shape.kind == "box":
        return [(g.Box(size), paint, pose)]
    if shape.kind == "sphere":
        return [(_Ball(*size), paint, pose)]
    if shape.kind == "ellipsoid":
        return [(_Ball(1.0), paint, pose @ np.diag([*size, 1.0]))]
    if shape.kind == "cylinder":
        return [(g.Cylinder(size[1], size[0]), paint, pose @ _UPRIGHT)]
    if shape.kind == "cone":
        return [(g.Cylinder(size[1], radiusTop=0.0, radiusBottom=size[0]), paint, pose @ _UPRIGHT)]
    if shape.kind == "capsule":
        caps = [(_Ball(size[0]), paint, pose @ _raised(z)) for z in (-size[1] / 2, size[1] / 2)]
        return [(g.Cylinder(size[1], size[0]), paint, pose @ _UPRIGHT), *caps]
    return []  # a mesh


def _raised(z: float) -> Floats:
    pose = np.eye(4)
    pose[2, 3] = z
    return pose


def _material(rgba: Rgba) -> Any:
    red, green, blue, opacity = (min(max(float(c), 0.0), 1.0) for c in rgba)
    color = (round(red * 255) << 16) | (round(green * 255) << 8) | round(blue * 255)
    return meshcat().geometry.MeshPhongMaterial(
        color=color, opacity=opacity, shininess=18, specular=0x222222
    )


@final
class _Ball:
    """A sphere with enough facets to look round; meshcat's has 20."""

    def __init__(self, radius: float) -> None:
        self.uuid = str(uuid.uuid4())
        facets = {"widthSegments": 40, "heightSegments": 28}
        self._data = {"uuid": self.uuid, "type": "SphereGeometry", "radius": radius, **facets}

    def intrinsic_transform(self) -> Floats:
        return np.eye(4)

    def lower_in_object(self, data: dict[str, Any]) -> str:
        data["geometries"].append(self._data)
        return self.uuid
