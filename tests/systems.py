"""Systems of the catalogue by kind, and what many tests ask of them, computed once a process."""

from __future__ import annotations

from functools import cache

from mecanique import textbook
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations

__all__ = ["CLOSED", "FREE", "TREES", "derive_system"]

TREES = tuple(name for name in textbook.names() if not textbook.load(name).loops)
"""Systems without loops; some of them roll or slide."""

CLOSED = tuple(name for name in textbook.names() if textbook.load(name).loops)
"""Systems with loops."""

FREE = tuple(name for name in TREES if not textbook.load(name).constrained)
"""Systems in which every velocity is free."""


@cache
def derive_system(name: str, method: str = "lagrange") -> Equations:
    """Return the equations of a system with its typical values; they are frozen."""
    return derive(textbook.load(name), method)
