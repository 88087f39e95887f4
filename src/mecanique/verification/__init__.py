"""Compare the in-house derivation with the engine: a Verdict, quantity by quantity."""

from mecanique.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
