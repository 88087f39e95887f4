"""Equations of motion: derived independently, checked against an engine, then set in motion."""

from mecanique import viewing  # noqa: F401 lets motions show themselves; imports no numpy
from mecanique.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
