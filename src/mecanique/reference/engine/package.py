"""The package that computes: Pinocchio, or where it is not installed, its stand-in."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from typing import Any

__all__ = ["MISSING", "engine_package", "has_pinocchio"]

MISSING = (
    "Pinocchio is not installed, and its own stand-in took its place: this compares mecanique with "
    "mecanique. Get the engine by conda install -c conda-forge pinocchio, or pip install pin on "
    "Linux and macOS."
)
"""What a verdict without the engine says first."""


@cache
def has_pinocchio() -> bool:
    """Return whether Pinocchio is installed."""
    return find_spec("pinocchio") is not None


@cache
def engine_package() -> Any:
    """Return the package pinocchio, or what stands in for it."""
    if has_pinocchio():
        import pinocchio

        return pinocchio
    from mecanique.reference import standin

    return standin
