"""Choose the engine: Pinocchio, or its stand-in where Pinocchio is not installed."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from typing import Any

from mecanique.lazy import keep_garbage

STAND_IN = "stand-in"
"""The name of the stand-in."""

MISSING = (
    "The engine Pinocchio is not installed: a stand-in of mecanique's own took its place. Install "
    "it from conda-forge (package pinocchio), or by pip install pin on Linux and macOS."
)
"""The first sentence of a verdict without Pinocchio."""


@cache
def has_pinocchio() -> bool:
    """Return whether Pinocchio is installed."""
    return find_spec("pinocchio") is not None


def engine_name() -> str:
    """Return the name of the engine in a verdict."""
    return "Pinocchio" if has_pinocchio() else STAND_IN


@cache
def engine_package() -> Any:
    """Return the package pinocchio, or its stand-in."""
    if has_pinocchio():
        with keep_garbage():
            import pinocchio

        return pinocchio
    from mecanique.reference import standin

    return standin
