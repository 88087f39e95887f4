"""Fewer equations from the same mechanics: by conserved momenta, and by closed loops."""
