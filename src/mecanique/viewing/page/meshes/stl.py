"""STL files, binary or text."""

from __future__ import annotations

import numpy as np

from mecanique.errors import InputError
from mecanique.viewing.page.meshes.surface import Surface

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_HEAD = 84


def read_stl(data: bytes) -> tuple[Surface, ...]:
    """Read the triangles of an STL file.

    Args:
        data: its bytes; binary if their number is what the head states, text otherwise.

    Raises:
        InputError: if it is neither.
    """
    count = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
    if len(data) >= _HEAD + count * _FACET.itemsize and not (
        data.startswith(b"solid") and b"facet" in data[:1000]
    ):
        facets = np.frombuffer(data, _FACET, count, _HEAD)
        return (Surface(facets["corners"].astype(np.float64)),)
    words = data.split()
    places = [k for k, word in enumerate(words) if word == b"vertex"]
    try:
        numbers = np.array([words[k + 1 : k + 4] for k in places], dtype=np.float64)
        return (Surface(numbers.reshape(-1, 3, 3)),)
    except ValueError:
        raise InputError(
            "expected an STL file, got one that breaks off or holds no triangles"
        ) from None
