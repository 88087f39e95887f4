"""Compare the in-house derivation with the engine: a Verdict, quantity by quantity."""

from mecanique.verification.causes.cause import Cause
from mecanique.verification.compare import verify
from mecanique.verification.transformation import Transformation, compare_coordinates
from mecanique.verification.verdict import Row, Verdict

__all__ = ["Cause", "Row", "Transformation", "Verdict", "compare_coordinates", "verify"]
