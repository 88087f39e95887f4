"""Slips in a whole derivation, each with the equations that it leads to."""
