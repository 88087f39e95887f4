"""In-house mechanics: equations of motion derived from the description alone."""

from __future__ import annotations

from mecanique.derivation.methods import METHODS, derive, readable
from mecanique.derivation.reduction import Reduction, routh

__all__ = ["METHODS", "Reduction", "derive", "readable", "routh"]
