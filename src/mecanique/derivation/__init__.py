"""In-house mechanics: equations of motion derived from the description alone."""

from __future__ import annotations

from mecanique.derivation.methods import METHODS, derive, readable

__all__ = ["METHODS", "derive", "readable"]
