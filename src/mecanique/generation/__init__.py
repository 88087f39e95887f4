"""Write equations as code: one straight-line program in many languages, run and compared."""

from mecanique.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
