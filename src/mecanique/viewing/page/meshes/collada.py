"""COLLADA files: triangles and polygons, placed by the scene's nodes, with their materials' colors.

The file's unit is applied; its up axis is not, because a URDF's frames are the mesh's own.
Textures, lights, cameras and animations are left out; a skin is drawn in its original pose.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import TypeVar, final
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import InputError
from mecanique.safe_xml import XmlRefusedError, tree_of
from mecanique.viewing.page.meshes.surface import Surface, fan
from mecanique.viewing.scene.scene import Floats, Rgba

Number = TypeVar("Number", np.int64, np.float64)

_WHITE: Rgba = (1.0, 1.0, 1.0, 1.0)
_DEEPEST = 40


def read_collada(data: bytes) -> tuple[Surface, ...]:
    """Read a COLLADA file.

    Raises:
        InputError: if it is not XML, or refers to elements it does not contain.
    """
    try:
        root = tree_of(data)
    except XmlRefusedError as error:
        raise InputError(f"expected a COLLADA file, got one that is no XML: {error}") from None
    unit = root.find("asset/unit")
    scale = float(unit.get("meter", 1)) if unit is not None else 1.0
    try:
        return tuple(_Reader(root).surfaces(scale * np.eye(4)))
    except (KeyError, IndexError, ValueError, AttributeError) as error:
        raise InputError(
            f"expected a COLLADA file, got one with something missing or wrong: {error!r}"
        ) from None


@final
class _Reader:
    """A document whose elements refer to one another by id."""

    def __init__(self, root: Element) -> None:
        self._root = root
        self._named = {each.get("id"): each for each in root.iter() if each.get("id")}

    def _resolve(self, url: str | None) -> Element:
        return self._named[(url or "").removeprefix("#")]

    def surfaces(self, pose: Floats) -> Iterator[Surface]:
        shown = self._root.find("scene/instance_visual_scene")
        if shown is not None:
            yield from self._node(self._resolve(shown.get("url")), pose, 0)

    def _node(self, node: Element, pose: Floats, depth: int) -> Iterator[Surface]:
        if depth > _DEEPEST:
            raise ValueError("endlessly nested nodes")
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

    def _instance(self, instance: Element, pose: Floats) -> Iterator[Surface]:
        geometry = self._resolve(instance.get("url"))
        if (skin := geometry.find("skin")) is not None:
            geometry = self._resolve(skin.get("source"))
        bound = {
            each.get("symbol"): each.get("target")
            for each in instance.iter()
            if each.tag == "instance_material"
        }
        for part in geometry.findall("mesh/*"):
            if part.tag in ("triangles", "polylist", "polygons"):
                corners = self._corners(part) @ pose[:3, :3].T + pose[:3, 3]
                yield Surface(corners, self._color(bound.get(part.get("material"))))

    def _corners(self, part: Element) -> Floats:
        """The corners of a list of triangles or polygons."""
        inputs = part.findall("input")
        stride = 1 + max(int(each.get("offset", 0)) for each in inputs)
        vertex = next(each for each in inputs if each.get("semantic") == "VERTEX")
        lists = [_numbers(p.text, np.int64).reshape(-1, stride) for p in part.findall("p")]
        if not lists:
            return np.empty((0, 3, 3))
        rows = np.concatenate(lists)[:, int(vertex.get("offset", 0))]
        if part.tag == "triangles":
            places = np.arange(len(rows)).reshape(-1, 3)
        elif part.tag == "polygons":
            places = fan(np.array([len(each) for each in lists]))
        else:
            places = fan(_numbers(part.findtext("vcount"), np.int64))
        positions = next(
            each
            for each in self._resolve(vertex.get("source"))
            if each.get("semantic") == "POSITION"
        )
        return self._floats(positions.get("source"))[rows[places]]

    def _floats(self, url: str | None) -> Floats:
        source = self._resolve(url)
        accessor = source.find("technique_common/accessor")
        stride = int(accessor.get("stride", 1)) if accessor is not None else 3
        values = _numbers(source.findtext("float_array"), np.float64)
        return values.reshape(-1, stride)[:, :3]

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


def _translate(xyz: Floats) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = xyz
    return pose


def _rotate(axis_and_angle: Floats) -> Floats:
    """Rodrigues' formula: R = 1 + sin α K + (1 − cos α) K²."""
    x, y, z = axis_and_angle[:3] / np.linalg.norm(axis_and_angle[:3])
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(axis_and_angle[3])
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    return pose


def _transform(numbers: Floats) -> Floats:
    return numbers.reshape(4, 4)


def _scale(factors: Floats) -> Floats:
    return np.diag([*factors, 1.0])


_TRANSFORMS = {"matrix": _transform, "translate": _translate, "rotate": _rotate, "scale": _scale}
