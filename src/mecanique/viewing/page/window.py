"""Record the latest state for meshcat's viewer; a window for `meshcat.Visualizer` too."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeAlias, final

import numpy as np

from mecanique.errors import EngineError, InputError
from mecanique.viewing.scene.scene import GREY, Floats, Rgba, SceneBody, SceneShape


class Command(Protocol):
    """What meshcat sends: an object that turns itself into plain data."""

    def lower(self) -> dict[str, Any]:
        """Return the command as a dictionary."""


Key: TypeAlias = tuple[str, str, str]
"""Path, type of command, property."""


@final
class LatestCommands:
    """Packed commands; only the last one for each path, type and property is kept."""

    _ORDER: ClassVar = {"delete": 0, "set_object": 1, "set_property": 2, "set_transform": 3}

    def __init__(self, blobs: dict[Key, bytes] | None = None) -> None:
        self._blobs = blobs or {}

    def put(self, key: Key, blob: bytes, *, keep_deletions: bool) -> None:
        """Add a command; a deletion removes everything below its path."""
        if key[1] == "delete":
            self._blobs = {
                k: b
                for k, b in self._blobs.items()
                if k[0] != key[0] and not k[0].startswith(f"{key[0]}/")
            }
            if not keep_deletions:
                return
        self._blobs[key] = blob

    def merge(self, later: LatestCommands) -> None:
        """Add later commands."""
        for key, blob in sorted(later._blobs.items(), key=self._rank):
            self.put(key, blob, keep_deletions=True)

    def commands(self) -> list[bytes]:
        """Return the commands: deletions, objects, properties, transforms."""
        return [blob for _, blob in sorted(self._blobs.items(), key=self._rank)]

    def _rank(self, item: tuple[Key, bytes]) -> int:
        return self._ORDER[item[0][1]]


@final
class RecorderWindow:
    """Keep what a viewer needs to show the present scene: the last writer of each property wins."""

    web_url = "about:blank"

    def __init__(self, on_change: Callable[[], None] | None = None) -> None:
        self._on_change = on_change
        self._lock = threading.Lock()
        self._state = LatestCommands()
        self._changed = LatestCommands()

    def send(self, command: Command) -> None:
        """Take a command from meshcat's visualizer, as `put` does."""
        self.put(command.lower())

    def put(self, command: dict[str, Any]) -> None:
        """Take a command to meshcat's viewer as plain data."""
        import umsgpack

        data = _plain(command)
        kind, path = data["type"], data["path"].rstrip("/")
        if kind not in ("set_object", "set_transform", "set_property", "delete"):
            raise InputError(
                "a recorder window takes objects, transforms, properties and deletions, "
                f"not {kind!r}"
            )
        key, blob = (path, kind, str(data.get("property", ""))), umsgpack.packb(data)
        with self._lock:
            self._state.put(key, blob, keep_deletions=False)
            self._changed.put(key, blob, keep_deletions=True)
        if self._on_change:
            self._on_change()

    def commands(self) -> list[bytes]:
        """Return the packed commands that build the scene: objects first, transforms last."""
        with self._lock:
            return self._state.commands()

    def changes(self) -> LatestCommands:
        """Return the changes since the last call, only the latest state of each path."""
        with self._lock:
            changed, self._changed = self._changed, LatestCommands()
        return changed


def _plain(value: Any) -> Any:
    """Make numpy's numbers Python's own, as the packer needs them, and refuse NaN."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return [_plain(entry) for entry in value.tolist()]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        raise InputError(f"a command for the viewer: expected finite numbers, got {value}")
    return value


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

_ROUND = 50
"""Facets around a cylinder."""


def draw_bodies(bodies: tuple[SceneBody, ...], window: RecorderWindow) -> None:
    """Send all shapes except meshes to a window; body k becomes node `n<k>`."""
    for k, body in enumerate(bodies):
        _move(window, f"/meshcat/n{k}", np.eye(4))
        solids = [shape for shape in body.shapes if shape.kind != "mesh"]
        for j, shape in enumerate(solids):
            path = f"/meshcat/n{k}/s{j}"
            window.put({"type": "set_object", "path": path, "object": _object(shape, f"{k}.{j}")})
            upright = shape.pose @ _UPRIGHT if shape.kind == "cylinder" else shape.pose
            _move(window, path, upright)


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
        "turn": shape.pose[:3, :3].ravel().tolist(),
        "place": shape.pose[:3, 3].tolist(),
        "color": f"#{material['color']:06x}",
        "opacity": material["opacity"],
    }


def _move(window: RecorderWindow, path: str, pose: Floats) -> None:
    window.put({"type": "set_transform", "path": path, "matrix": pose.T.ravel()})


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
            "matrix": np.eye(4).ravel(),
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
            radius, length = size
            radii = {"radiusTop": radius, "radiusBottom": radius}
            measures = {**radii, "height": length, "radialSegments": _ROUND}
            return {"type": "CylinderGeometry", **measures}
    raise ValueError(f"no geometry of kind {shape.kind!r}")


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
