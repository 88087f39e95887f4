"""Mechanisms as URDF text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mecanique.lazy import import_name

if TYPE_CHECKING:
    from mecanique.urdf.read import read_urdf
    from mecanique.urdf.write import write_urdf

__all__ = ["read_urdf", "write_urdf"]

_HOMES = {"read_urdf": ".read", "write_urdf": ".write"}
"""The module of each name; a mechanism that was not read from a file needs no reader."""


def __getattr__(name: str) -> Any:
    return import_name(__name__, name, _HOMES)
