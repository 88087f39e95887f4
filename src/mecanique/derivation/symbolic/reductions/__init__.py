"""Reduce the number of equations: by conserved momenta, and by closed loops."""
