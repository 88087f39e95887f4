"""Compare the in-house derivation with the engine: a Verdict, quantity by quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mecanique.lazy import import_name

if TYPE_CHECKING:
    from mecanique.verification.compare import verify
    from mecanique.verification.transformation import Transformation, compare_coordinates
    from mecanique.verification.verdict import Cause, Row, Verdict

__all__ = ["Cause", "Row", "Transformation", "Verdict", "compare_coordinates", "verify"]

_HOMES = {
    "Cause": ".verdict",
    "Row": ".verdict",
    "Transformation": ".transformation",
    "Verdict": ".verdict",
    "compare_coordinates": ".transformation",
    "verify": ".compare",
}
"""The module of each name; each is imported when it is first used, as the engine takes long."""


def __getattr__(name: str) -> Any:
    return import_name(__name__, name, _HOMES)
