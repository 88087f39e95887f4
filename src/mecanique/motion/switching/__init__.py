"""Mechanics with corners: modes of elements that switch, and which of them follows."""
