"""Mesh files by their ending."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mecanique.errors import InputError
from mecanique.viewing.page.meshes.collada import read_collada
from mecanique.viewing.page.meshes.stl import read_stl
from mecanique.viewing.page.meshes.surface import Surface, by_color
from mecanique.viewing.page.meshes.wavefront import read_obj


def read_mesh(path: Path) -> tuple[Surface, ...]:
    """Read the surfaces of a mesh file, one for each color.

    Args:
        path: an STL, OBJ or DAE file.

    Raises:
        InputError: if there is no such file, its format is another, or it is broken.
    """
    if not path.is_file():
        raise InputError(f"mesh file {path}: there is no such file")
    form = path.suffix.lower().lstrip(".")
    try:
        if form == "stl":
            surfaces = read_stl(path.read_bytes())
        elif form == "dae":
            surfaces = read_collada(path.read_bytes())
        elif form == "obj":
            surfaces = read_obj(path.read_text(encoding="utf-8", errors="replace"), path.parent)
        else:
            raise InputError(f"expected STL, OBJ or DAE, got {form!r}")
        if not all(np.isfinite(surface.corners).all() for surface in surfaces):
            raise InputError("expected finite numbers, got some that are not")
    except InputError as error:
        raise InputError(f"mesh file {path}: {error}") from None
    return by_color(surfaces)
