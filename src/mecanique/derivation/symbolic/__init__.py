"""Derivations in letters: Lagrange, Newton–Euler and virtual work on Poisson series."""
