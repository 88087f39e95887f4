"""Surfaces of mesh files (STL, OBJ, COLLADA), within limits of time and memory.

Read without another library, since every page of a robot needs them.

Of COLLADA: triangles and polygons, placed by the scene's nodes, with their materials' colors. The
file's unit is applied; its up axis is not, because a URDF's frames are the mesh's own. Textures,
lights, cameras and animations are left out; a skin is drawn in its original pose.
"""

from __future__ import annotations

import re
import warnings
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import TypeVar, final
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.files import recognize
from mecanique.model.bodies.visuals import Rgba
from mecanique.model.placement import pose_at, turn_about
from mecanique.safe_xml import XmlRefusedError, tree_of

MOST_BYTES = 100_000_000
"""Largest file that is read."""

MOST_TRIANGLES = 2_000_000
"""Most triangles of a file: a page of more moves no longer, and robots have a tenth."""

_MOST_STEPS = 100_000
"""Most nodes and instances of a scene; nodes that refer to one another twice double each time."""


@final
@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles, each by its corners; normals follow from them."""

    corners: Array  # shape (m, 3, 3), in the file's units; counterclockwise from outside
    rgba: Rgba | None = None  # color and opacity, each from 0 to 1; None if the file gives none


def by_color(surfaces: Iterable[Surface]) -> tuple[Surface, ...]:
    """Join surfaces of one color, in the order of the colors; empty surfaces are left out."""
    colors: dict[Rgba | None, list[Array]] = {}
    for surface in surfaces:
        if len(surface.corners):
            colors.setdefault(surface.rgba, []).append(surface.corners)
    return tuple(Surface(np.concatenate(parts), rgba) for rgba, parts in colors.items())


def _limit(triangles: int) -> None:
    if triangles > MOST_TRIANGLES:
        raise InputError(f"expected at most {MOST_TRIANGLES:,} triangles, got {triangles:,}")


def fan(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut polygons, shape (k,) corners each, into triangles that share a corner, shape (m, 3)."""
    starts = np.cumsum(counts) - counts
    triangles = np.maximum(counts - 2, 0)
    _limit(int(triangles.sum()))
    first = np.repeat(starts, triangles)
    step = np.arange(len(first)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([first, first + step + 1, first + step + 2], axis=1)


_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_HEAD = 84
_VERTEX = re.compile(rb"(?<!\S)vertex(?!\S)(?:\s+(\S+)\s+(\S+)\s+(\S+))?")


def read_stl(data: bytes) -> tuple[Surface, ...]:
    """Read the triangles of an STL file, binary if its head states their number, else text."""
    count = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
    if len(data) >= _HEAD + count * _FACET.itemsize and not (
        data.startswith(b"solid") and b"facet" in data[:1000]
    ):
        _limit(count)
        facets = np.frombuffer(data, _FACET, count, _HEAD)
        return (Surface(facets["corners"].astype(np.float64)),)
    numbers = array("d")
    try:
        for vertex in _VERTEX.finditer(data):
            numbers.extend(map(float, vertex.groups()))
            _limit(len(numbers) // 9)
        if not numbers and not data.lstrip().startswith(b"solid"):
            raise ValueError
        return (Surface(np.array(numbers).reshape(-1, 3, 3)),)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            "expected an STL file, got one that breaks off or holds no triangles"
        ) from None


def read_obj(data: bytes, folder: Path) -> tuple[Surface, ...]:
    """Read the faces of an OBJ file by material; a missing material library is ignored."""
    # arrays take a tenth of what lists of numbers do
    points, triangles = array("d"), 0
    faces: dict[str, tuple[array[int], array[int]]] = {}
    colors: dict[str, Rgba] = {}
    material = ""
    for number, raw in enumerate(BytesIO(data), 1):
        line = raw.decode("utf-8", "replace")
        word, *rest = line.split() or [""]
        try:
            if word == "v":
                x, y, z = rest[:3]
                points.extend((float(x), float(y), float(z)))
            elif word == "f":
                # counted from 1, or backwards from the last point
                numbers = [int(corner.partition("/")[0]) for corner in rest]
                counts, corners = faces.setdefault(material, (array("q"), array("q")))
                counts.append(len(numbers))
                corners.extend(k - 1 if k > 0 else len(points) // 3 + k for k in numbers)
                triangles += max(len(numbers) - 2, 0)
                _limit(triangles)
            elif word == "usemtl":
                material = " ".join(rest)
            elif word == "mtllib":
                colors |= _read_colors(folder, " ".join(rest))
        except (ValueError, OverflowError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"line {number}: expected numbers, got {line.strip()!r}") from None
    places = np.array(points).reshape(-1, 3)
    try:
        return tuple(
            Surface(places[np.array(corners)[fan(np.array(counts))]], colors.get(name))
            for name, (counts, corners) in faces.items()
        )
    except IndexError:
        raise InputError(
            f"expected faces between {len(places)} points of three numbers, got others"
        ) from None


def _read_colors(folder: Path, name: str) -> dict[str, Rgba]:
    """The diffuse color and opacity of each material of a library in the folder or below it."""
    library = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts or not library.is_file():
        return {}
    with library.open(encoding="utf-8", errors="replace") as lines:
        return _colors(islice(lines, _MOST_STEPS))


def _colors(lines: Iterable[str]) -> dict[str, Rgba]:
    colors: dict[str, Rgba] = {}
    name = ""
    for line in lines:
        word, *rest = line.split() or [""]
        red, green, blue, opacity = colors.get(name, (0.8, 0.8, 0.8, 1.0))
        if word == "newmtl":
            name = " ".join(rest)
        elif word == "Kd" and len(rest) == 3:
            red, green, blue = (float(x) for x in rest)
            colors[name] = (red, green, blue, opacity)
        elif word in ("d", "Tr") and len(rest) == 1:
            colors[name] = (red, green, blue, float(rest[0]) if word == "d" else 1 - float(rest[0]))
    return colors


Number = TypeVar("Number", np.int64, np.float64)

_WHITE: Rgba = (1.0, 1.0, 1.0, 1.0)
_DEEPEST = 40


def read_collada(data: bytes) -> tuple[Surface, ...]:
    """Read a COLLADA file."""
    try:
        root = tree_of(data)
    except XmlRefusedError as error:
        raise InputError(f"expected a COLLADA file, got one that is no XML: {error}") from None
    try:
        unit = root.find("asset/unit")
        scale = float(unit.get("meter", 1)) if unit is not None else 1.0
        return tuple(_Reader(root).surfaces(scale * np.eye(4)))
    except (LookupError, ValueError, ArithmeticError, AttributeError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"expected a COLLADA file, got one with something missing or wrong: {error!r}"
        ) from None


@final
class _Reader:
    """A document whose elements refer to one another by id."""

    def __init__(self, root: Element) -> None:
        self._root = root
        self._named = {element.get("id"): element for element in root.iter() if element.get("id")}
        self._steps = self._triangles = 0
        # what many instances share is read once
        self._read = dict[Element, Array]()

    def _resolve(self, url: str | None) -> Element:
        return self._named[(url or "").removeprefix("#")]

    def surfaces(self, pose: Array) -> Iterator[Surface]:
        shown = self._root.find("scene/instance_visual_scene")
        if shown is not None:
            yield from self._node(self._resolve(shown.get("url")), pose, 0)

    def _node(self, node: Element, pose: Array, depth: int) -> Iterator[Surface]:
        if depth > _DEEPEST:
            raise ValueError("endlessly nested nodes")
        self._step()
        for child in node:
            kind = child.tag
            if kind in _TRANSFORMS:
                pose = pose @ _TRANSFORMS[kind](_numbers(child.text, np.float64))
            elif kind == "node":
                yield from self._node(child, pose, depth + 1)
            elif kind == "instance_node":
                yield from self._node(self._resolve(child.get("url")), pose, depth + 1)
            elif kind in ("instance_geometry", "instance_controller"):
                yield from self._instance(child, pose)

    def _step(self) -> None:
        self._steps += 1
        if self._steps > _MOST_STEPS:
            raise InputError(f"expected at most {_MOST_STEPS:,} nodes and instances, got more")

    def _instance(self, instance: Element, pose: Array) -> Iterator[Surface]:
        geometry = self._resolve(instance.get("url"))
        if (skin := geometry.find("skin")) is not None:
            geometry = self._resolve(skin.get("source"))
        bound = {
            binding.get("symbol"): binding.get("target")
            for binding in instance.iter()
            if binding.tag == "instance_material"
        }
        for part in geometry.findall("mesh/*"):
            self._step()
            if part.tag in ("triangles", "polylist", "polygons"):
                if part not in self._read:
                    self._read[part] = self._corners(part)
                self._triangles += len(self._read[part])
                _limit(self._triangles)
                corners = self._read[part] @ pose[:3, :3].T + pose[:3, 3]
                yield Surface(corners, self._color(bound.get(part.get("material"))))

    def _corners(self, part: Element) -> Array:
        """The corners of a list of triangles or polygons."""
        inputs = part.findall("input")
        stride = 1 + max(int(entry.get("offset", 0)) for entry in inputs)
        vertex = next(entry for entry in inputs if entry.get("semantic") == "VERTEX")
        lists = [_numbers(p.text, np.int64).reshape(-1, stride) for p in part.findall("p")]
        if not lists:
            return np.empty((0, 3, 3))
        rows = np.concatenate(lists)[:, int(vertex.get("offset", 0))]
        if part.tag == "triangles":
            places = np.arange(len(rows)).reshape(-1, 3)
        elif part.tag == "polygons":
            places = fan(np.array([len(polygon) for polygon in lists]))
        else:
            counts = _numbers(part.findtext("vcount"), np.int64)
            if (counts < 0).any() or counts.astype(float).sum() > len(rows):
                raise ValueError("polygons with more corners than there are")
            places = fan(counts)
        positions = next(
            entry
            for entry in self._resolve(vertex.get("source"))
            if entry.get("semantic") == "POSITION"
        )
        return self._floats(positions.get("source"))[rows[places]]

    def _floats(self, url: str | None) -> Array:
        source = self._resolve(url)
        if source not in self._read:
            accessor = source.find("technique_common/accessor")
            stride = int(accessor.get("stride", 1)) if accessor is not None else 3
            values = _numbers(source.findtext("float_array"), np.float64)
            self._read[source] = values.reshape(-1, stride)[:, :3]
        return self._read[source]

    def _color(self, url: str | None) -> Rgba | None:
        """A material's diffuse color; white where a texture gives it."""
        used = None if url is None else self._resolve(url).find("instance_effect")
        if used is None:
            return None
        for shading in self._resolve(used.get("url")).findall("profile_COMMON/technique/*"):
            if (diffuse := shading.find("diffuse")) is not None:
                red, green, blue, _ = _rgba(diffuse.find("color")) or _WHITE
                return red, green, blue, _opacity(shading)
        return None


def _numbers(text: str | None, kind: type[Number]) -> NDArray[Number]:
    """The numbers of a list; raises ValueError where something else stands among them."""
    if not (text or "").strip():
        return np.empty(0, dtype=kind)
    with warnings.catch_warnings():
        # NumPy before 2.3 only warns, and returns what stands before
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text or "", dtype=kind, sep=" ")
        except DeprecationWarning as error:
            raise ValueError(str(error)) from None


def _opacity(shading: Element) -> float:
    """Opacity by COLLADA 1.4.1's four rules for `opaque`; 0 is taken as a slip for 1."""
    transparent, factor = (
        shading.find("transparent"),
        shading.findtext("transparency/float"),
    )
    if transparent is None and factor is None:
        return 1.0
    rule = "A_ONE" if transparent is None else transparent.get("opaque", "A_ONE")
    color = (None if transparent is None else _rgba(transparent.find("color"))) or _WHITE
    share = (color[3] if rule.startswith("A") else color[0]) * float(factor or 1)
    opacity = share if rule.endswith("ONE") else 1 - share
    return opacity if 0.01 < opacity < 1 else 1.0


def _rgba(color: Element | None) -> Rgba | None:
    if color is None or not color.text:
        return None
    red, green, blue, *rest = (float(x) for x in color.text.split())
    return red, green, blue, rest[0] if rest else 1.0


def _rotate(axis_and_angle: Array) -> Array:
    *axis, angle = axis_and_angle
    return pose_at(turn=turn_about(axis, np.radians(angle)))


_TRANSFORMS: Mapping[str, Callable[[Array], Array]] = {
    "matrix": lambda numbers: numbers.reshape(4, 4),
    "translate": pose_at,
    "rotate": _rotate,
    "scale": lambda factors: np.diag([*factors, 1.0]),
}


def read_mesh(path: Path) -> tuple[Surface, ...]:
    """Read the surfaces of an STL, OBJ or DAE file, one for each color."""
    if not path.is_file():
        raise InputError(f"mesh file {path}: there is no such file")
    form = path.suffix.lower().lstrip(".")
    try:
        if form not in ("stl", "dae", "obj"):
            raise InputError(f"expected STL, OBJ or DAE, got {form!r}")
        if (size := path.stat().st_size) > MOST_BYTES:
            raise InputError(f"expected at most {MOST_BYTES:,} bytes, got {size:,}")
        data = path.read_bytes()
        if (mistaken := recognize(data)) is not None:
            raise InputError(f"it is {mistaken[0]}; {mistaken[1][0].lower()}{mistaken[1][1:-1]}")
        if form == "stl":
            surfaces = read_stl(data)
        elif form == "dae":
            surfaces = read_collada(data)
        else:
            surfaces = read_obj(data, path.parent)
        if not all(np.isfinite(surface.corners).all() for surface in surfaces):
            raise InputError("expected finite numbers, got some that are not")
        return by_color(surfaces)
    except OSError as error:
        raise InputError(f"mesh file {path}: {error.strerror or error}") from None
    except InputError as error:
        raise InputError(f"mesh file {path}: {error}") from None
