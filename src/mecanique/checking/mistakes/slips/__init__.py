"""Slips in a whole derivation, each with the equations it gives."""
