"""Bodies, their shapes and how they look."""

from mecanique.model.bodies.body import Body

__all__ = ["Body"]
