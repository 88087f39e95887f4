"""Equilibria, linearization, modes and frequency response."""
