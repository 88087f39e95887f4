"""A mechanism as a whole: its parts, what makes them sound, its states and its variants."""

from mecanique.model.mechanism.mechanism import Mechanism

__all__ = ["Mechanism"]
