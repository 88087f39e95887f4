"""Wavefront OBJ files and the colors of their material libraries."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from mecanique.errors import InputError
from mecanique.viewing.page.meshes.surface import Surface, fan
from mecanique.viewing.scene.scene import Rgba


def read_obj(text: str, folder: Path) -> tuple[Surface, ...]:
    """Read the faces of an OBJ file, material by material.

    Args:
        text: the file.
        folder: where its material libraries are; a missing one is ignored.

    Raises:
        InputError: if a line cannot be understood.
    """
    points: list[list[float]] = []
    faces: dict[str, list[list[int]]] = {}
    colors: dict[str, Rgba] = {}
    material = ""
    for number, line in enumerate(text.splitlines(), 1):
        word, *rest = line.split() or [""]
        try:
            if word == "v":
                points.append([float(x) for x in rest[:3]])
            elif word == "f":
                # counted from 1, or backwards from the last point
                corners = [int(corner.partition("/")[0]) for corner in rest]
                faces.setdefault(material, []).append(
                    [k - 1 if k > 0 else len(points) + k for k in corners]
                )
            elif word == "usemtl":
                material = " ".join(rest)
            elif word == "mtllib" and (beside := folder / " ".join(rest)).is_file():
                colors |= _colors(beside.read_text(encoding="utf-8", errors="replace").splitlines())
        except ValueError:
            raise InputError(f"line {number}: expected numbers, got {line.strip()!r}") from None
    try:
        places = np.array(points, dtype=np.float64).reshape(-1, 3)
        return tuple(
            Surface(places[_triangles(each)], colors.get(name)) for name, each in faces.items()
        )
    except (ValueError, IndexError):
        raise InputError(
            f"expected faces between {len(points)} points of three numbers, got others"
        ) from None


def _triangles(faces: list[list[int]]) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    flat = np.array([corner for face in faces for corner in face], dtype=np.int64)
    return flat[fan(np.array([len(face) for face in faces], dtype=np.int64))]


def _colors(lines: Iterable[str]) -> dict[str, Rgba]:
    """The diffuse color and opacity of each material."""
    found: dict[str, Rgba] = {}
    name = ""
    for line in lines:
        word, *rest = line.split() or [""]
        red, green, blue, opacity = found.get(name, (0.8, 0.8, 0.8, 1.0))
        if word == "newmtl":
            name = " ".join(rest)
        elif word == "Kd" and len(rest) == 3:
            red, green, blue = (float(x) for x in rest)
            found[name] = (red, green, blue, opacity)
        elif word in ("d", "Tr") and len(rest) == 1:
            found[name] = (red, green, blue, float(rest[0]) if word == "d" else 1 - float(rest[0]))
    return found
