"""The package that computes: Pinocchio, or where it is not installed, its stand-in."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from typing import Any

from mecanique.lazy import keep_garbage

__all__ = ["MISSING", "STAND_IN", "engine_name", "engine_package", "has_pinocchio"]

STAND_IN = "stand-in"
"""What the stand-in is called."""

MISSING = (
    "The engine Pinocchio is not installed: a stand-in of mecanique's own took its place. Install "
    "it from conda-forge (package pinocchio), or by pip install pin on Linux and macOS."
)
"""What a verdict without the engine says first."""


@cache
def has_pinocchio() -> bool:
    """Return whether Pinocchio is installed."""
    return find_spec("pinocchio") is not None


def engine_name() -> str:
    """Return what the engine is called in a verdict."""
    return "Pinocchio" if has_pinocchio() else STAND_IN


@cache
def engine_package() -> Any:
    """Return the package pinocchio, or what stands in for it."""
    if has_pinocchio():
        with keep_garbage():
            import pinocchio

        return pinocchio
    from mecanique.reference import standin

    return standin
