"""Every equation of motion, derived independently, checked against an engine, then set in motion."""

from mecanique import textbook
from mecanique.errors import MecaniqueError

__all__ = ["MecaniqueError", "textbook"]
__version__ = "0.1.0"
