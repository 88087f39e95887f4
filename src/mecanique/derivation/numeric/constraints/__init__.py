"""Constraints of loops and contacts in numbers, and the constrained equations of motion."""
