"""Write equations as code: one straight-line program in many languages, run and compared."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mecanique.lazy import import_name

if TYPE_CHECKING:
    from mecanique.generation.code import Code
    from mecanique.generation.languages import generate
    from mecanique.generation.writing.recursion import write_recursion

__all__ = ["Code", "generate", "write_recursion"]

_HOMES = {
    "Code": ".code",
    "generate": ".languages",
    "write_recursion": ".writing.recursion",
}
"""The module of each name, imported when first used, as a motion needs few of them."""


def __getattr__(name: str) -> Any:
    return import_name(__name__, name, _HOMES)
