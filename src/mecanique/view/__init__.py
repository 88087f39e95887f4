"""Pictures of a motion: the scene as pure data, one offline page, a live view."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mecanique.view.live import LiveView
    from mecanique.view.page import page, write_page

__all__ = ["LiveView", "page", "write_page"]

_HOMES = {"LiveView": "mecanique.view.live", "page": "mecanique.view.page", "write_page": "mecanique.view.page"}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
