"""Constraints in closed form besides those of the joints: loops, contacts, velocity constraints."""
