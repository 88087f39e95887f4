"""From shapes to meshcat's objects, under node names that are safe whatever the bodies are called."""

from __future__ import annotations

import re
import uuid
from typing import Any, final

import numpy as np

from mecanique.errors import InputError
from mecanique.view.scene import GREY, Floats, Rgba, SceneBody, Shape
from mecanique.view.window import RecorderWindow, meshcat, visualizer

__all__ = ["draw_bodies"]

# three.js builds cylinders and cones along y, a mechanism's shapes stand along z
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
_BLANK = "data:image/gif;base64,R0lGODlhAQABAIAAAP///wAAACH5BAAAAAAALAAAAAABAAEAAAICRAEAOw=="


def draw_bodies(bodies: tuple[SceneBody, ...], window: RecorderWindow) -> None:
    """Send every shape of every body to a window; body k becomes node `n<k>`.

    Args:
        bodies: what to draw.
        window: where to.
    """
    root = visualizer(window)
    for k, body in enumerate(bodies):
        root[f"n{k}"].set_transform(np.eye(4))
        for j, (thing, material, pose) in enumerate(part for shape in body.shapes for part in _parts(shape)):
            node = root[f"n{k}/s{j}"]
            if material is None:
                node.window.send(_Raw(thing, node.path))
            else:
                node.set_object(thing, material)
            node.set_transform(pose)


def _parts(shape: Shape) -> list[tuple[Any, Any, Floats]]:
    """The objects, materials and poses that make one shape."""
    g, size, pose = meshcat().geometry, tuple(map(float, shape.size)), shape.pose
    paint = _material(shape.rgba or GREY)
    if shape.kind == "box":
        return [(g.Box(size), paint, pose)]
    if shape.kind == "sphere":
        return [(_ball(*size), paint, pose)]
    if shape.kind == "ellipsoid":
        return [(_ball(1.0), paint, pose @ np.diag([*size, 1.0]))]
    if shape.kind == "cylinder":
        return [(g.Cylinder(size[1], size[0]), paint, pose @ _UPRIGHT)]
    if shape.kind == "cone":
        return [(g.Cylinder(size[1], radiusTop=0.0, radiusBottom=size[0]), paint, pose @ _UPRIGHT)]
    if shape.kind == "capsule":
        caps = [(_ball(size[0]), paint, pose @ _raised(z)) for z in (-size[1] / 2, size[1] / 2)]
        return [(g.Cylinder(size[1], size[0]), paint, pose @ _UPRIGHT), *caps]
    return [_mesh(shape)]


def _raised(z: float) -> Floats:
    pose = np.eye(4)
    pose[2, 3] = z
    return pose


def _material(rgba: Rgba) -> Any:
    red, green, blue, opacity = (min(max(float(c), 0.0), 1.0) for c in rgba)
    color = (round(red * 255) << 16) | (round(green * 255) << 8) | round(blue * 255)
    return meshcat().geometry.MeshPhongMaterial(color=color, opacity=opacity, shininess=18, specular=0x222222)


def _mesh(shape: Shape) -> tuple[Any, Any, Floats]:
    """A mesh file; without a color of its own the file's materials are used, where the format has any."""
    path = shape.path
    if path is None or not path.is_file():
        raise InputError(f"mesh file {path}: there is no such file")
    form, g = path.suffix.lower().lstrip("."), meshcat().geometry
    scale = np.diag([*map(float, shape.size), 1.0])
    if form == "stl":
        contents = g.StlMeshGeometry.from_file(str(path)).contents
        return _mesh_file(contents, form), _material(shape.rgba or GREY), shape.pose @ scale
    if form not in ("obj", "dae"):
        raise InputError(f"mesh file {path}: expected STL, OBJ or DAE, got {form!r}")
    text = path.read_text(encoding="utf-8", errors="replace")
    if form == "dae" and (unit := re.search(r"<unit\b[^>]*\bmeter\s*=\s*[\"']([0-9.eE+-]+)[\"']", text)):
        scale = scale @ np.diag([*[float(unit[1])] * 3, 1.0])
    if shape.rgba is not None:
        return _mesh_file(text, form), _material(shape.rgba), shape.pose @ scale
    library = ""
    if form == "obj" and (named := re.search(r"^mtllib\s+(\S+)", text, re.MULTILINE)):
        beside = path.parent / named[1]
        library = beside.read_text(encoding="utf-8", errors="replace") if beside.is_file() else ""
    return {"format": form, "data": text, "mtl_library": library}, None, shape.pose @ scale


@final
class _Geometry:
    """What meshcat's own geometries have in common."""

    def __init__(self, **data: Any) -> None:
        self.uuid = str(uuid.uuid4())
        self._data = {"uuid": self.uuid, **data}

    def intrinsic_transform(self) -> Floats:
        return np.eye(4)

    def lower_in_object(self, data: dict[str, Any]) -> str:
        data["geometries"].append(self._data)
        return self.uuid


def _ball(radius: float) -> _Geometry:
    """A sphere with enough facets to look round; meshcat's has 20."""
    return _Geometry(type="SphereGeometry", radius=radius, widthSegments=40, heightSegments=28)


def _mesh_file(contents: Any, form: str) -> _Geometry:
    """A file's surface under the name that meshcat's viewer no longer warns about."""
    return _Geometry(type="_meshfile_geometry", format=form, data=contents)


@final
class _Raw:
    """A mesh with its own materials, which meshcat's viewer knows and its Python side has no class for.

    Textures are left out: every image the file names is answered by a blank one, so nothing is requested.
    """

    def __init__(self, thing: dict[str, str], path: Any) -> None:
        self._thing, self._path = thing, path

    def lower(self) -> dict[str, Any]:
        text = self._thing["data"] + self._thing["mtl_library"]
        names = re.findall(r"<init_from>\s*([^<]+?)\s*</init_from>", text)
        names += re.findall(r"^\s*(?:map_\w+|bump|disp)\s+(\S+)\s*$", text, re.MULTILINE)
        thing = {"uuid": str(uuid.uuid4()), "type": "_meshfile_object", "resources": dict.fromkeys(names, _BLANK)}
        scene = {"metadata": {"version": 4.5, "type": "Object"}, "geometries": [], "materials": []}
        whole = scene | {"object": thing | self._thing}
        return {"type": "set_object", "object": whole, "path": self._path.lower()}
