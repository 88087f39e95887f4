"""Mechanisms as URDF text."""

from mecanique.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
