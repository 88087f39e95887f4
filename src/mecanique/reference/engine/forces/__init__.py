"""Compute the forces on the engine's bodies: loads, forces of elements, and reactions."""
