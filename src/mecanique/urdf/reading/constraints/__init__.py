"""Loops, contacts, elements that guide and constraints on velocities in a URDF."""
