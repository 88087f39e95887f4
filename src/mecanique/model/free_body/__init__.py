"""States of bodies that move freely, in the conventions of those who give and read them."""

from mecanique.model.free_body.state import FloatingState, floating, floating_state

__all__ = ["FloatingState", "floating", "floating_state"]
